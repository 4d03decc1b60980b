// A script as Python sees it: each question is a session of its own (lang/session.hpp), so that
// questions can be asked by several threads at once.
#pragma once

#include "lang/python/answer.hpp"
#include "lang/python/watched.hpp"

#include <map>
#include <memory>
#include <string>

namespace hvi::python {

using Defines = std::map<std::string, std::string>; ///< parameter -> value, as a parameter is given

/// How a run is made.
struct RunAsked {
  std::string output; ///< folder; empty: no files
  bool monitors = false;
  int keep_every = 0; ///< every so many steps the unknowns are kept; 0: none are
  double accuracy = 0.0;
  std::string accuracy_of;
  double budget = 3600.0;
};

/// Mesh, space, and what was assembled, ordered and factored on them, for runs whose parameters
/// leave them as they are. One run at a time.
class Shared {
public:
  /// Those of the session's plan: made by it, where they are not those of the last time.
  lang::Exit prepare(const std::shared_ptr<lang::Session>& session, const std::atomic<bool>* stop);
  const solver::Discretisation& discretisation() const { return made_by_->discretisation; }
  std::mutex& turn() { return turn_; }

private:
  std::mutex turn_;
  std::string key_;
  std::shared_ptr<lang::Session> made_by_;
};

class Model {
public:
  Model(std::string path, std::optional<std::string> text, bool allow_geo)
      : path_(std::move(path)), text_(std::move(text)), allow_geo_(allow_geo) {}

  /// Parameters, unknowns, columns and the study of the script; or its mistakes.
  Answer describe(const Defines& defines) const;
  Answer run(const Defines& defines, const RunAsked& how, Watch& watch, Shared* shared) const;
  /// hvi-check/1, after the first step has shown that the forms determine the unknown.
  Answer check(const Defines& defines, Watch& watch) const;
  /// hvi-plan/1.
  Answer plan(const Defines& defines, Watch& watch) const;
  std::shared_ptr<lang::Session> session(const Defines& defines) const;

private:
  std::string path_;
  std::optional<std::string> text_;
  bool allow_geo_;
};

} // namespace hvi::python
