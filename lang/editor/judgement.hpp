// The numbers of `check` while a script is edited: found beside the editing, on a thread of their
// own, for problems that are small.
#pragma once

#include "lang/session.hpp"

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace hvi::lang {

/// Beyond so many unknowns `check` may take long: then it is not asked for.
inline constexpr int most_unknowns_judged = 3000;

/// One script at a time; what is asked for later takes the place of what waits.
class Judgement {
public:
  /// `ready` is called from the other thread when there is something new to show.
  explicit Judgement(std::function<void()> ready);
  ~Judgement();
  Judgement(const Judgement&) = delete;
  Judgement& operator=(const Judgement&) = delete;

  /// Unless this very text was judged last. Returns at once: what is being judged is asked to end,
  /// which it does after its step.
  void ask(const std::string& path, const std::string& text, const CompileSettings& settings);
  /// What was found of a script, if it is the last one that was asked for.
  [[nodiscard]] std::optional<std::string> of(const std::string& path) const;

private:
  void work();
  std::string judged(const std::string& path, const std::string& text, CompileSettings settings);

  std::function<void()> ready_;
  mutable std::mutex mutex_;
  std::condition_variable asked_;
  std::string path_, text_; ///< asked for
  CompileSettings settings_;
  bool waits_ = false;                ///< is there anything to judge?
  bool over_ = false;                 ///< the server ends
  std::optional<std::string> result_; ///< of what was asked for
  std::atomic<bool> stop_ = false;
  std::thread thread_; ///< last: it uses the others
};

/// One line: unknowns, steps, margin and verdict; the first mistake where there is one.
[[nodiscard]] std::string judgement_of(Session& session, const std::atomic<bool>& stop);

} // namespace hvi::lang
