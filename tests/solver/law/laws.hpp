// Laws of every kind for the tests, with their slopes written a second time as plain functions.
#pragma once

#include "solver/law/law.hpp"

#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace hvi::solver::test {

inline Expr arg() { return Expr::variable(slot::argument(0)); }
inline Expr x0() { return Expr::variable(slot::x(0)); }
inline Expr time_() { return Expr::variable(slot::t); }

inline Law slope_law(const std::string& name, const Expr& e, bool radial = false) {
  return Law(LawSpec{name, Origin{7}, radial, true, e});
}
inline Law potential_law(const std::string& name, const Expr& e, bool radial = false) {
  return Law(LawSpec{name, Origin{7}, radial, false, e});
}

/// A law and what is known of it by other means.
struct KnownLaw {
  std::string name;
  LawSpec spec;
  std::function<double(double)> slope;     ///< away from breaks, at x = (.5, 0, 0), t = .25
  std::function<double(double)> potential; ///< up to a constant
  std::vector<double> breaks;
  double m, c, ascent; ///< known constants; NaN: not checked
  bool regular = true;
};

inline std::vector<KnownLaw> known_laws() {
  const double inf = std::numeric_limits<double>::infinity(), any = std::nan("");
  const Expr r = arg();
  std::vector<KnownLaw> out;
  const auto add = [&](const std::string& name, bool radial, bool by_slope, const Expr& e,
                       std::function<double(double)> s, std::function<double(double)> j,
                       std::vector<double> breaks, double m, double c, double ascent,
                       bool regular = true) {
    out.push_back(
        {name, {name, Origin{7}, radial, by_slope, e}, s, j, breaks, m, c, ascent, regular});
  };
  add(
      "affine", false, true, Expr(3.0) * r + Expr(1.0), [](double v) { return 3 * v + 1; },
      [](double v) { return 1.5 * v * v + v; }, {}, 0, 3, 3);
  add(
      "compliance", false, true, max(r, Expr(0.0)) * Expr(100.0),
      [](double v) { return v > 0 ? 100 * v : 0; }, [](double v) { return v > 0 ? 50 * v * v : 0; },
      {0.0}, 0, 100, 100);
  // The slab's law: rises, softens, goes on constant.
  const Expr slab = select(less_equal(r, Expr(0.0)), Expr(0.0),
                           select(less_equal(r, Expr(0.02)), Expr(100.0) * r,
                                  select(less_equal(r, Expr(0.08)),
                                         Expr(2.0) - Expr(15.0) * (r - Expr(0.02)), Expr(1.1))));
  const auto slab_slope = [](double v) {
    return v <= 0 ? 0 : (v <= .02 ? 100 * v : (v <= .08 ? 2 - 15 * (v - .02) : 1.1));
  };
  add(
      "slab", false, true, slab, slab_slope,
      [](double v) {
        if (v <= 0) return 0.0;
        if (v <= .02) return 50 * v * v;
        if (v <= .08) return .02 + 2 * (v - .02) - 7.5 * (v - .02) * (v - .02);
        return .02 + .12 - 7.5 * .0036 + 1.1 * (v - .08);
      },
      {0.0, 0.02, 0.08}, 15, 2 / 1.02, 100);
  add(
      "softening exponential", false, true, select(less(r, Expr(0.0)), Expr(0.0), r * exp(-r)),
      [](double v) { return v < 0 ? 0 : v * std::exp(-v); },
      [](double v) { return v < 0 ? 0 : 1 - (1 + v) * std::exp(-v); }, {0.0}, std::exp(-2.0), any,
      1);
  add(
      "absolute value", false, false, abs(r - Expr(1.0)), [](double v) { return v < 1 ? -1 : 1; },
      [](double v) { return std::abs(v - 1); }, {1.0}, 0, 1, inf);
  // Bounds by min and max, nested.
  add(
      "clamped", false, true, min(max(Expr(2.0) * r, Expr(-1.0)), Expr(3.0)),
      [](double v) { return std::min(std::max(2 * v, -1.0), 3.0); },
      [](double v) { return v < -.5 ? -v - .25 : (v < 1.5 ? v * v : 2.25 + 3 * (v - 1.5)); },
      {-0.5, 1.5}, 0, any, 2);
  // The strip's adhesive: the slope jumps down at .5, 1 and 2.
  const Expr saw =
      select(less_equal(r, Expr(0.0)), Expr(0.0),
             select(less(r, Expr(0.5)), Expr(12.0) * r * r,
                    select(less(r, Expr(1.0)), Expr(4.0) * r * r + Expr(4.0) * r,
                           select(less(r, Expr(2.0)), Expr(2.0) * r * r + Expr(2.0) * r + Expr(4.0),
                                  Expr(16.0)))));
  add(
      "sawtooth", false, false, saw,
      [](double v) {
        return v <= 0 ? 0 : (v < .5 ? 24 * v : (v < 1 ? 8 * v + 4 : (v < 2 ? 4 * v + 2 : 0)));
      },
      [](double v) {
        return v <= 0
                   ? 0
                   : (v < .5 ? 12 * v * v
                             : (v < 1 ? 4 * v * v + 4 * v : (v < 2 ? 2 * v * v + 2 * v + 4 : 16)));
      },
      {0.0, 0.5, 1.0, 2.0}, inf, 8, 24);
  add(
      "plastic staircase", false, true,
      select(less(r, Expr(-1.0)), Expr(-2.0), select(less(r, Expr(1.0)), r, Expr(4.0) + r)),
      [](double v) { return v < -1 ? -2 : (v < 1 ? v : 4 + v); },
      [](double v) { return v < -1 ? -2 * v - 1.5 : (v < 1 ? v * v / 2 : v * v / 2 + 4 * v - 4); },
      {-1.0, 1.0}, 0, 2.5, inf);
  add(
      "both jumps", false, true,
      select(less(r, Expr(0.0)), Expr(0.0), select(less(r, Expr(1.0)), Expr(2.0), Expr(1.0))),
      [](double v) { return v < 0 ? 0 : (v < 1 ? 2 : 1); },
      [](double v) { return v < 0 ? 0 : (v < 1 ? 2 * v : 1 + v); }, {0.0, 1.0}, inf, 2, inf, false);
  add(
      "cubic", false, true, r * r * r - r, [](double v) { return v * v * v - v; },
      [](double v) { return v * v * v * v / 4 - v * v / 2; }, {}, 1, inf, inf);
  add(
      "bounded arctan-like", false, true, r / sqrt(Expr(1.0) + r * r),
      [](double v) { return v / std::sqrt(1 + v * v); },
      [](double v) { return std::sqrt(1 + v * v); }, {}, 0, any, 1);
  add(
      "moving bound", false, true,
      select(less(r, x0() + time_()), Expr(2.0) * r, Expr(2.0) * (x0() + time_())),
      [](double v) { return v < .75 ? 2 * v : 1.5; },
      [](double v) { return v < .75 ? v * v : .5625 + 1.5 * (v - .75); }, {0.75}, 0, any, 2);
  add(
      "slip weakening", true, true, Expr(0.5) + Expr(0.2) * exp(Expr(-20.0) * r),
      [](double v) { return .5 + .2 * std::exp(-20 * v); },
      [](double v) { return .5 * v + .01 * (1 - std::exp(-20 * v)); }, {}, 4, 0.7, inf);
  add(
      "Tresca", true, false, Expr(0.3) * r, [](double) { return .3; },
      [](double v) { return .3 * v; }, {}, 0, 0.3, inf);
  add(
      "quadratic regularised friction", true, true, min(Expr(10.0) * r, Expr(1.0)),
      [](double v) { return std::min(10 * v, 1.0); },
      [](double v) { return v < .1 ? 5 * v * v : .05 + (v - .1); }, {0.1}, 0, any, 10);
  add(
      "stepped friction", true, true, select(less(r, Expr(1.0)), Expr(1.0), Expr(2.0)),
      [](double v) { return v < 1 ? 1 : 2; }, [](double v) { return v < 1 ? v : 2 * v - 1; }, {1.0},
      0, 1, inf);
  return out;
}

} // namespace hvi::solver::test
