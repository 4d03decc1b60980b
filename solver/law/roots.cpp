// Roots of switch functions (roots.hpp).
#include "solver/law/roots.hpp"

#include <boost/math/tools/toms748_solve.hpp>

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

constexpr Slot r_slot = slot::argument(0);

/// The scan's abscissae inside (low, high), ends included when they are finite.
std::vector<double> scan_points(double low, double high) {
  std::vector<double> points;
  const auto add = [&](double r) {
    if (r > low && r < high) points.push_back(r);
  };
  for (int k = 15 * 16; k >= -30 * 16; --k) add(-std::pow(10.0, k / 16.0));
  add(0.0);
  for (int k = -30 * 16; k <= 15 * 16; ++k) add(std::pow(10.0, k / 16.0));
  if (std::isfinite(low) && std::isfinite(high)) { // a short cell far from 0 has no log points
    for (int k = 0; k <= 128; ++k) points.push_back(low + (high - low) * (k / 128.0));
    std::sort(points.begin(), points.end());
  } else {
    if (std::isfinite(low)) points.insert(points.begin(), low);
    if (std::isfinite(high)) points.push_back(high);
  }
  return points;
}

/// A root of f between a and b, where its signs differ; the end with the smaller |f|.
template <class F>
double bracketed(const F& f, double a, double b, double fa, double fb) {
  std::uintmax_t iterations = 200;
  const auto done = [](double p, double q) {
    return std::abs(p - q) <= 0x1p-52 * std::min(std::abs(p), std::abs(q));
  };
  const auto [p, q] = boost::math::tools::toms748_solve(f, a, b, fa, fb, done, iterations);
  return std::abs(f(p)) <= std::abs(f(q)) ? p : q;
}

} // namespace

RootFinder::RootFinder(const Expr& f) {
  const Expr slope = derivative(f, r_slot);
  affine_ = !slope.depends_on(r_slot);
  const std::pair<Slot, Expr> at_zero{r_slot, Expr(0.0)};
  const Expr both[2] = {affine_ ? slope : f, affine_ ? substitute(f, {&at_zero, 1}) : slope};
  tape_ = PointTape(both);
}

void RootFinder::find(const Point& x, LawTime t, double target, double low, double high,
                      std::vector<double>& roots) const {
  if (!affine_) return scan(x, t, target, low, high, roots);
  double ab[2];
  tape_(0.0, x, t, ab);
  const double root = (target - ab[1]) / ab[0];
  if (std::isfinite(root) && root > low && root < high) roots.push_back(root == 0.0 ? 0.0 : root);
}

void RootFinder::scan(const Point& x, LawTime t, double target, double low, double high,
                      std::vector<double>& roots) const {
  const auto both = [&](double r, double& f, double& df) {
    double out[2];
    tape_(r, x, t, out);
    f = out[0] - target;
    df = out[1];
  };
  const auto f_of = [&](double r) {
    double f, df;
    return both(r, f, df), f;
  };
  const auto df_of = [&](double r) {
    double f, df;
    return both(r, f, df), df;
  };
  const auto keep = [&](double r) {
    if (r > low && r < high) roots.push_back(r);
  };
  double a = 0.0, fa = 0.0, da = 0.0;
  bool have = false;
  for (const double b : scan_points(low, high)) {
    double fb, db;
    both(b, fb, db);
    if (!std::isfinite(fb)) {
      have = false;
      continue;
    }
    if (fb == 0.0) keep(b);
    if (have && fa * fb < 0.0) keep(bracketed(f_of, a, b, fa, fb));
    if (have && fa * fb > 0.0 && da * db < 0.0) { // an extremum between: two roots, or a double one
      const double c = bracketed(df_of, a, b, da, db), fc = f_of(c);
      const double noise = 64.0 * 0x1p-52 * std::min(std::abs(fa), std::abs(fb));
      if (std::abs(fc) <= noise)
        keep(c);
      else if (fc * fa < 0.0) {
        keep(bracketed(f_of, a, c, fa, fc));
        keep(bracketed(f_of, c, b, fc, fb));
      }
    }
    a = b, fa = fb, da = db, have = true;
  }
}

} // namespace hvi::solver
