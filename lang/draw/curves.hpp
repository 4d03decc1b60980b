// Curves in a plane, as a sheet: fields of bars, tables, graphs of laws.
#pragma once

#include "lang/draw/sheet.hpp"

#include <optional>
#include <string>
#include <vector>

namespace hvi::lang::draw {

struct Curve {
  std::string name; ///< empty: no legend
  std::vector<Spot> points;
};

struct CurvePlot {
  std::string title, x_name, y_name;
  std::vector<Curve> curves;
  std::optional<Spot> y_range{}; ///< none: that of the curves
};

/// One panel, lines of distinct colours (Okabe, Ito), a legend where curves have names.
Sheet curves_sheet(const CurvePlot& plot);
/// Panels side by side, or below each other where there are more than two in a row.
Sheet panels_sheet(const std::vector<CurvePlot>& plots);

} // namespace hvi::lang::draw
