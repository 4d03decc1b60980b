// UTF-8 in a few lines: what the lexer, the columns and the carets need.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace hvi::lang::utf8 {

/// One decoded character. A byte that begins no valid sequence is a character of length 1 that is
/// not valid; its code point is U+FFFD.
struct Character {
  char32_t code = 0;
  std::uint32_t length = 1;
  bool valid = true;
};

/// Decodes the character at `offset` (< text.size()). Overlong forms and surrogates are invalid.
[[nodiscard]] Character decode(std::string_view text, std::size_t offset);

/// Number of characters.
[[nodiscard]] std::size_t count(std::string_view text);

/// Columns a terminal uses for it: 0 (combining marks), 1, or 2 (East Asian wide, emoji).
[[nodiscard]] int width(char32_t code);

/// The character as UTF-8.
[[nodiscard]] std::string encode(char32_t code);

} // namespace hvi::lang::utf8
