// What `check` finds behind the plan while a script is edited: mistakes that show on the mesh and
// in the first step, and numbers. Found beside the editing, on a thread of their own.
#pragma once

#include "lang/editor/positions.hpp"
#include "lang/session.hpp"

#include <nlohmann/json.hpp>

#include <atomic>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace hvi::lang {

/// Beyond so many unknowns `check` may take long: then the first step and the numbers are left to
/// it.
inline constexpr int most_unknowns_judged = 3000;

/// Scripts one after the other, those asked for last first.
class Judgement {
public:
  /// `ready` is called from the other thread when there is something new to show.
  explicit Judgement(std::function<void()> ready);
  ~Judgement();
  Judgement(const Judgement&) = delete;
  Judgement& operator=(const Judgement&) = delete;

  /// Returns at once: what is being judged is asked to end, which it does after its step, and
  /// begins again later.
  void ask(const std::string& path, const std::string& text, const CompileSettings& settings,
           CharacterUnit unit);
  /// A script that is closed.
  void forget(const std::string& path);
  /// The numbers of a script, of the text that was judged last.
  [[nodiscard]] std::optional<std::string> numbers_of(const std::string& path) const;
  /// The scripts that have been judged since this was asked last.
  [[nodiscard]] std::vector<std::string> newly_judged();
  /// All messages of a script, if this is the text that was judged.
  [[nodiscard]] std::optional<nlohmann::json> messages_of(const std::string& path,
                                                          const std::string& text) const;

private:
  struct Request {
    std::string path, text;
    CompileSettings settings;
    CharacterUnit unit = CharacterUnit::utf16;
  };
  struct Found {
    std::string text; ///< that was judged
    std::string numbers;
    nlohmann::json messages; ///< null: not known
  };
  void work();
  [[nodiscard]] Found judged(const Request& request) const;

  std::function<void()> ready_;
  mutable std::mutex mutex_;
  std::condition_variable asked_;
  std::vector<Request> waiting_;       ///< the next one last
  std::string at_hand_, text_at_hand_; ///< of what is being judged: its path and its text
  bool dropped_ = false;               ///< nobody wants that any more
  bool over_ = false;                  ///< the server ends
  std::map<std::string, Found> found_; ///< by path
  std::vector<std::string> newly_found_;
  std::atomic<bool> stop_ = false;
  std::thread thread_; ///< last: it uses the others
};

} // namespace hvi::lang
