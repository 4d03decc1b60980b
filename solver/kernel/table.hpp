// A function of one variable given by points: linear or monotone cubic interpolation.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace hvi::solver {

/// A tabulated function. Values outside the table's range are NaN: the callers turn that into an
/// error with the place, since a wrong extrapolation would be a silent wrong answer.
class Table {
public:
  enum class Interpolation { linear, monotone_cubic };
  /// `x` strictly increasing, at least two points, all finite; else std::invalid_argument.
  Table(std::string name, std::vector<double> x, std::vector<double> y, Interpolation kind);

  double value(double x) const;
  double slope(double x) const;
  /// Bounds of the values (or of the slope) on the part of [low, high] inside the range; low <=
  /// high, and the two meet the range. The bounds are attained except for the slope of a cubic.
  std::pair<double, double> range(double low, double high, bool of_slope) const;
  double first() const { return x_.front(); }
  double last() const { return x_.back(); }
  const std::vector<double>& abscissae() const { return x_; }
  const std::vector<double>& ordinates() const { return y_; }
  const std::string& name() const { return name_; }
  Interpolation interpolation() const { return kind_; }

private:
  std::string name_;
  std::vector<double> x_, y_, slopes_;
  Interpolation kind_;
};

/// Reads two columns of a CSV text (comma, semicolon or blank separated, optional header, `#`
/// comments). Throws std::invalid_argument with the line number on anything else.
Table parse_table(std::string name, const std::string& text, Table::Interpolation kind);

} // namespace hvi::solver
