// Text to syntax tree: the second arrow of the pipeline. Hand-written recursive descent; each
// production of the grammar stands above the function that reads it (parse_*.cpp).
#pragma once

#include "lang/diag/diagnostic.hpp"
#include "lang/diag/source.hpp"
#include "lang/syntax/ast.hpp"

namespace hvi::lang {

/// Lexes and parses a whole file. Reports every lexical and syntax error, one per mistake, and
/// goes on at the next statement word; statements with errors are left out of the program.
[[nodiscard]] ast::Program parse(const SourceFile& source, Diagnostics& diagnostics);

} // namespace hvi::lang
