// "did you mean": the candidate spelt most like a wrong name, if one is near enough.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace hvi::lang {

/// Damerau-Levenshtein distance (optimal string alignment): the least number of insertions,
/// deletions, substitutions and swaps of neighbours that turn `a` into `b`. Bytes are compared.
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

/// Looks at candidates one by one and keeps the nearest to `wrong`. Equality up to case wins;
/// otherwise up to one edit in three letters is accepted, so a one-letter name matches nothing.
class Suggestion {
public:
  explicit Suggestion(std::string_view wrong) : wrong_(wrong) {}
  void consider(std::string_view candidate);
  [[nodiscard]] const std::optional<std::string>& best() const { return best_; }
  /// "did you mean `best`?", or nothing to say (empty).
  [[nodiscard]] std::string help() const;

private:
  std::string wrong_;
  std::optional<std::string> best_;
  std::size_t best_cost_ = 0;
};

/// The best of a range of strings.
template <class Range>
[[nodiscard]] std::optional<std::string> suggest(std::string_view wrong, const Range& candidates) {
  Suggestion suggestion(wrong);
  for (const auto& candidate : candidates) suggestion.consider(candidate);
  return suggestion.best();
}

/// "did you mean `x`?" for the best of a range, or an empty text.
template <class Range>
[[nodiscard]] std::string did_you_mean(std::string_view wrong, const Range& candidates) {
  Suggestion suggestion(wrong);
  for (const auto& candidate : candidates) suggestion.consider(candidate);
  return suggestion.help();
}

} // namespace hvi::lang
