// Places as an editor counts them: lines from 0, characters from 0 in UTF-16 code units unless the
// editor takes bytes (UTF-8).
#pragma once

#include "lang/diag/source.hpp"

#include <cstdint>
#include <string_view>

namespace hvi::lang {

enum class CharacterUnit { utf8, utf16 };

struct EditorPosition {
  int line = 0;
  int character = 0;
};

struct EditorRange {
  EditorPosition begin, end;
};

/// Units that a text is long.
[[nodiscard]] int units_of(std::string_view text, CharacterUnit unit);

[[nodiscard]] EditorPosition position_of(const SourceFile& file, std::uint32_t offset,
                                         CharacterUnit unit);
[[nodiscard]] EditorRange range_of(const SourceFile& file, const Span& span, CharacterUnit unit);

/// The byte at a position. A position behind the end of its line is the end of the line, one behind
/// the last line the end of the text.
[[nodiscard]] std::uint32_t offset_of(const SourceFile& file, const EditorPosition& position,
                                      CharacterUnit unit);

} // namespace hvi::lang
