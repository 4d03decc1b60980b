// Everything that prints what the syntax phase made: `dump --tokens`, `dump --ast` and `fmt`.
#pragma once

#include "lang/diag/diagnostic.hpp"
#include "lang/diag/source.hpp"
#include "lang/syntax/ast.hpp"
#include "lang/syntax/token.hpp"

#include <optional>
#include <string>

namespace hvi::lang {

/// One token per line: position, kind, text. Comments stand in their places.
[[nodiscard]] std::string print_tokens(const SourceFile& source, const TokenStream& stream);

/// The tree, one node per line, indented. With a source each line ends in its place,
/// "@line:column-line:column"; without one, trees of differently laid out scripts compare equal.
[[nodiscard]] std::string print_ast(const ast::Program& program,
                                    const SourceFile* source = nullptr);

/// The script in the canonical layout: the same tokens and comments in the same order, other
/// blanks. Formatting the result again changes nothing. Nothing when the script has syntax errors,
/// which are reported.
[[nodiscard]] std::optional<std::string> format(const SourceFile& source, Diagnostics& diagnostics);

} // namespace hvi::lang
