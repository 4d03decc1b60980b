// Source lines with carets, see snippet.hpp.
#include "lang/diag/snippet.hpp"

#include "lang/diag/utf8.hpp"

#include <algorithm>

namespace hvi::lang {
namespace {

constexpr std::size_t tab_width = 4;
// Longer lines are cut to a window around the first mark, so that a message stays readable.
constexpr std::size_t longest_line = 240;
constexpr std::size_t shown_before = 80;

// One line as a terminal shows it: tabs are spaces, what cannot be printed is U+FFFD.
class DisplayLine {
public:
  DisplayLine(std::string_view line, std::size_t first_mark);
  [[nodiscard]] const std::string& text() const { return text_; }
  // Terminal column of a byte of the line, clamped to the window.
  [[nodiscard]] std::size_t column(std::size_t byte) const;

private:
  void append(std::string_view line, std::size_t offset, const utf8::Character& character);

  std::string text_;
  std::size_t window_begin_ = 0;
  std::size_t width_ = 0;
  std::vector<std::size_t> columns_; // of each byte of the window
};

DisplayLine::DisplayLine(std::string_view line, std::size_t first_mark) {
  std::size_t end = line.size();
  if (line.size() > longest_line) {
    window_begin_ = first_mark > shown_before ? first_mark - shown_before : 0;
    end = std::min(line.size(), window_begin_ + longest_line);
    const auto inside_character = [&](std::size_t i) {
      return i < line.size() && (static_cast<unsigned char>(line[i]) & 0xC0U) == 0x80U;
    };
    while (window_begin_ < end && inside_character(window_begin_)) ++window_begin_;
    while (end > window_begin_ && inside_character(end)) --end;
  }
  columns_.reserve(end - window_begin_);
  text_.reserve(end - window_begin_ + 6);
  if (window_begin_ > 0) text_ = "...", width_ = 3;
  for (std::size_t i = window_begin_; i < end;) {
    const auto character = utf8::decode(line, i);
    append(line, i, character);
    i += character.length;
  }
  if (end < line.size()) text_ += "...";
}

void DisplayLine::append(std::string_view line, std::size_t offset,
                         const utf8::Character& character) {
  columns_.insert(columns_.end(), character.length, width_);
  if (character.code == U'\t') {
    const std::size_t spaces = tab_width - width_ % tab_width;
    text_.append(spaces, ' ');
    width_ += spaces;
  } else if (!character.valid || character.code < 0x20 || character.code == 0x7F) {
    text_ += utf8::encode(0xFFFD);
    ++width_;
  } else {
    text_.append(line.substr(offset, character.length));
    width_ += static_cast<std::size_t>(utf8::width(character.code));
  }
}

std::size_t DisplayLine::column(std::size_t byte) const {
  const std::size_t index = byte > window_begin_ ? byte - window_begin_ : 0;
  return index < columns_.size() ? columns_[index] : width_;
}

// A mark in terminal columns.
struct Underline {
  std::size_t begin = 0;
  std::size_t end = 0;
  const Mark* mark = nullptr;
};

// A row below a line, painted cell by cell: carets, dashes and the bars that lead to labels.
class Row {
public:
  void put(std::size_t column, char sign, bool primary) {
    if (cells_.size() <= column) cells_.resize(column + 1);
    cells_[column] = {sign, primary};
  }
  void label(std::size_t column, const Mark& mark, const Palette& palette) {
    if (cells_.size() < column) cells_.resize(column);
    tail_ = mark.primary ? palette.primary(mark.text) : palette.secondary(mark.text);
  }
  [[nodiscard]] std::string str(const Palette& palette) const {
    std::string result;
    for (std::size_t i = 0; i < cells_.size();) {
      std::size_t j = i;
      while (j < cells_.size() && cells_[j].sign == cells_[i].sign &&
             cells_[j].primary == cells_[i].primary)
        ++j;
      const std::string run(j - i, cells_[i].sign);
      if (cells_[i].sign == ' ')
        result += run;
      else
        result += cells_[i].primary ? palette.primary(run) : palette.secondary(run);
      i = j;
    }
    return result + tail_;
  }

private:
  struct Cell {
    char sign = ' ';
    bool primary = false;
  };
  std::vector<Cell> cells_;
  std::string tail_;
};

// Rows below one line: the underlines, the rightmost label behind them, other labels hanging:
//
//   foo(bar
//      -   ^ expected `)`
//      |
//      opened here
std::vector<Row> rows_below(const std::vector<Underline>& underlines, const Palette& palette) {
  std::vector<Row> rows(1);
  std::size_t right_end = 0;
  for (const bool primary : {false, true})
    for (const Underline& u : underlines)
      if (u.mark->primary == primary)
        for (std::size_t c = u.begin; c < u.end; ++c) rows[0].put(c, primary ? '^' : '-', primary);
  for (const Underline& u : underlines) right_end = std::max(right_end, u.end);

  std::vector<Underline> hanging;
  for (const Underline& u : underlines)
    if (!u.mark->text.empty()) hanging.push_back(u);
  if (!hanging.empty() && hanging.back().end == right_end) {
    rows[0].label(right_end + 1, *hanging.back().mark, palette);
    hanging.pop_back();
  }
  const auto bars = [&](Row& row, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) row.put(hanging[i].begin, '|', hanging[i].mark->primary);
  };
  if (!hanging.empty()) bars(rows.emplace_back(), hanging.size());
  for (std::size_t n = hanging.size(); n-- > 0;) {
    Row& row = rows.emplace_back();
    bars(row, n);
    // Two labels at one column: the bar of the other must not run into this text.
    row.label(hanging[n].begin, *hanging[n].mark, palette);
  }
  return rows;
}

std::string left_padded(std::size_t number, std::size_t width) {
  const std::string digits = std::to_string(number);
  return std::string(width > digits.size() ? width - digits.size() : 0, ' ') + digits;
}

std::string source_line(int number, const DisplayLine& line, std::size_t gutter,
                        const Palette& palette) {
  std::string result = palette.secondary(left_padded(std::size_t(number), gutter) + " |");
  if (!line.text().empty()) result += " " + line.text();
  return result + "\n";
}

std::string marked_line(const SourceFile& file, const std::vector<Mark>& marks, std::size_t gutter,
                        const Palette& palette) {
  const DisplayLine line(file.line(marks.front().line), marks.front().begin);
  std::vector<Underline> underlines;
  for (const Mark& mark : marks) {
    const std::size_t begin = line.column(mark.begin);
    underlines.push_back({begin, std::max(begin + 1, line.column(mark.end)), &mark});
  }
  std::string result = source_line(marks.front().line, line, gutter, palette);
  for (const Row& row : rows_below(underlines, palette))
    result += palette.secondary(std::string(gutter + 1, ' ') + "|") + " " + row.str(palette) + "\n";
  return result;
}

} // namespace

std::string Palette::primary(std::string_view text) const {
  if (!enabled || text.empty()) return std::string(text);
  const std::string_view colour = severity == Severity::error     ? "31"
                                  : severity == Severity::warning ? "33"
                                                                  : "32";
  return "\x1b[1;" + std::string(colour) + "m" + std::string(text) + "\x1b[0m";
}

std::string Palette::secondary(std::string_view text) const {
  if (!enabled || text.empty()) return std::string(text);
  return "\x1b[1;34m" + std::string(text) + "\x1b[0m";
}

std::string Palette::strong(std::string_view text) const {
  if (!enabled || text.empty()) return std::string(text);
  return "\x1b[1m" + std::string(text) + "\x1b[0m";
}

std::vector<Mark> marks_of(const SourceFile& file, const Span& span, bool primary,
                           const std::string& text) {
  const auto size = static_cast<std::uint32_t>(file.text().size());
  const std::uint32_t begin = std::min(span.begin, size);
  std::uint32_t end = std::clamp(span.end, begin, size);
  // Blanks at the end of a span would put the last mark on an empty line.
  while (end > begin && std::string_view(" \t\r\n").find(file.text()[end - 1]) < 4) --end;
  const int first = file.position(begin).line;
  const int last = file.position(end).line;
  if (first == last)
    return {{first, begin - file.line_begin(first), end - file.line_begin(first), primary, text}};
  const std::size_t indent =
      std::min(file.line(last).find_first_not_of(" \t"), file.line(last).size());
  return {{first, begin - file.line_begin(first), file.line(first).size(), primary, ""},
          {last, indent, end - file.line_begin(last), primary, text}};
}

std::string snippet(const SourceFile& file, std::vector<Mark> marks, std::size_t gutter,
                    const Palette& palette) {
  std::stable_sort(marks.begin(), marks.end(), [](const Mark& a, const Mark& b) {
    return std::pair{a.line, a.begin} < std::pair{b.line, b.begin};
  });
  std::string result = palette.secondary(std::string(gutter + 1, ' ') + "|") + "\n";
  int previous = 0;
  for (auto first = marks.begin(); first != marks.end();) {
    const auto last = std::find_if(first, marks.end(),
                                   [&](const Mark& mark) { return mark.line != first->line; });
    const int skipped = previous == 0 ? 0 : first->line - previous - 1;
    if (skipped == 1)
      result += source_line(previous + 1, DisplayLine(file.line(previous + 1), 0), gutter, palette);
    else if (skipped > 1)
      result += palette.secondary("...") + "\n";
    result += marked_line(file, {first, last}, gutter, palette);
    previous = first->line;
    first = last;
  }
  return result;
}

} // namespace hvi::lang
