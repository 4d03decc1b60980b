// Table of look-alikes, see foreign.hpp.
#include "lang/syntax/foreign.hpp"

#include <algorithm>
#include <array>

namespace hvi::lang {
namespace {

constexpr auto foreign_table = std::to_array<Foreign>({
    {0x00A0, "a no-break space", " "},
    {0x00AB, "a quotation mark", "\""},
    {0x00AD, "a soft hyphen", "-"},
    {0x00B2, "a superscript two", "^2"},
    {0x00B3, "a superscript three", "^3"},
    {0x00B4, "an acute accent", "'"},
    {0x00B7, "a middle dot", "*"},
    {0x00BB, "a quotation mark", "\""},
    {0x00BD, "a fraction", "0.5"},
    {0x00D7, "a multiplication sign", "*"},
    {0x00F7, "a division sign", "/"},
    {0x0393, "a Greek letter", "Gamma"},
    {0x0394, "a Greek letter", "Delta"},
    {0x03A3, "a Greek letter", "Sigma"},
    {0x03A9, "a Greek letter", "Omega"},
    {0x03B1, "a Greek letter", "alpha"},
    {0x03B2, "a Greek letter", "beta"},
    {0x03B3, "a Greek letter", "gamma"},
    {0x03B4, "a Greek letter", "delta"},
    {0x03B5, "a Greek letter", "eps"},
    {0x03B6, "a Greek letter", "zeta"},
    {0x03B7, "a Greek letter", "eta"},
    {0x03B8, "a Greek letter", "theta"},
    {0x03BA, "a Greek letter", "kappa"},
    {0x03BB, "a Greek letter", "lambda"},
    {0x03BC, "a Greek letter", "mu"},
    {0x03BD, "a Greek letter", "nu"},
    {0x03BE, "a Greek letter", "xi"},
    {0x03C0, "a Greek letter", "pi"},
    {0x03C1, "a Greek letter", "rho"},
    {0x03C3, "a Greek letter", "sigma"},
    {0x03C4, "a Greek letter", "tau"},
    {0x03C6, "a Greek letter", "phi"},
    {0x03C8, "a Greek letter", "psi"},
    {0x03C9, "a Greek letter", "omega"},
    {0x00B5, "a micro sign", "mu"},
    {0x2002, "a Unicode space", " "},
    {0x2003, "a Unicode space", " "},
    {0x2009, "a thin space", " "},
    {0x200B, "a zero-width space", " "},
    {0x2010, "a Unicode hyphen", "-"},
    {0x2011, "a Unicode hyphen", "-"},
    {0x2012, "a figure dash", "-"},
    {0x2013, "an en dash", "-"},
    {0x2014, "an em dash", "-"},
    {0x2018, "a typographic quote", "'"},
    {0x2019, "a typographic quote", "'"},
    {0x201C, "a typographic quote", "\""},
    {0x201D, "a typographic quote", "\""},
    {0x201E, "a typographic quote", "\""},
    {0x202F, "a narrow no-break space", " "},
    {0x2032, "a prime sign", "'"},
    {0x2044, "a fraction slash", "/"},
    {0x2190, "an arrow", "->"},
    {0x2192, "an arrow", "->"},
    {0x2200, "a for-all sign", "for all"},
    {0x2208, "an element-of sign", "in"},
    {0x2212, "a Unicode minus sign", "-"},
    {0x2217, "an asterisk operator", "*"},
    {0x2219, "a bullet operator", "*"},
    {0x222B, "an integral sign", "integral"},
    {0x2227, "a logical and", "and"},
    {0x2228, "a logical or", "or"},
    {0x2236, "a ratio sign", ":"},
    {0x2260, "an unequal sign", "!="},
    {0x2264, "a less-or-equal sign", "<="},
    {0x2265, "a greater-or-equal sign", ">="},
    {0x22C5, "a dot operator", "*"},
    {0x3000, "an ideographic space", " "},
    {0xFEFF, "a byte-order mark inside the text", " "},
    {0xFF08, "a full-width parenthesis", "("},
    {0xFF09, "a full-width parenthesis", ")"},
    {0xFF0B, "a full-width plus", "+"},
    {0xFF0C, "a full-width comma", ","},
    {0xFF0D, "a full-width minus", "-"},
    {0xFF0E, "a full-width dot", "."},
    {0xFF1A, "a full-width colon", ":"},
    {0xFF1B, "a full-width semicolon", ";"},
    {0xFF1D, "a full-width equals sign", "="},
});

} // namespace

const Foreign* find_foreign(char32_t code) {
  const auto entry = std::find_if(foreign_table.begin(), foreign_table.end(),
                                  [code](const Foreign& f) { return f.code == code; });
  return entry == foreign_table.end() ? nullptr : &*entry;
}

bool is_foreign_letter(char32_t code) {
  const bool latin_sign = code == 0xD7 || code == 0xF7;
  return code == 0xB5 || code == 0x2126 || (code >= 0xC0 && code <= 0x1FFF && !latin_sign) ||
         (code >= 0x2C00 && code <= 0x2DFF) || (code >= 0x3040 && code <= 0xD7FF) ||
         (code >= 0xF900 && code <= 0xFDFF);
}

} // namespace hvi::lang
