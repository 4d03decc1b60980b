// Images as PNG, and several as an animated one (APNG, W3C PNG specification, third edition, 2025).
#pragma once

#include "lang/draw/sheet.hpp"

#include <cstddef>
#include <functional>
#include <string>

namespace hvi::lang::draw {

std::string png_bytes(const Image& image);

/// `count` frames of one size, shown one after the other, over and over; viewers that know no
/// animation show the first one.
std::string apng_bytes(std::size_t count, const std::function<Image(std::size_t)>& frame,
                       int milliseconds);

} // namespace hvi::lang::draw
