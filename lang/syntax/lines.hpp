// Lines of formatted text between the layout and the output: columns, alignment and wrapping.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace hvi::lang {

/// Widest line that is not wrapped. A comment at its end does not count.
inline constexpr std::size_t max_line_width = 120;
/// Of the lines after the first.
inline constexpr std::size_t continuation_indent = 4;

/// A token on its way to the output.
struct Piece {
  std::string text;
  std::size_t blanks = 0;                // before it, unless it begins the line
  int group = -1;                        // aligned with the others of this group
  std::optional<std::size_t> soft_break; // indentation, if the line must be broken
};

struct Line {
  std::size_t indent = 0;
  bool blank_before = false;
  bool begins_statement = false;
  std::vector<Piece> pieces; // none: a line that is a comment only
  std::string comment;
};

/// Characters of the line without its comment.
[[nodiscard]] std::size_t width(const Line& line);

/// Puts pieces of one group into one column by adding blanks before them.
void align_groups(std::vector<Line>& lines, int n_groups);

/// Gives the "=" of consecutive declarations of one line each a common group, from `n_groups` on;
/// returns the new number of groups.
int group_definitions(std::vector<Line>& lines, int n_groups);

/// The same for what documents consecutive parameters; their "=" are aligned already.
int group_documents(std::vector<Line>& lines, int n_groups);

/// Breaks lines that are too wide: at their soft breaks, else behind commas.
[[nodiscard]] std::vector<Line> wrap(std::vector<Line> lines);

/// The text. Comments at the ends of consecutive lines stand in one column.
[[nodiscard]] std::string join(const std::vector<Line>& lines);

} // namespace hvi::lang
