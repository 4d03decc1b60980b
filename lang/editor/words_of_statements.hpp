// What the words of the language say, for an editor.
#pragma once

#include <string_view>

namespace hvi::lang {

/// One line of Markdown for a word that begins a statement or a clause; empty for others.
[[nodiscard]] std::string_view word_of_statement(std::string_view word);

/// How the statement that a word begins is written, with places to fill in (${1:name}); empty for
/// other words.
[[nodiscard]] std::string_view pattern_of_statement(std::string_view word);

} // namespace hvi::lang
