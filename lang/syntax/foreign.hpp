// Characters that are not ASCII but look like, or stand for, something the language has.
#pragma once

#include <string_view>

namespace hvi::lang {

/// What to write instead of a character: "-" for the Unicode minus, "lambda" for a Greek letter.
struct Foreign {
  char32_t code;
  std::string_view name;    // "a Unicode minus sign"
  std::string_view instead; // "-"
};

/// The entry of a character; null when nothing is known about it.
[[nodiscard]] const Foreign* find_foreign(char32_t code);

/// A letter of some script other than ASCII (coarse: good enough to find whole words).
[[nodiscard]] bool is_foreign_letter(char32_t code);

} // namespace hvi::lang
