// Edit distance and the nearest name, see suggest.hpp.
#include "lang/diag/suggest.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>
#include <vector>

namespace hvi::lang {
namespace {

// Names longer than this are not typed by hand; the distance is quadratic in the length.
constexpr std::size_t longest = 64;

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

// Edits that may still be a slip: none in one letter, then one in three letters.
std::size_t most_edits(std::string_view wrong, std::string_view candidate) {
  return std::min<std::size_t>(3, std::max(wrong.size(), candidate.size()) / 3);
}

// In names of two letters only a swap is a slip.
bool near(std::size_t distance, std::string_view wrong, std::string_view candidate) {
  if (wrong.size() == 2 && candidate.size() == 2)
    return wrong[0] == candidate[1] && wrong[1] == candidate[0];
  return distance <= most_edits(wrong, candidate) && wrong.size() > 1;
}

// The distance is at least the difference of the lengths: most candidates need no table.
bool too_different(std::string_view wrong, std::string_view candidate) {
  const std::size_t difference = wrong.size() > candidate.size() ? wrong.size() - candidate.size()
                                                                 : candidate.size() - wrong.size();
  return difference > most_edits(wrong, candidate);
}

} // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
  // Three rows of the table d(i, j) = distance of the first i of a and the first j of b
  // (R. A. Wagner, M. J. Fischer, The string-to-string correction problem, J. ACM 21 (1974)
  // 168-173; swaps: F. J. Damerau, A technique for computer detection and correction of spelling
  // errors, Commun. ACM 7 (1964) 171-176).
  const std::size_t width = b.size() + 1;
  std::array<std::size_t, 3 * (longest + 1)> usual{};
  std::vector<std::size_t> larger(b.size() > longest ? 3 * width : 0);
  std::size_t* before = larger.empty() ? usual.data() : larger.data();
  std::size_t *last = before + width, *row = last + width;
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::swap(before, last);
    std::swap(last, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = a[i - 1] == b[j - 1] ? 0 : 1;
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row[b.size()];
}

void Suggestion::consider(std::string_view candidate) {
  if (candidate == wrong_ || candidate.size() > longest || wrong_.size() > longest) return;
  if (too_different(wrong_, candidate)) return;
  const std::string a = lower(wrong_);
  const std::string b = lower(candidate);
  const std::size_t distance = edit_distance(a, b);
  if (distance > 0 && !near(distance, a, b)) return;
  // A different first letter is the rarer slip, so it loses a tie.
  const std::size_t cost = 2 * distance + (!a.empty() && !b.empty() && a[0] != b[0] ? 1 : 0);
  if (best_ && best_cost_ <= cost) return;
  best_ = candidate;
  best_cost_ = cost;
}

std::string Suggestion::help() const { return best_ ? "did you mean `" + *best_ + "`?" : ""; }

} // namespace hvi::lang
