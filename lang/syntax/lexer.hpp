// Text to tokens: the first arrow of the pipeline.
#pragma once

#include "lang/diag/diagnostic.hpp"
#include "lang/diag/source.hpp"
#include "lang/syntax/token.hpp"

namespace hvi::lang {

/// Splits a file into tokens and comments. Never gives up: signs and words of other languages (a
/// Unicode minus, `&&`, `**`, `//`) are reported and replaced by what was meant, so that one slip
/// is one error; what cannot be repaired is reported, left out and listed in `damage`.
/// At most 100 errors are reported for a file.
[[nodiscard]] TokenStream lex(const SourceFile& source, Diagnostics& diagnostics);

} // namespace hvi::lang
