// See positions.hpp.
#include "lang/editor/positions.hpp"

#include <algorithm>

namespace hvi::lang {

namespace {

/// Bytes of the character that begins with this one; 1 where it is no UTF-8.
std::size_t bytes_of_character(unsigned char first) {
  if (first >= 0xf0 && first < 0xf8) return 4;
  if (first >= 0xe0) return first < 0xf0 ? 3 : 1;
  return first >= 0xc0 ? 2 : 1;
}

} // namespace

int units_of(std::string_view text, CharacterUnit unit) {
  if (unit == CharacterUnit::utf8) return static_cast<int>(text.size());
  int units = 0;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t bytes = bytes_of_character(static_cast<unsigned char>(text[i]));
    units += bytes == 4 ? 2 : 1; // outside the first plane: a pair of surrogates
    i += bytes;
  }
  return units;
}

EditorPosition position_of(const SourceFile& file, std::uint32_t offset, CharacterUnit unit) {
  const int line = file.position(offset).line;
  const std::uint32_t begin = file.line_begin(line);
  const std::string_view before = file.line(line).substr(0, offset - begin);
  return {line - 1, units_of(before, unit)};
}

EditorRange range_of(const SourceFile& file, const Span& span, CharacterUnit unit) {
  return {position_of(file, span.begin, unit), position_of(file, span.end, unit)};
}

std::uint32_t offset_of(const SourceFile& file, const EditorPosition& position,
                        CharacterUnit unit) {
  if (position.line < 0) return 0;
  if (position.line >= file.n_lines()) return static_cast<std::uint32_t>(file.text().size());
  const std::string_view line = file.line(position.line + 1);
  std::size_t byte = 0;
  int units = 0;
  while (byte < line.size() && units < position.character) {
    const std::size_t bytes = unit == CharacterUnit::utf8
                                  ? 1
                                  : bytes_of_character(static_cast<unsigned char>(line[byte]));
    units += bytes == 4 ? 2 : 1;
    byte += bytes;
  }
  byte = std::min(byte, line.size());
  return file.line_begin(position.line + 1) + static_cast<std::uint32_t>(byte);
}

} // namespace hvi::lang
