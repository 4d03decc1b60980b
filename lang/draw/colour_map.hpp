// Colours of values.
#pragma once

#include "lang/draw/sheet.hpp"

namespace hvi::lang::draw {

/// Of what has no value.
inline constexpr Colour plain{0.80, 0.82, 0.84};

/// From the least to the largest value of a field. Of one sign: viridis (S. van der Walt, N. Smith,
/// 2015, CC0), whose lightness grows evenly. Of both: blue, white at zero, red (ColorBrewer's RdBu,
/// C. Brewer, M. Harrower), the same amount of colour for the same size on both sides. NaN is
/// plain.
class ColourMap {
public:
  ColourMap(double low, double high);
  double low() const { return low_; }
  double high() const { return high_; }
  Colour operator()(double value) const;

private:
  double low_, high_;
  bool both_signs_;
};

} // namespace hvi::lang::draw
