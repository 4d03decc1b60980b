// The table of token kinds, see token.hpp.
#include "lang/syntax/token.hpp"

#include <algorithm>
#include <array>

namespace hvi::lang {
namespace {

using enum TokenKind;

constexpr auto kinds = std::to_array<TokenInfo>({
    {import_, "import", "import"},
    {units, "units", "units"},
    {param, "param", "param"},
    {mesh, "mesh", "mesh"},
    {part, "part", "part"},
    {tensor, "tensor", "tensor"},
    {kernel, "kernel", "kernel"},
    {superpotential, "superpotential", "superpotential"},
    {state, "state", "state"},
    {fn, "fn", "fn"},
    {space, "space", "space"},
    {find, "find", "find"},
    {report, "report", "report"},
    {expect, "expect", "expect"},
    {study, "study", "study"},
    {and_, "and", "and"},
    {or_, "or", "or"},
    {not_, "not", "not"},
    {otherwise, "otherwise", "otherwise"},
    {name, "name", ""},
    {number, "number", ""},
    {string, "string", ""},
    {plus, "plus", "+"},
    {minus, "minus", "-"},
    {star, "star", "*"},
    {slash, "slash", "/"},
    {caret, "caret", "^"},
    {clarke, "clarke", "^0("},
    {colon, "colon", ":"},
    {dot, "dot", "."},
    {prime, "prime", "'"},
    {comma, "comma", ","},
    {semicolon, "semicolon", ";"},
    {equal, "equal", "="},
    {equal_equal, "equal-equal", "=="},
    {not_equal, "not-equal", "!="},
    {less, "less", "<"},
    {less_equal, "less-equal", "<="},
    {greater, "greater", ">"},
    {greater_equal, "greater-equal", ">="},
    {arrow, "arrow", "->"},
    {bar, "bar", "|"},
    {open_paren, "open-paren", "("},
    {close_paren, "close-paren", ")"},
    {open_bracket, "open-bracket", "["},
    {close_bracket, "close-bracket", "]"},
    {end, "end", ""},
});

// info() indexes the table by kind, so the order of the two must be the same.
static_assert([] {
  for (std::size_t i = 0; i < kinds.size(); ++i)
    if (static_cast<std::size_t>(kinds[i].kind) != i) return false;
  return kinds.size() == static_cast<std::size_t>(end) + 1;
}());

} // namespace

std::span<const TokenInfo> token_table() { return kinds; }

const TokenInfo& info(TokenKind kind) { return kinds[static_cast<std::size_t>(kind)]; }

std::optional<TokenKind> reserved_word(std::string_view text) {
  for (const TokenInfo& entry : kinds) {
    if (!is_reserved(entry.kind)) break;
    if (!text.starts_with(entry.spelling.front())) continue; // most are out with one letter
    if (entry.spelling == text && entry.kind != state && entry.kind != units) return entry.kind;
  }
  return std::nullopt;
}

std::span<const std::string_view> statement_words() {
  static const std::vector<std::string_view> words = [] {
    std::vector<std::string_view> result;
    for (const TokenInfo& entry : kinds)
      if (is_statement_word(entry.kind)) result.push_back(entry.spelling);
    return result;
  }();
  return words;
}

} // namespace hvi::lang
