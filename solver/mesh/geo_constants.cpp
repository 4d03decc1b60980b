// See geo_constants.hpp.
#include "solver/mesh/geo_constants.hpp"

#include <algorithm>
#include <cctype>

namespace hvi::solver {
namespace {

bool in_name(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// Comments and what stands in quotes become blanks.
std::string code_of(std::string_view text) {
  std::string out(text);
  const auto blank = [&](std::size_t from, std::size_t to) {
    to = std::min(to, out.size());
    std::fill(out.begin() + static_cast<std::ptrdiff_t>(from),
              out.begin() + static_cast<std::ptrdiff_t>(to), ' ');
    return to;
  };
  const auto end_of = [&](std::string_view mark, std::size_t from) {
    const std::size_t at = text.find(mark, from);
    return at == std::string_view::npos ? text.size() : at + mark.size();
  };
  for (std::size_t at = 0; at < out.size();) {
    if (text.substr(at, 2) == "//")
      at = blank(at, end_of("\n", at));
    else if (text.substr(at, 2) == "/*")
      at = blank(at, end_of("*/", at + 2));
    else if (text[at] == '"')
      at = blank(at, end_of("\"", at + 1));
    else
      ++at;
  }
  return out;
}

/// The names behind the bracket at `at`, each the first word of an item.
void add_names(const std::string& code, std::size_t at, std::vector<std::string>& out) {
  bool first = true; // of an item
  for (int depth = 1; ++at < code.size();) {
    const char c = code[at];
    if (c == '[' || c == '{' || c == '(') ++depth;
    if ((c == ']' || c == '}' || c == ')') && --depth == 0) return;
    if (depth > 1) continue;
    if (c == ',') first = true;
    if (!first || !in_name(c)) continue;
    std::size_t end = at;
    while (end < code.size() && in_name(code[end])) ++end;
    out.push_back(code.substr(at, end - at));
    at = end - 1;
    first = false;
  }
}

} // namespace

std::vector<std::string> geo_constants(std::string_view text) {
  constexpr std::string_view word = "DefineConstant";
  const std::string code = code_of(text);
  std::vector<std::string> out;
  for (std::size_t at = code.find(word); at != std::string::npos; at = code.find(word, at + 1)) {
    const std::size_t bracket = code.find_first_not_of(" \t\r\n", at + word.size());
    if (bracket != std::string::npos && code[bracket] == '[') add_names(code, bracket, out);
  }
  return out;
}

} // namespace hvi::solver
