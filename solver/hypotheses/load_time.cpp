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

/// f as a function of t alone, at one of two places that have nothing in common.
Expr at_a_place(const Expr& f, int which) {
  std::vector<std::pair<Slot, Expr>> values;
  for (const Slot s : f.slots())
    if (s != slot::t) values.emplace_back(s, Expr(which == 0 ? 0.37 + 0.11 * s : 0.71 - 0.07 * s));
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
    places.push_back(0.0 - affine->first.value() / affine->second.value()); // not -0
}

void collect(const Expr& e, std::vector<double>& places) {
  const auto args = e.args();
  const bool negative_power =
      e.op() == Op::pow && !(args[1].is_constant() && args[1].value() >= 0.0);
  if (negative_power || e.op() == Op::log || e.op() == Op::tan) add_zero(args[0], places);
  if (e.op() == Op::div) add_zero(args[1], places);
  for (const Expr& a : args) collect(a, places);
}

/// Of f at `at` + side d. The place is put into the expression, so that distances far below its
/// rounding count.
double exponent_beside(const Expr& f, double at, double side) {
  const std::array<std::pair<Slot, Expr>, 1> change{
      {{slot::t, Expr(at) + Expr(side) * Expr::variable(slot::t)}}};
  return exponent_of_growth(substitute(f, change));
}

} // namespace

double exponent_of_growth(const Expr& f) {
  const Expr moved = expand(f);
  const auto size = [&](double d) { return std::abs(evaluate(moved, [&](Slot) { return d; })); };
  double exponent = 0.0;
  // Where the place is no number of the machine, distances below its rounding say nothing.
  for (const auto& [near, far] : {std::pair{1e-60, 1e-40}, std::pair{1e-9, 1e-7}}) {
    const double a = size(near), b = size(far);
    if (std::isnan(a) || std::isnan(b) || b == 0.0) continue;
    const bool far_enough = far > 1e-10; // nearer, rounding may have reached the pole itself
    if (!std::isfinite(b) && far_enough) return infinity;
    if (!std::isfinite(a) || !std::isfinite(b)) continue;
    const double slope = std::log(a / b) / std::log(far / near);
    exponent = std::max(exponent, slope > 0.02 ? slope : 0.0);
  }
  return exponent;
}

std::optional<TimeSingularity> time_singularity(const Expr& f, double t0, double t1) {
  const Expr line = at_a_place(f, 0);
  std::vector<double> places, elsewhere;
  collect(line, places);
  collect(at_a_place(f, 1), elsewhere);
  std::erase_if(places, [&](double at) {
    const double slack = 1e-12 * (std::abs(t0) + std::abs(t1));
    return std::ranges::none_of(elsewhere,
                                [&](double other) { return std::abs(other - at) <= slack; });
  });
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
