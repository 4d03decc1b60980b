// Interpolation in a table (table.hpp).
#include "solver/kernel/table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace hvi::solver {

namespace {

/// One-sided three-point slope at an end, limited so that the curve stays monotone (the end
/// condition of PCHIP).
double end_slope(double h0, double h1, double d0, double d1) {
  const double m = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
  if (m * d0 <= 0.0) return 0.0;
  if (d0 * d1 <= 0.0 && std::abs(m) > 3.0 * std::abs(d0)) return 3.0 * d0;
  return m;
}

/// Slopes of a monotone cubic: a weighted harmonic mean of the neighbouring difference quotients, 0
/// where they change sign (F. N. Fritsch, J. Butland, A method for constructing local monotone
/// piecewise cubic interpolants, SIAM J. Sci. Stat. Comput. 5 (1984) 300-304).
std::vector<double> monotone_slopes(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t n = x.size();
  std::vector<double> h(n - 1), d(n - 1), m(n);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    h[i] = x[i + 1] - x[i];
    d[i] = (y[i + 1] - y[i]) / h[i];
  }
  if (n == 2) return {d[0], d[0]};
  for (std::size_t i = 1; i + 1 < n; ++i) {
    if (d[i - 1] * d[i] <= 0.0) continue; // m is 0
    const double w1 = 2.0 * h[i] + h[i - 1], w2 = h[i] + 2.0 * h[i - 1];
    m[i] = (w1 + w2) / (w1 / d[i - 1] + w2 / d[i]);
  }
  m[0] = end_slope(h[0], h[1], d[0], d[1]);
  m[n - 1] = end_slope(h[n - 2], h[n - 3], d[n - 2], d[n - 3]);
  return m;
}

/// The interval [x[i], x[i + 1]] that holds v; the right one at a knot.
std::size_t interval_of(const std::vector<double>& x, double v) {
  const auto above = std::upper_bound(x.begin() + 1, x.end() - 1, v);
  return static_cast<std::size_t>(above - x.begin()) - 1;
}

} // namespace

Table::Table(std::string name, std::vector<double> x, std::vector<double> y, Interpolation kind)
    : name_(std::move(name)), x_(std::move(x)), y_(std::move(y)), kind_(kind) {
  if (x_.size() < 2 || x_.size() != y_.size())
    throw std::invalid_argument("table " + name_ + " needs at least two points");
  for (std::size_t i = 0; i < x_.size(); ++i) {
    if (!std::isfinite(x_[i]) || !std::isfinite(y_[i]))
      throw std::invalid_argument("table " + name_ + " has a value that is not finite");
    if (i > 0 && !(x_[i - 1] < x_[i]))
      throw std::invalid_argument("table " + name_ + ": the first column must increase");
    if (i > 0 && !std::isfinite((y_[i] - y_[i - 1]) / (x_[i] - x_[i - 1])))
      throw std::invalid_argument("table " + name_ + " is too steep for floating point");
  }
  if (kind_ == Interpolation::monotone_cubic) slopes_ = monotone_slopes(x_, y_);
}

double Table::value(double x) const {
  if (!(x >= first() && x <= last())) return std::numeric_limits<double>::quiet_NaN();
  const std::size_t i = interval_of(x_, x);
  const double h = x_[i + 1] - x_[i], s = (x - x_[i]) / h;
  if (kind_ == Interpolation::linear) return (1.0 - s) * y_[i] + s * y_[i + 1];
  const double r = 1.0 - s; // Hermite basis
  return r * r * ((1.0 + 2.0 * s) * y_[i] + s * h * slopes_[i]) +
         s * s * ((1.0 + 2.0 * r) * y_[i + 1] - r * h * slopes_[i + 1]);
}

double Table::slope(double x) const {
  if (!(x >= first() && x <= last())) return std::numeric_limits<double>::quiet_NaN();
  const std::size_t i = interval_of(x_, x);
  const double h = x_[i + 1] - x_[i], chord = (y_[i + 1] - y_[i]) / h;
  if (kind_ == Interpolation::linear) return chord;
  const double s = (x - x_[i]) / h, r = 1.0 - s;
  return 6.0 * s * r * chord + r * (1.0 - 3.0 * s) * slopes_[i] +
         s * (1.0 - 3.0 * r) * slopes_[i + 1];
}

std::pair<double, double> Table::range(double low, double high, bool of_slope) const {
  low = std::max(low, first());
  high = std::min(high, last());
  std::pair<double, double> found{HUGE_VAL, -HUGE_VAL};
  const auto include = [&found](double v) {
    found.first = std::min(found.first, v);
    found.second = std::max(found.second, v);
  };
  const std::size_t from = interval_of(x_, low), to = interval_of(x_, high);
  if (!of_slope) { // monotone between knots
    include(value(low));
    include(value(high));
    for (std::size_t i = from + 1; i <= to; ++i) include(y_[i]);
    return found;
  }
  for (std::size_t i = from; i <= to; ++i) {
    const double chord = (y_[i + 1] - y_[i]) / (x_[i + 1] - x_[i]);
    if (kind_ == Interpolation::linear) {
      include(chord);
      continue;
    }
    // The slope is a parabola; its Bernstein coefficients enclose it.
    include(slopes_[i]);
    include(3.0 * chord - slopes_[i] - slopes_[i + 1]);
    include(slopes_[i + 1]);
  }
  return found;
}

} // namespace hvi::solver
