// Reads a table from CSV text, which may be anything: every byte sequence ends in a table or in an
// error with the line.
#include "solver/kernel/table.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string_view>

namespace hvi::solver {

namespace {

constexpr std::size_t most_rows = 10'000'000;
constexpr std::size_t longest_quote = 40;

[[noreturn]] void fail(const std::string& name, std::size_t line, const std::string& what) {
  throw std::invalid_argument(fmt::format("table {}, line {}: {}", name, line, what));
}

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

/// The cells of a line: split at the first kind of separator present, ; before , before blanks.
std::vector<std::string_view> cells_of(std::string_view line) {
  const char separator = line.find(';') != line.npos   ? ';'
                         : line.find(',') != line.npos ? ','
                                                       : ' ';
  std::vector<std::string_view> cells;
  if (separator == ' ') {
    for (line = trimmed(line); !line.empty(); line = trimmed(line)) {
      std::size_t end = 0;
      while (end < line.size() && !is_blank(line[end])) ++end;
      cells.push_back(line.substr(0, end));
      line.remove_prefix(end);
    }
    return cells;
  }
  for (std::size_t end = 0; end != line.npos; line.remove_prefix(end == line.npos ? 0 : end + 1)) {
    end = line.find(separator);
    cells.push_back(trimmed(line.substr(0, end)));
  }
  return cells;
}

/// A number in C notation with an optional plus sign; the whole cell.
std::optional<double> number_of(std::string_view cell) {
  if (cell.size() > 1 && cell[0] == '+' && cell[1] != '-') cell.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size()) return std::nullopt;
  return value;
}

/// A piece of the input for a message: short, without control bytes.
std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (char c : text.substr(0, longest_quote)) out += (c < ' ' || c == '\x7f') ? '?' : c;
  return out + (text.size() > longest_quote ? "...\"" : "\"");
}

class Reader {
public:
  Reader(std::string name, const std::string& text) : name_(std::move(name)), rest_(text) {}

  Table read(Table::Interpolation kind) {
    if (rest_.starts_with("\xef\xbb\xbf")) rest_.remove_prefix(3); // byte-order mark
    while (!rest_.empty()) {
      const std::size_t end = std::min(rest_.find('\n'), rest_.size());
      ++line_;
      add(trimmed(rest_.substr(0, std::min(end, rest_.substr(0, end).find('#')))));
      rest_.remove_prefix(std::min(end + 1, rest_.size()));
    }
    if (x_.size() < 2)
      fail(name_, line_, fmt::format("a table needs at least two rows, found {}", x_.size()));
    return {std::move(name_), std::move(x_), std::move(y_), kind};
  }

private:
  void add(std::string_view line) {
    if (line.empty()) return;
    const auto cells = cells_of(line);
    if (cells.size() != 2)
      fail(name_, line_,
           fmt::format("two columns expected, found {} in {}", cells.size(), quoted(line)));
    const auto x = number_of(cells[0]), y = number_of(cells[1]);
    if (!x && !y && x_.empty() && !header_) { // one line of column names
      header_ = true;
      return;
    }
    if (!x || !y) {
      const std::string_view cell = cells[x ? 1 : 0];
      const bool comma = cell.find(',') != cell.npos, marks = cell.starts_with('"');
      fail(name_, line_,
           fmt::format("{} is not a number{}", quoted(cell),
                       comma   ? ": decimals follow a point, not a comma"
                       : marks ? ": numbers have no quotation marks"
                               : ""));
    }
    if (!std::isfinite(*x) || !std::isfinite(*y)) fail(name_, line_, "a value is not finite");
    if (!x_.empty() && !(x_.back() < *x))
      fail(name_, line_,
           fmt::format("the first column must increase, but {} follows {}", *x, x_.back()));
    if (x_.size() == most_rows) fail(name_, line_, fmt::format("more than {} rows", most_rows));
    x_.push_back(*x);
    y_.push_back(*y);
  }

  std::string name_;
  std::string_view rest_;
  std::size_t line_ = 0;
  bool header_ = false;
  std::vector<double> x_, y_;
};

} // namespace

Table parse_table(std::string name, const std::string& text, Table::Interpolation kind) {
  return Reader(std::move(name), text).read(kind);
}

} // namespace hvi::solver
