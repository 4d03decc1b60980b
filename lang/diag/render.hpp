// Diagnostics for people (snippet with carets) and for editors (JSON lines). Last stage of
// lang/diag.
#pragma once

#include "lang/diag/diagnostic.hpp"

#include <cstddef>
#include <string>

namespace hvi::lang {

struct RenderOptions {
  bool colour = false;    ///< ANSI colours
  std::size_t limit = 50; ///< how many are shown; the rest is counted
};

/// One diagnostic with its snippets, ending in a newline:
///
///   error[E0301]: unknown name `yuong`
///    --> slab.hvi:2:31
///     |
///   2 | tensor B = isotropic(young = yuong)
///     |                              ^^^^^ not declared
///     = help: did you mean `young`?
[[nodiscard]] std::string render(const Diagnostic& diagnostic, const SourceMap& sources,
                                 const RenderOptions& options = {});

/// All of them in source order with a blank line between, and "and N more" behind the limit.
[[nodiscard]] std::string render(const Diagnostics& diagnostics, const SourceMap& sources,
                                 const RenderOptions& options = {});

/// One JSON object per line and diagnostic, all of them, in source order:
/// {"file", "line", "column", "end_line", "end_column", "code", "severity", "message", "label",
///  "secondary": [{"file", "line", "column", "end_line", "end_column", "text"}], "notes", "help"}.
/// The places are null for a diagnostic without one. Columns count characters from 1; the end is
/// the place behind the last character.
[[nodiscard]] std::string render_json(const Diagnostics& diagnostics, const SourceMap& sources);

/// "error", "warning", "note".
[[nodiscard]] std::string_view word(Severity severity);

} // namespace hvi::lang
