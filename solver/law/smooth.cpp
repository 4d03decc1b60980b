// Smooth branches of a law (smooth.hpp).
#include "solver/law/smooth.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hvi::solver {

namespace {
constexpr int largest_degree = 5;

int degree_of_power(const Expr& e) {
  const Expr& exponent = e.args()[1];
  const int base = polynomial_degree(e.args()[0]);
  if (base < 0 || !exponent.is_constant()) return -1;
  const double n = exponent.value();
  return n >= 0.0 && n <= largest_degree && n == std::floor(n) ? base * static_cast<int>(n) : -1;
}
} // namespace

int polynomial_degree(const Expr& e) {
  if (!e.depends_on(slot::r)) return 0;
  const auto args = e.args();
  switch (e.op()) {
  case Op::slot:
    return 1;
  case Op::neg:
    return polynomial_degree(args[0]);
  case Op::div:
    return args[1].depends_on(slot::r) ? -1 : polynomial_degree(args[0]);
  case Op::pow:
    return degree_of_power(e);
  case Op::add:
  case Op::mul: {
    const int a = polynomial_degree(args[0]), b = polynomial_degree(args[1]);
    if (a < 0 || b < 0) return -1;
    return e.op() == Op::add ? std::max(a, b) : a + b;
  }
  default:
    return -1;
  }
}

SmoothFunction::SmoothFunction(const Expr& expression, bool by_slope)
    : expression_(expression),
      slope_expression_(by_slope ? expression : derivative(expression, slot::r)) {
  const Expr both[2] = {slope_expression_, derivative(slope_expression_, slot::r)};
  slope_ = PointTape(both);
  if (!by_slope) potential_ = PointTape({&expression_, 1});
  degree_ = polynomial_degree(slope_expression_);
  if (degree_ > largest_degree) degree_ = -1;
  if (degree_ < 0) return;
  std::vector<Expr> coefficients{slope_expression_};
  Expr d = slope_expression_;
  double factorial = 1.0;
  for (int k = 1; k <= degree_; ++k) {
    d = derivative(d, slot::r);
    factorial *= k;
    coefficients.push_back(d / Expr(factorial));
  }
  taylor_ = PointTape(coefficients);
}

double SmoothFunction::slope(double r, const Point& x, LawTime t) const {
  double out[2];
  slope_(r, x, t, out);
  return out[0];
}

void SmoothFunction::slope_and_curvature(double r, const Point& x, LawTime t, double& s,
                                         double& c) const {
  double out[2];
  slope_(r, x, t, out);
  s = out[0], c = out[1];
}

LargestValue SmoothFunction::descent(const SupremumRange& range, const Point& x, const LawTime& t,
                                     const SearchEffort& effort) const {
  const std::lock_guard guard(descent_lock_);
  LastDescent& d = descent_;
  if (!std::exchange(d.made, true)) d.search = Supremum(-derivative(slope_expression_, slot::r));
  const bool same = d.answered && d.low == range.low && d.high == range.high && d.x == x &&
                    d.t == t && d.evaluations == effort.evaluations;
  if (!same) {
    d.answer = d.search(range, effort);
    d.answered = true;
    d.low = range.low, d.high = range.high, d.x = x, d.t = t, d.evaluations = effort.evaluations;
  }
  return d.answer;
}

LawGraph::Smooth SmoothFunction::expand(double centre, const Point& x, LawTime t) const {
  LawGraph::Smooth p;
  p.centre = centre;
  p.degree = degree_;
  if (degree_ < 0) return p;
  taylor_(centre, x, t, {p.a.data(), static_cast<std::size_t>(degree_) + 1});
  while (p.degree > 0 && p.a[p.degree] == 0.0) --p.degree;
  return p;
}

std::vector<double> polynomial_roots(std::span<const double> a, double low, double high) {
  std::size_t n = a.size();
  while (n > 1 && a[n - 1] == 0.0) --n;
  if (n < 2) return {};
  if (n == 2) {
    const double r = -a[0] / a[1];
    return r > low && r < high ? std::vector<double>{r} : std::vector<double>{};
  }
  double bound = 0.0; // Cauchy: all roots lie within 1 + max |a_k / a_n|
  for (std::size_t k = 0; k + 1 < n; ++k) bound = std::max(bound, std::abs(a[k] / a[n - 1]));
  low = std::max(low, -1.0 - bound), high = std::min(high, 1.0 + bound);
  std::vector<double> d(n - 1), roots;
  for (std::size_t k = 1; k < n; ++k) d[k - 1] = static_cast<double>(k) * a[k];
  std::vector<double> ends = polynomial_roots(d, low, high);
  ends.insert(ends.begin(), low), ends.push_back(high);
  const auto value = [&](double s) {
    double v = 0.0;
    for (std::size_t k = n; k-- > 0;) v = v * s + a[k];
    return v;
  };
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    double p = ends[i], q = ends[i + 1];
    const double fp = value(p), fq = value(q);
    if (fq == 0.0 && q < high) roots.push_back(q);
    if (!(fp * fq < 0.0)) continue;
    for (int step = 0; step < 200 && p + (q - p) / 2 > p && p + (q - p) / 2 < q; ++step) {
      const double m = p + (q - p) / 2;
      ((value(m) < 0.0) == (fp < 0.0) ? p : q) = m;
    }
    roots.push_back(p);
  }
  return roots;
}

double polynomial(const LawGraph::Smooth& p, double r) {
  const double s = r - p.centre;
  double v = p.a[p.degree];
  for (int k = p.degree - 1; k >= 0; --k) v = v * s + p.a[k];
  return v;
}

double polynomial_slope(const LawGraph::Smooth& p, double r) {
  const double s = r - p.centre;
  double v = 0.0;
  for (int k = p.degree; k >= 1; --k) v = v * s + k * p.a[k];
  return v;
}

double polynomial_primitive(const LawGraph::Smooth& p, double r) {
  const double s = r - p.centre;
  double v = 0.0;
  for (int k = p.degree; k >= 0; --k) v = v * s + p.a[k] / (k + 1);
  return v * s;
}

} // namespace hvi::solver
