// See colour_map.hpp.
#include "lang/draw/colour_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

namespace hvi::lang::draw {
namespace {

constexpr std::uint32_t viridis[] = {0x440154, 0x482878, 0x3e4a89, 0x31688e, 0x26828e,
                                     0x1f9e89, 0x35b779, 0x6dcd59, 0xb4de2c, 0xfde725};
constexpr std::uint32_t blue_white_red[] = {0x053061, 0x2166ac, 0x4393c3, 0x92c5de,
                                            0xd1e5f0, 0xf7f7f7, 0xfddbc7, 0xf4a582,
                                            0xd6604d, 0xb2182b, 0x67001f};

/// The colour at x in [0, 1] along a list.
Colour along(std::span<const std::uint32_t> colours, double x) {
  const double at = std::clamp(x, 0.0, 1.0) * static_cast<double>(colours.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), colours.size() - 2);
  const double part = at - static_cast<double>(i);
  const auto mix = [&](int shift) {
    const auto byte = [&](std::uint32_t c) { return static_cast<double>((c >> shift) & 0xff); };
    return ((1.0 - part) * byte(colours[i]) + part * byte(colours[i + 1])) / 255.0;
  };
  return {mix(16), mix(8), mix(0)};
}

/// Both signs count where the smaller side is at least this part of the larger one.
constexpr double worth_a_side = 0.15;

} // namespace

ColourMap::ColourMap(double low, double high) : low_(low), high_(high) {
  const double smaller = std::min(-low, high);
  both_signs_ = smaller > worth_a_side * std::max(-low, high);
}

Colour ColourMap::operator()(double value) const {
  if (std::isnan(value)) return plain;
  if (both_signs_) {
    const double size = std::max(-low_, high_);
    return along(blue_white_red, 0.5 + 0.5 * value / size);
  }
  const double range = high_ - low_;
  return along(viridis, range > 0.0 ? (value - low_) / range : 0.0);
}

} // namespace hvi::lang::draw
