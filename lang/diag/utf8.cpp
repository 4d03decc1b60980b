// UTF-8 decoding and display widths, see utf8.hpp.
#include "lang/diag/utf8.hpp"

#include <algorithm>
#include <array>

namespace hvi::lang::utf8 {
namespace {

constexpr char32_t replacement = 0xFFFD;

struct Range {
  char32_t first;
  char32_t last;
};

// Coarse blocks of the Unicode tables: a caret that is off by one below a rare sign is no harm.
constexpr auto zero_width = std::to_array<Range>({{0x0300, 0x036F},
                                                  {0x0483, 0x0489},
                                                  {0x0591, 0x05BD},
                                                  {0x0610, 0x061A},
                                                  {0x064B, 0x065F},
                                                  {0x1AB0, 0x1AFF},
                                                  {0x1DC0, 0x1DFF},
                                                  {0x200B, 0x200F},
                                                  {0x2060, 0x2064},
                                                  {0x20D0, 0x20FF},
                                                  {0xFE00, 0xFE0F},
                                                  {0xFE20, 0xFE2F},
                                                  {0xFEFF, 0xFEFF}});
constexpr auto double_width = std::to_array<Range>({{0x1100, 0x115F},
                                                    {0x2E80, 0x303E},
                                                    {0x3041, 0x33FF},
                                                    {0x3400, 0x4DBF},
                                                    {0x4E00, 0x9FFF},
                                                    {0xA000, 0xA4CF},
                                                    {0xAC00, 0xD7A3},
                                                    {0xF900, 0xFAFF},
                                                    {0xFE30, 0xFE6F},
                                                    {0xFF00, 0xFF60},
                                                    {0xFFE0, 0xFFE6},
                                                    {0x1F300, 0x1F64F},
                                                    {0x1F680, 0x1F6FF},
                                                    {0x1F900, 0x1F9FF},
                                                    {0x20000, 0x3FFFD}});

template <std::size_t N>
bool within(const std::array<Range, N>& ranges, char32_t code) {
  return std::any_of(ranges.begin(), ranges.end(),
                     [code](const Range& r) { return code >= r.first && code <= r.last; });
}

std::uint32_t sequence_length(unsigned char lead) {
  if (lead < 0x80) return 1;
  if (lead >= 0xC2 && lead <= 0xDF) return 2;
  if (lead >= 0xE0 && lead <= 0xEF) return 3;
  if (lead >= 0xF0 && lead <= 0xF4) return 4;
  return 0;
}

// The smallest code point that needs a sequence of this length; anything less is overlong.
constexpr std::array<char32_t, 5> smallest{0, 0, 0x80, 0x800, 0x10000};

} // namespace

Character decode(std::string_view text, std::size_t offset) {
  const auto lead = static_cast<unsigned char>(text[offset]);
  const std::uint32_t length = sequence_length(lead);
  if (length == 1) return {lead, 1, true};
  if (length == 0 || offset + length > text.size()) return {replacement, 1, false};
  char32_t code = lead & (0xFFU >> (length + 1));
  for (std::uint32_t k = 1; k < length; ++k) {
    const auto byte = static_cast<unsigned char>(text[offset + k]);
    if ((byte & 0xC0U) != 0x80U) return {replacement, 1, false};
    code = (code << 6U) | (byte & 0x3FU);
  }
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  if (code < smallest[length] || surrogate || code > 0x10FFFF) return {replacement, 1, false};
  return {code, length, true};
}

std::size_t count(std::string_view text) {
  std::size_t n = 0;
  for (std::size_t i = 0; i < text.size(); i += decode(text, i).length) ++n;
  return n;
}

int width(char32_t code) {
  if (code < 0x300) return 1;
  if (within(zero_width, code)) return 0;
  return within(double_width, code) ? 2 : 1;
}

std::string encode(char32_t code) {
  const auto continuation = [](char32_t bits) { return char(0x80U | (bits & 0x3FU)); };
  if (code < 0x80) return {char(code)};
  if (code < 0x800) return {char(0xC0U | (code >> 6U)), continuation(code)};
  if (code < 0x10000)
    return {char(0xE0U | (code >> 12U)), continuation(code >> 6U), continuation(code)};
  return {char(0xF0U | (code >> 18U)), continuation(code >> 12U), continuation(code >> 6U),
          continuation(code)};
}

} // namespace hvi::lang::utf8
