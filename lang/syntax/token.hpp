// Tokens: the output of the lexer and the input of the parser and the formatter. One table
// (token.cpp) holds the kinds with their spelling; words, printing and messages read it.
#pragma once

#include "lang/diag/source.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace hvi::lang {

enum class TokenKind : std::uint8_t {
  // statement words, in the order of the grammar
  import_,
  units, // where `units` is followed by units; elsewhere it is a name
  param,
  mesh,
  part,
  tensor,
  kernel,
  superpotential,
  state, // where `state name on` stands; elsewhere it is a name
  fn,
  space,
  find,
  report,
  expect,
  study,
  // other reserved words
  and_,
  or_,
  not_,
  otherwise,
  // with a text of their own
  name,
  number,
  string,
  // signs
  plus,
  minus,
  star,
  slash,
  caret,
  clarke, // "^0(", blanks allowed before "("
  colon,
  dot,
  prime,
  comma,
  semicolon,
  equal,
  equal_equal,
  not_equal,
  less,
  less_equal,
  greater,
  greater_equal,
  arrow,
  bar,
  open_paren,
  close_paren,
  open_bracket,
  close_bracket,
  end // behind the last character
};

/// A token; its text is source.text(span).
struct Token {
  TokenKind kind = TokenKind::end;
  bool first_on_line = false;
  Span span;
};

/// A kind with the name used in dumps and, for words and signs, its spelling.
struct TokenInfo {
  TokenKind kind;
  std::string_view name;
  std::string_view spelling; // empty: the text varies
};

/// The table of all kinds, in their order.
[[nodiscard]] std::span<const TokenInfo> token_table();
[[nodiscard]] const TokenInfo& info(TokenKind kind);

/// The reserved word of this spelling.
[[nodiscard]] std::optional<TokenKind> reserved_word(std::string_view text);

/// One of the words that begin a statement.
[[nodiscard]] constexpr bool is_statement_word(TokenKind kind) { return kind <= TokenKind::study; }

/// A word that cannot be a name.
[[nodiscard]] constexpr bool is_reserved(TokenKind kind) { return kind <= TokenKind::otherwise; }

/// <, <=, >, >=, ==, !=
[[nodiscard]] constexpr bool is_comparison(TokenKind kind) {
  return kind >= TokenKind::equal_equal && kind <= TokenKind::greater_equal;
}

/// The words that begin a statement, as texts.
[[nodiscard]] std::span<const std::string_view> statement_words();

/// What the lexer makes of a file.
struct TokenStream {
  std::vector<Token> tokens;         // the last one is `end`
  std::vector<Span> comments;        // "#" to the end of the line; kept for the formatter
  std::vector<std::uint32_t> damage; // where a lexical error left something out
};

} // namespace hvi::lang
