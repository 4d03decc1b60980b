// Axes, their numbers and the bar that explains colours.
#pragma once

#include "lang/draw/colour_map.hpp"

#include <string>
#include <vector>

namespace hvi::lang::draw {

/// A box on a sheet and the numbers its sides stand for.
struct Plane {
  double left = 0.0, top = 0.0, width = 0.0, height = 0.0; ///< on the sheet
  double x_low = 0.0, x_high = 1.0, y_low = 0.0, y_high = 1.0;
  Spot operator()(double x, double y) const {
    return {left + width * (x - x_low) / (x_high - x_low),
            top + height * (y_high - y) / (y_high - y_low)};
  }
};

/// Multiples of 1, 2 or 5 times a power of ten in [low, high], about as many as are wanted, and two
/// at least.
std::vector<double> ticks(double low, double high, int wanted);
/// A few digits; a proper minus sign.
std::string number_text(double x);
/// Numbers of one axis with as many digits as tell them apart.
std::vector<std::string> number_texts(const std::vector<double>& numbers);

/// Ticks with numbers below and at the left, and the two lines they stand on.
void add_axes(Sheet& sheet, const Plane& plane, const std::string& x_name,
              const std::string& y_name, bool grid);
/// A vertical bar of the colours from the lowest to the highest value, with numbers and a name.
void add_bar(Sheet& sheet, const ColourMap& colours, double left, double top, double height,
             const std::string& name);

} // namespace hvi::lang::draw
