// The part of a rendered diagnostic that shows source lines: gutter, text, carets and labels.
#pragma once

#include "lang/diag/diagnostic.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace hvi::lang {

/// ANSI colours, or nothing at all.
struct Palette {
  bool enabled = false;
  Severity severity = Severity::error;
  [[nodiscard]] std::string primary(std::string_view text) const;   // red, yellow or green
  [[nodiscard]] std::string secondary(std::string_view text) const; // blue: dashes and gutter
  [[nodiscard]] std::string strong(std::string_view text) const;    // bold
};

/// A piece of one line to underline. Byte offsets count from the start of the line.
struct Mark {
  int line = 1;
  std::size_t begin = 0;
  std::size_t end = 0;
  bool primary = true;
  std::string text;
};

/// Cuts a span into marks: one, or one on its first and one on its last line.
[[nodiscard]] std::vector<Mark> marks_of(const SourceFile& file, const Span& span, bool primary,
                                         const std::string& text);

/// The lines of `file` that carry marks, with the marks below them. `gutter` is the width of the
/// line numbers; lines left out between are shown as "...".
[[nodiscard]] std::string snippet(const SourceFile& file, std::vector<Mark> marks,
                                  std::size_t gutter, const Palette& palette);

} // namespace hvi::lang
