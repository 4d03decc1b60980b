// The names that a script and its imports declare. Their values are found by whoever evaluates.
#pragma once

#include "lang/check/mistakes.hpp"
#include "lang/check/scope.hpp"

#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

namespace hvi::lang {

struct Declaration {
  enum class State { untouched, busy, done };
  std::string name;
  Span span; ///< of the name
  int program = 0;
  const ast::Statement* statement = nullptr;
  State state = State::untouched;
  Value value = Poison{};
  bool used = false;
};

class Names {
public:
  Names(const std::vector<ast::Program>& programs, const ast::Find* find, Mistakes& mistakes)
      : programs_(programs), find_(find), mistakes_(mistakes) {}

  /// Reads all declarations; what is wrong with their names is reported.
  void collect();
  /// The index of a declaration, -1: there is none.
  int find(const std::string& name) const;
  Declaration& operator[](int declaration) {
    return declarations_[static_cast<std::size_t>(declaration)];
  }
  const Declaration& operator[](int declaration) const {
    return declarations_[static_cast<std::size_t>(declaration)];
  }
  int size() const { return static_cast<int>(declarations_.size()); }
  const std::vector<Declaration>& all() const { return declarations_; }

  /// Names whose mistake was reported before: they stand in a statement with an error, or have
  /// letters that no name has.
  bool is_silent(const std::string& name) const;
  /// Could every statement that declares a name be read?
  bool all_readable() const { return silenced_.empty(); }
  /// Poison; reported unless its mistake was.
  Value report_unknown(const Span& span, const std::string& name, const Scope& scope);

private:
  void declare(const ast::Name& name, int program, const ast::Statement& statement);
  bool arguments_differ(const ast::Statement& statement);
  std::string nearest(const std::string& name, const Scope& scope);

  const std::vector<ast::Program>& programs_;
  const ast::Find* const find_;
  Mistakes& mistakes_;
  std::vector<Declaration> declarations_;
  std::unordered_map<std::string, int> by_name_;
  std::set<std::string> silenced_;             ///< names whose statements have syntax errors
  std::map<std::string, std::string> nearest_; ///< what may be meant by names that are unknown
};

} // namespace hvi::lang
