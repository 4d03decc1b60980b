// Roots of switch functions (roots.hpp).
#include "solver/law/roots.hpp"

#include "solver/law/supremum.hpp"

#include <boost/math/tools/toms748_solve.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace hvi::solver {

namespace {

constexpr double farthest = 1e15, nearest = 1e-30;
constexpr double resolution = 1e-9; ///< relative: roots closer than this count as one
constexpr int most_enclosures = 40000;

/// A root of f between a and b, where its signs differ, by Boost's implementation of G. E. Alefeld,
/// F. A. Potra, Y. Shi, Algorithm 748: enclosing zeros of continuous functions, ACM Trans. Math.
/// Softw. 21 (1995) 327-344; the end of the last bracket with the smaller |f|.
template <class F>
double bracketed(const F& f, double a, double b, double fa, double fb) {
  std::uintmax_t iterations = 400;
  const auto done = [](double p, double q) {
    return std::abs(p - q) <= 0x1p-52 * std::min(std::abs(p), std::abs(q));
  };
  const auto [p, q] = boost::math::tools::toms748_solve(f, a, b, fa, fb, done, iterations);
  return std::abs(f(p)) <= std::abs(f(q)) ? p : q;
}

bool excludes_zero(const Bounds& b) { return b.known && (b.low > 0.0 || b.high < 0.0); }
bool one_sign(const Bounds& b) { return b.known && b.defined && (b.low > 0.0 || b.high < 0.0); }
bool never_crosses(const Bounds& b) { return b.known && (b.low >= 0.0 || b.high <= 0.0); }

} // namespace

/// One search for roots.
class RootIsolation {
public:
  RootIsolation(const RootFinder& finder, const Point& x, LawTime t, double target, bool crossings,
                std::vector<double>& roots)
      : finder_(finder), x_(x), t_(t), target_(target), crossings_(crossings), roots_(roots),
        before_(roots.size()) {
    const auto fixed = fixed_at(x, t);
    for (const Slot s : finder.intervals_.inputs())
      inputs_.push_back(s == slot::r ? Bounds{} : fixed(s));
  }

  /// False when it was given up.
  bool search(double low, double high) {
    low_ = low, high_ = high;
    const double a = std::max(low, -farthest), b = std::min(high, farthest);
    if (!(a < b)) return true;
    if (a < 0.0 && b > 0.0) return part(a, 0.0) && part(0.0, b);
    return part(a, b);
  }

private:
  double f(double r) const {
    double out[2];
    finder_.tape_(r, x_, t_, out);
    return out[0] - target_;
  }
  double slope(double r) const {
    double out[2];
    finder_.tape_(r, x_, t_, out);
    return out[1];
  }
  void keep(double r) {
    if (r > low_ && r < high_) roots_.push_back(r);
  }

  bool part(double a, double b) {
    if (++enclosures_ > most_enclosures || roots_.size() - before_ > RootFinder::most_roots)
      return false;
    for (std::size_t i = 0; i < inputs_.size(); ++i)
      if (finder_.intervals_.inputs()[i] == slot::r) inputs_[i] = {a, b};
    std::array<Bounds, 3> out;
    const bool continuous = finder_.intervals_(inputs_, out, work_);
    const Bounds value{out[0].low - target_, out[0].high - target_, out[0].known, out[0].defined};
    if (excludes_zero(value) || (crossings_ && never_crosses(value))) return true;
    const bool smooth = continuous && std::isfinite(f(a)) && std::isfinite(f(b));
    if (smooth && one_sign(out[1])) return monotone(a, b), true;
    if (smooth && one_sign(out[2])) return bowed(a, b), true;
    const double size = std::max(std::abs(a), std::abs(b));
    if (b - a <= resolution * size || size <= nearest) return unresolved(a, b), true;
    const double m = middle(a, b);
    return part(a, m) && part(m, b);
  }

  /// In the middle of the logarithms, where the ends have different sizes.
  static double middle(double a, double b) {
    const double small = std::min(std::abs(a), std::abs(b)),
                 large = std::max(std::abs(a), std::abs(b));
    const double sign = b > 0.0 ? 1.0 : -1.0;
    if (small == 0.0) return sign * std::max(large / 256.0, nearest / 2.0);
    if (large > 4.0 * small) return sign * std::sqrt(small) * std::sqrt(large);
    return a + (b - a) / 2.0;
  }

  void monotone(double a, double b) {
    const double fa = f(a), fb = f(b);
    if (fa == 0.0) keep(a);
    if (fb == 0.0) keep(b);
    if (fa * fb < 0.0) keep(bracketed([&](double r) { return f(r); }, a, b, fa, fb));
  }

  /// f' has at most one root: f is monotone on both sides of it, or has a double root there.
  void bowed(double a, double b) {
    const double da = slope(a), db = slope(b);
    if (!(da * db < 0.0)) return monotone(a, b);
    const double c = bracketed([&](double r) { return slope(r); }, a, b, da, db);
    const double fc = f(c), noise = 64.0 * 0x1p-52 * std::min(std::abs(f(a)), std::abs(f(b)));
    if (std::abs(fc) <= noise) return keep(c);
    monotone(a, c);
    monotone(c, b);
  }

  /// Too short to be cut: a root counts where the signs differ, or where f is rounding.
  void unresolved(double a, double b) {
    const double fa = f(a), fb = f(b);
    if (fa == 0.0) keep(a);
    if (fb == 0.0) keep(b);
    if (fa * fb < 0.0)
      keep(bracketed([&](double r) { return f(r); }, a, b, fa, fb));
    else if (!crossings_ && f(a + (b - a) / 2.0) == 0.0)
      keep(a + (b - a) / 2.0);
  }

  const RootFinder& finder_;
  const Point& x_;
  LawTime t_;
  double target_;
  bool crossings_;
  std::vector<double>& roots_;
  std::size_t before_;
  double low_ = 0.0, high_ = 0.0;
  int enclosures_ = 0;
  std::vector<Bounds> inputs_, work_;
};

RootFinder::RootFinder(const Expr& f) {
  const Expr slope = derivative(f, slot::r);
  affine_ = !slope.depends_on(slot::r);
  const std::pair<Slot, Expr> at_zero{slot::r, Expr(0.0)};
  const Expr both[2] = {affine_ ? slope : f, affine_ ? substitute(f, {&at_zero, 1}) : slope};
  tape_ = PointTape(both);
  if (affine_) return;
  const Expr all[3] = {f, slope, derivative(slope, slot::r)};
  intervals_ = IntervalTape(all);
}

bool RootFinder::find(const Point& x, LawTime t, double target, double low, double high,
                      bool crossings, std::vector<double>& roots) const {
  if (!affine_) return RootIsolation(*this, x, t, target, crossings, roots).search(low, high);
  double ab[2];
  tape_(0.0, x, t, ab);
  const double root = (target - ab[1]) / ab[0];
  if (std::isfinite(root) && root > low && root < high) roots.push_back(root == 0.0 ? 0.0 : root);
  return true;
}

} // namespace hvi::solver
