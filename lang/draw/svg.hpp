// A sheet as SVG: text stays text, images are embedded, nothing is loaded from elsewhere.
#pragma once

#include "lang/draw/sheet.hpp"

namespace hvi::lang::draw {

/// Well-formed whatever the texts are: they are escaped, and control characters left out.
std::string svg_text(const Sheet& sheet);

} // namespace hvi::lang::draw
