// Alignment, wrapping and output of formatted lines, see lines.hpp.
#include "lang/syntax/lines.hpp"

#include "lang/diag/utf8.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace hvi::lang {
namespace {

bool opens(const std::string& text) { return text.ends_with('(') || text == "["; }
bool closes(const std::string& text) { return text == ")" || text == "]"; }
bool is_text(const std::string& text) { return text.starts_with('"'); }

// Column behind the first n pieces.
std::size_t width_before(const Line& line, std::size_t n) {
  std::size_t result = line.indent;
  for (std::size_t i = 0; i < n; ++i)
    result += (i > 0 ? line.pieces[i].blanks : 0) + utf8::count(line.pieces[i].text);
  return result;
}

// Bracket depth of every piece; a bracket counts as outside of itself.
std::vector<int> depths(const Line& line) {
  std::vector<int> result;
  int depth = 0;
  for (const Piece& piece : line.pieces) {
    if (!is_text(piece.text) && closes(piece.text)) --depth;
    result.push_back(depth);
    if (!is_text(piece.text) && opens(piece.text)) ++depth;
  }
  return result;
}

// Index of the "=" of a definition, or the number of pieces.
std::size_t definition_sign(const Line& line) {
  const std::vector<int> depth = depths(line);
  std::size_t i = 0;
  while (i < line.pieces.size() && (line.pieces[i].text != "=" || depth[i] > 0)) ++i;
  return i;
}

bool may_align(const std::vector<Line>& lines, std::size_t i) {
  const Line& line = lines[i];
  if (!line.begins_statement || line.pieces.empty()) return false;
  const std::string& word = line.pieces.front().text;
  for (const char* other : {"find", "expect", "study", "report", "state"})
    if (word == other) return false;
  const bool one_line = i + 1 == lines.size() || lines[i + 1].begins_statement ||
                        (lines[i + 1].pieces.empty() && lines[i + 1].indent == 0);
  return one_line && width(line) <= max_line_width && definition_sign(line) < line.pieces.size();
}

Line split(Line& line, std::size_t at, std::size_t indent) {
  Line rest;
  rest.indent = indent;
  const auto from = line.pieces.begin() + static_cast<std::ptrdiff_t>(at);
  rest.pieces.assign(std::make_move_iterator(from), std::make_move_iterator(line.pieces.end()));
  line.pieces.erase(from, line.pieces.end());
  rest.comment = std::exchange(line.comment, {});
  return rest;
}

// Where to break: behind the last comma that fits, of the commas outside of most brackets; behind
// the first of them if none fits. 0: nowhere.
std::size_t comma_break(const Line& line) {
  const std::vector<int> depth = depths(line);
  int deepest = -1;
  for (int level = 0; level <= deepest || level == 0; ++level) {
    std::size_t first = 0;
    std::size_t best = 0;
    for (std::size_t i = 0; i + 1 < line.pieces.size(); ++i) {
      deepest = std::max(deepest, depth[i]);
      if (line.pieces[i].text != "," || depth[i] != level) continue;
      if (first == 0) first = i + 1;
      if (width_before(line, i + 1) <= max_line_width) best = i + 1;
    }
    if (best > 0) return best;
    if (first > 0 && level == deepest) return first;
  }
  return 0;
}

void wrap_line(Line line, std::vector<Line>& out) {
  if (width(line) > max_line_width) {
    for (std::size_t i = line.pieces.size(); i-- > 1;) {
      if (!line.pieces[i].soft_break) continue;
      Line rest = split(line, i, *line.pieces[i].soft_break);
      wrap_line(std::move(line), out);
      return wrap_line(std::move(rest), out);
    }
  }
  const std::size_t indent = line.indent + continuation_indent;
  while (width(line) > max_line_width) {
    const std::size_t at = comma_break(line);
    if (at == 0) break;
    Line rest = split(line, at, indent);
    out.push_back(std::move(line));
    line = std::move(rest);
  }
  out.push_back(std::move(line));
}

} // namespace

std::size_t width(const Line& line) { return width_before(line, line.pieces.size()); }

void align_groups(std::vector<Line>& lines, int n_groups) {
  // Columns before any blanks are added: a line holds one piece of one group.
  std::vector<std::size_t> column(static_cast<std::size_t>(n_groups), 0);
  const auto each = [&](const auto& visit) {
    for (Line& line : lines)
      for (std::size_t i = 1; i < line.pieces.size(); ++i)
        if (line.pieces[i].group >= 0)
          visit(line, i, column[static_cast<std::size_t>(line.pieces[i].group)]);
  };
  each([](const Line& line, std::size_t i, std::size_t& widest) {
    widest = std::max(widest, width_before(line, i) + line.pieces[i].blanks);
  });
  each([](Line& line, std::size_t i, std::size_t widest) {
    line.pieces[i].blanks = widest - width_before(line, i);
  });
}

int group_definitions(std::vector<Line>& lines, int n_groups) {
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!may_align(lines, i)) continue;
    const bool continues = i > 0 && !lines[i].blank_before && may_align(lines, i - 1);
    if (!continues) ++n_groups;
    lines[i].pieces[definition_sign(lines[i])].group = n_groups - 1;
  }
  return n_groups;
}

int group_documents(std::vector<Line>& lines, int n_groups) {
  const auto documents = [&](std::size_t i) {
    const auto& pieces = lines[i].pieces;
    return lines[i].begins_statement && pieces.size() > 1 && pieces.front().text == "param" &&
           is_text(pieces.back().text);
  };
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!documents(i)) continue;
    if (i == 0 || lines[i].blank_before || !documents(i - 1)) ++n_groups;
    lines[i].pieces.back().group = n_groups - 1;
  }
  return n_groups;
}

std::vector<Line> wrap(std::vector<Line> lines) {
  std::vector<Line> result;
  for (Line& line : lines) wrap_line(std::move(line), result);
  return result;
}

std::string join(const std::vector<Line>& lines) {
  std::string out;
  const auto ends_in_comment = [&](std::size_t i) {
    return !lines[i].pieces.empty() && !lines[i].comment.empty();
  };
  std::size_t column = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Line& line = lines[i];
    if (line.blank_before && i > 0) out += '\n';
    out.append(line.indent, ' ');
    for (std::size_t k = 0; k < line.pieces.size(); ++k)
      out.append(k > 0 ? line.pieces[k].blanks : 0, ' ').append(line.pieces[k].text);
    if (ends_in_comment(i)) {
      if (i == 0 || line.blank_before || !ends_in_comment(i - 1)) {
        column = width(line);
        for (std::size_t k = i + 1;
             k < lines.size() && !lines[k].blank_before && ends_in_comment(k); ++k)
          column = std::max(column, width(lines[k]));
      }
      out.append(column + 2 - width(line), ' ');
    }
    out.append(line.comment) += '\n';
  }
  return out;
}

} // namespace hvi::lang
