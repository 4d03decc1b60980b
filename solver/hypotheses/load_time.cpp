// Singularities of a load in time; see load_time.hpp.
#include "solver/hypotheses/load_time.hpp"

#include "solver/common/numbers.hpp"
#include "solver/kernel/algebra.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace hvi::solver {
namespace {

/// f as a function of t alone.
Expr at_a_point(const Expr& f, double others) {
  std::vector<std::pair<Slot, Expr>> values;
  for (const Slot s : f.slots())
    if (s != slot::t) values.emplace_back(s, Expr(others));
  return substitute(f, values);
}

/// Zeros of an affine function of t, whatever |.| stands around it.
void add_zero(const Expr& e, std::vector<double>& places) {
  if (e.op() == Op::abs || e.op() == Op::neg) return add_zero(e.args()[0], places);
  if (e.op() == Op::pow) return add_zero(e.args()[0], places);
  if (e.op() == Op::mul) {
    for (const Expr& factor : e.args()) add_zero(factor, places);
    return;
  }
  const auto affine = affine_in(e, slot::t);
  if (!affine || !affine->first.is_constant() || !affine->second.is_constant()) return;
  if (affine->second.value() != 0.0)
    places.push_back(-affine->first.value() / affine->second.value());
}

void collect(const Expr& e, std::vector<double>& places) {
  const auto args = e.args();
  const bool negative_power =
      e.op() == Op::pow && !(args[1].is_constant() && args[1].value() >= 0.0);
  if (negative_power || e.op() == Op::log || e.op() == Op::tan) add_zero(args[0], places);
  if (e.op() == Op::div) add_zero(args[1], places);
  for (const Expr& a : args) collect(a, places);
}

/// -d log|f| / d log d as d -> 0, f at `at` + side d. The place is put into the expression, so that
/// distances far below its rounding count.
double exponent_beside(const Expr& f, double at, double side) {
  const std::array<std::pair<Slot, Expr>, 1> change{
      {{slot::t, Expr(at) + Expr(side) * Expr::variable(slot::t)}}};
  const Expr moved = expand(substitute(f, change));
  const auto size = [&](double d) { return std::abs(evaluate(moved, [&](Slot) { return d; })); };
  double exponent = 0.0;
  // Where the place is no number of the machine, distances below its rounding say nothing.
  for (const auto& [near, far] : {std::pair{1e-60, 1e-40}, std::pair{1e-9, 1e-7}}) {
    const double a = size(near), b = size(far);
    if (std::isnan(a) || std::isnan(b) || b == 0.0) continue;
    if (!std::isfinite(b)) return infinity;
    if (!std::isfinite(a)) continue;
    const double slope = std::log(a / b) / std::log(far / near);
    exponent = std::max(exponent, slope > 0.02 ? slope : 0.0);
  }
  return exponent;
}

} // namespace

std::optional<TimeSingularity> time_singularity(const Expr& f, double t0, double t1,
                                                double others) {
  const Expr line = at_a_point(f, others);
  std::vector<double> places;
  collect(line, places);
  std::optional<TimeSingularity> worst;
  for (const double at : places) {
    const double slack = 1e-12 * (std::abs(t0) + std::abs(t1));
    if (at < t0 - slack || at > t1 + slack) continue;
    double exponent = 0.0;
    if (at < t1 - slack) exponent = std::max(exponent, exponent_beside(line, at, 1.0));
    if (at > t0 + slack) exponent = std::max(exponent, exponent_beside(line, at, -1.0));
    if (exponent > 0.0 && (!worst || exponent > worst->exponent)) worst = {at, exponent};
  }
  return worst;
}

} // namespace hvi::solver
