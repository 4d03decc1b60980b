// The least energy by branch and bound (least_energy.hpp).
#include "solver/inequality/least_energy.hpp"

#include "solver/common/numbers.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

namespace hvi::solver {

namespace {
/// Part of the body's stiffness that the laws are given at most.
constexpr double share = 0.9;
/// Points of convex laws take this much less of it.
constexpr double convex_share = 0.02;
constexpr int cells_of_curved_piece = 8;
/// What one search may cost: segments looked at, and entries of products.
constexpr double most_work = 1e8;
constexpr int most_boxes = 20000, most_sweeps = 400;
/// Solutions looked for near the bounds' states: always, and where a state has less energy.
constexpr int free_descents = 4, most_descents = 40;
/// Energies are sums that cancel: no bound is better than this part of their terms.
constexpr double energy_rounding = 1e-13;
} // namespace

double LeastEnergy::Result::gap() const {
  if (!std::isfinite(bound) || !(scale > 0.0)) return bound >= lowest ? 0.0 : infinity;
  return std::max(0.0, (lowest - bound) / scale);
}

LeastEnergy::LeastEnergy(const DenseMatrix& compliance, std::vector<CurvePoint> points)
    : c_(compliance), points_(std::move(points)), n_(static_cast<int>(points_.size())) {
  for (const CurvePoint& point : points_) {
    const CurveGraph& g = *point.graph;
    double low = -infinity, high = infinity;
    for (int b = 0; b + 1 < g.pieces(); ++b) {
      if (g.below(b) <= -unbounded_slope) low = g.at(b);
      if (g.above(b) >= unbounded_slope) high = std::min(high, g.at(b));
    }
    domain_low_.push_back(low), domain_high_.push_back(high);
  }
}

/// D, mostly for the points whose law is not convex, and (C^-1 - D)^-1 = C (1 - D C)^-1.
bool LeastEnergy::take_from_body() {
  Vector d(n_);
  for (int p = 0; p < n_; ++p) {
    const CurveGraph& g = *points_[p].graph;
    bool convex = true;
    for (int b = 0; b + 1 < g.pieces(); ++b) convex = convex && g.below(b) <= g.above(b);
    for (int i = 0; i < g.pieces(); ++i)
      convex = convex && g.least_curvature(i, g.low(i), g.high(i)) >= 0.0;
    d[p] = (convex ? convex_share : 1.0) / c_.row(p).cwiseAbs().sum();
  }
  const Vector root = d.cwiseSqrt();
  const DenseMatrix m = root.asDiagonal() * c_ * root.asDiagonal();
  Vector probe = Vector::Ones(n_);
  for (int k = 0; k < 30; ++k) probe = (m * probe).normalized();
  double part = share / std::max(1e-300, probe.dot(m * probe));
  for (int tries = 0; tries < 40; ++tries, part *= 0.95) {
    DenseMatrix rest = -part * m;
    rest.diagonal().array() += 0.5 * (1.0 + share);
    if (Eigen::LLT<DenseMatrix>(rest).info() != Eigen::Success) continue;
    rest.diagonal().array() += 0.5 * (1.0 - share);
    rest_.compute(rest);
    root_ = std::sqrt(part) * root;
    d_ = root_.cwiseAbs2();
    c_tilde_ = root_.cwiseInverse().asDiagonal() * rest_.solve(DenseMatrix(part * m)).eval() *
               root_.cwiseInverse().asDiagonal();
    c_tilde_ = (0.5 * (c_tilde_ + c_tilde_.transpose())).eval();
    return c_tilde_.allFinite();
  }
  return false;
}

// ---------------------------------------------------------------- the laws

double LeastEnergy::phi(int p, int piece, double z) const {
  return points_[p].weight * points_[p].graph->potential(piece, z) + 0.5 * d_[p] * z * z;
}

double LeastEnergy::phi_slope(int p, int piece, double z) const {
  double s = 0.0, d = 0.0;
  points_[p].graph->slope(piece, z, s, d);
  return points_[p].weight * s + d_[p] * z;
}

/// phi of the lowest piece that holds z; infinity outside the domain.
double LeastEnergy::phi_at(int p, double z) const {
  if (!(z >= domain_low_[p] && z <= domain_high_[p])) return infinity;
  const CurveGraph& g = *points_[p].graph;
  int piece = 0;
  while (piece + 1 < g.pieces() && z > g.high(piece)) ++piece;
  return phi(p, piece, z);
}

/// Nowhere on the piece is phi less: by its tangent, or a parabola.
double LeastEnergy::least_on(int p, int piece) const {
  const CurveGraph& g = *points_[p].graph;
  const double low = std::max(g.low(piece), domain_low_[p]),
               high = std::min(g.high(piece), domain_high_[p]);
  if (!(low < high)) return infinity;
  const double k = points_[p].weight * g.least_curvature(piece, low, high) + d_[p];
  const bool bounded = std::isfinite(low) && std::isfinite(high);
  const double from = std::isfinite(low) ? low : (std::isfinite(high) ? high : 0.0);
  const double slope = phi_slope(p, piece, from), value = phi(p, piece, from);
  if (k > 0.0) return value - 0.5 * slope * slope / k;
  if (!bounded || !std::isfinite(k)) return -infinity;
  const double length = high - low; // the tangent of phi - k (z - low) (z - high) / 2
  return value + std::min(0.0, (slope + 0.5 * k * length) * length);
}

/// The parts of the graphs inside the box, with bounds of their curvature.
bool LeastEnergy::make_cells(const Box& box) {
  cells_.assign(n_, {});
  for (int p = 0; p < n_; ++p) {
    const CurveGraph& g = *points_[p].graph;
    for (int i = 0; i < g.pieces(); ++i) {
      const double low = std::max(g.low(i), box.low[p]), high = std::min(g.high(i), box.high[p]);
      if (!(low < high)) continue;
      const int count = g.straight(i) ? 1 : cells_of_curved_piece;
      for (int k = 0; k < count; ++k) {
        const double a = low + (high - low) * k / count,
                     b = k + 1 == count ? high : low + (high - low) * (k + 1) / count;
        const double curvature = g.least_curvature(i, a, b);
        if (!std::isfinite(curvature)) return false;
        cells_[p].push_back({a, b, curvature, i, g.straight(i)});
      }
    }
  }
  return true;
}

/// The cells within a box. A point whose box is one argument has one segment without length.
void LeastEnergy::make_segments(const Box& box) {
  segments_.assign(n_, {});
  for (int p = 0; p < n_; ++p)
    for (const Cell& cell : cells_[p]) {
      const double a = std::max(cell.low, box.low[p]), b = std::min(cell.high, box.high[p]);
      if (!(a <= b)) continue;
      segments_[p].push_back(
          {a, b, phi(p, cell.piece, a), phi(p, cell.piece, b), phi_slope(p, cell.piece, a),
           points_[p].weight * cell.curvature + d_[p], cell.piece, cell.straight});
    }
}

// ---------------------------------------------------------------- the dual problem

/// An upper bound of max slope z - phi(z) on a segment, the tight one of phi made convex there.
double LeastEnergy::conjugate_on(int p, const Segment& s, double slope, double& at) const {
  if (s.straight && s.curvature <= 0.0) {
    const double low = slope * s.a - s.fa, high = slope * s.b - s.fb;
    at = low > high ? s.a : s.b;
    return std::max(low, high);
  }
  if (s.straight) {
    at = std::clamp(s.a + (slope - s.slope) / s.curvature, s.a, s.b);
    const double by = at - s.a;
    return slope * at - (s.fa + by * (s.slope + 0.5 * s.curvature * by));
  }
  const double excess = std::max(0.0, -s.curvature), middle = 0.5 * (s.a + s.b);
  const auto rest = [&](double z) {
    return slope - phi_slope(p, s.piece, z) - excess * (z - middle);
  };
  double low = s.a, high = s.b, best = infinity;
  for (int k = 0; k < 60; ++k) { // rest falls: bisection
    at = k == 0 ? low : (k == 1 ? high : 0.5 * (low + high));
    const double r = rest(at);
    // concave: below its tangent at `at` on all of what is left
    const double value = slope * at - phi(p, s.piece, at) - 0.5 * excess * (at - s.a) * (at - s.b);
    best = std::min(best, value + std::max(0.0, r > 0.0 ? r * (high - at) : r * (low - at)));
    if (k == 0 && r <= 0.0) return best;
    if (k == 1 && r >= 0.0) return best;
    if (k > 1) (r > 0.0 ? low : high) = at;
    if (high - low <= 1e-12 * std::max(std::abs(low), std::abs(high))) break;
  }
  return best;
}

/// phi's conjugate on the box, and where it is attained.
double LeastEnergy::conjugate(int p, double slope, double& at) {
  double best = -infinity, where = 0.0;
  for (const Segment& s : segments_[p]) {
    const double value = conjugate_on(p, s, slope, where);
    work_ += s.straight ? 1.0 : 100.0;
    if (value > best) best = value, at = where;
  }
  return best;
}

/// The best multiplier of one point, the others held: the root of a falling function.
void LeastEnergy::improve(int p, double box_low, double box_high) {
  const double c = c_tilde_(p, p), r = b_tilde_[p] - c_lambda_[p] + c * lambda_[p];
  double low = (r - box_high) / c, high = (r - box_low) / c, at = 0.0;
  double t = std::clamp(lambda_[p], low, high);
  const double enough = 1e-13 * std::max(std::abs(low), std::abs(high));
  for (int k = 0; k < 60 && high - low > enough; ++k) {
    conjugate(p, t, at);
    const double to = (r - at) / c; // the root lies between t and this
    if (to > t) low = t, high = std::min(high, to);
    if (to < t) high = t, low = std::max(low, to);
    if (std::abs(to - t) <= enough) break;
    t = k < 2 ? std::clamp(to, low, high) : 0.5 * (low + high);
  }
  c_lambda_ += (t - lambda_[p]) * c_tilde_.col(p);
  work_ += 0.25 * n_;
  lambda_[p] = t;
}

double LeastEnergy::dual_value() {
  double sum = shift_, at = 0.0, terms = std::abs(shift_);
  for (int p = 0; p < n_; ++p) {
    const double linear = lambda_[p] * (b_tilde_[p] - 0.5 * c_lambda_[p]),
                 law = conjugate(p, lambda_[p], at);
    sum += linear - law;
    terms += std::abs(linear) + std::abs(law);
  }
  return sum - energy_rounding * terms;
}

/// Coordinate by coordinate, as long as that brings the bound closer to the lowest energy.
void LeastEnergy::maximise_dual(Box& box) {
  make_segments(box);
  lambda_ = box.multiplier;
  c_lambda_ = c_tilde_ * lambda_;
  double last = -infinity;
  for (int k = 0; k < most_sweeps; ++k) {
    for (int p = 0; p < n_; ++p) improve(p, box.low[p], box.high[p]);
    if (k % 4 != 3) continue;
    c_lambda_ = c_tilde_ * lambda_;
    const double now = dual_value(), missing = result_.lowest - now;
    if (now > box.bound) box.bound = now, box.multiplier = lambda_;
    if (missing <= 0.1 * proved_least_gap * result_.scale || now - last <= 1e-2 * missing) break;
    last = now;
  }
  lambda_ = box.multiplier;
  c_lambda_ = c_tilde_ * lambda_;
}

// ---------------------------------------------------------------- the search

double LeastEnergy::energy(const Vector& b, const Vector& force, double& scale) const {
  const Vector give = c_ * force;
  const double body = 0.5 * force.dot(give);
  double sum = body;
  scale = std::abs(body);
  for (int p = 0; p < n_; ++p) {
    const double z = b[p] - give[p];
    if (!(z >= domain_low_[p] - 1e-9 * std::abs(z) && z <= domain_high_[p] + 1e-9 * std::abs(z)))
      return infinity;
    const CurveGraph& g = *points_[p].graph;
    const double inside = std::clamp(z, domain_low_[p], domain_high_[p]);
    int piece = 0;
    while (piece + 1 < g.pieces() && inside > g.high(piece)) ++piece;
    const double law = points_[p].weight * g.potential(piece, inside);
    sum += law, scale += std::abs(law);
  }
  return sum;
}

/// The box that holds every state of less energy than the lowest known: E >= shift + sum inf phi +
/// |z - b~|^2 / 2 in the norm of C^-1 - D.
bool LeastEnergy::first_box(Box& box) {
  double room = result_.lowest - shift_;
  for (int p = 0; p < n_; ++p) {
    double least = infinity;
    for (int i = 0; i < points_[p].graph->pieces(); ++i) least = std::min(least, least_on(p, i));
    room -= least;
  }
  if (!std::isfinite(room)) return false;
  room = std::max(room, 0.0) * (1.0 + 1e-9) + 1e-12 * (std::abs(shift_) + result_.scale);
  box.low.resize(n_), box.high.resize(n_);
  for (int p = 0; p < n_; ++p) {
    const double reach = std::sqrt(2.0 * c_tilde_(p, p) * room);
    box.low[p] = std::max(domain_low_[p], b_tilde_[p] - reach);
    box.high[p] = std::min(domain_high_[p], b_tilde_[p] + reach);
    if (!(box.low[p] < box.high[p])) return false;
  }
  return true;
}

/// A state of the body that the bound suggests; if it is promising, the solution next to it.
void LeastEnergy::consider(const Vector& force) {
  double scale = 0.0;
  const double here = energy(b_, force, scale);
  const bool better = here < result_.lowest - 0.1 * proved_least_gap * result_.scale;
  if (!better && descents_ >= free_descents) return;
  if (descents_ >= most_descents) return;
  ++descents_;
  const Vector solved = (*descend_)(force);
  if (solved.size() != n_) return;
  const double there = energy(b_, solved, scale);
  if (!(there < result_.lowest)) return;
  result_.lowest = there, result_.scale = std::max(result_.scale, scale);
}

/// The point whose bound is worst at the state of the box's multipliers, and where to halve it.
int LeastEnergy::worst_point(const Box& box, double& at) {
  const Vector z = b_tilde_ - c_lambda_;
  int worst = -1;
  double most = 0.0, ignored = 0.0;
  for (int p = 0; p < n_; ++p) {
    const double low = box.low[p], high = box.high[p], width = high - low;
    if (!(width > 1e-12 * std::max(std::abs(low), std::abs(high)))) continue;
    const double inside = std::clamp(z[p], low, high);
    const double gap = phi_at(p, inside) - lambda_[p] * inside + conjugate(p, lambda_[p], ignored);
    if (!(gap > most)) continue;
    most = gap, worst = p;
    at = std::clamp(inside, low + 0.2 * width, high - 0.2 * width);
    const CurveGraph& g = *points_[p].graph;
    double closest = infinity; // at a drop the bound is better on both sides
    for (int b = 0; b + 1 < g.pieces(); ++b) {
      const double x = g.at(b), apart = std::abs(x - inside);
      const bool within = x > low + 1e-9 * width && x < high - 1e-9 * width;
      if (within && g.below(b) > g.above(b) && apart < closest) closest = apart, at = x;
    }
  }
  return worst;
}

LeastEnergy::Result LeastEnergy::search(const Vector& b, const Vector& force,
                                        const std::function<Vector(const Vector&)>& descend) {
  b_ = b, descend_ = &descend;
  result_ = {};
  result_.bound = -infinity;
  result_.lowest = energy(b, force, result_.scale);
  if (!take_from_body() || !std::isfinite(result_.lowest)) return result_;
  // Where no law acts all energies are zero but that of moving the body's arguments.
  result_.scale = std::max(result_.scale, 0.5 * b.dot(d_.cwiseProduct(b)));
  const Vector scaled = root_.cwiseProduct(b);
  b_tilde_ = rest_.solve(scaled).cwiseQuotient(root_);
  shift_ = -0.5 * b.dot(d_.cwiseProduct(b_tilde_));
  Box first;
  if (!first_box(first) || !make_cells(first)) return result_;
  first.bound = -infinity;
  first.multiplier = force + d_.cwiseProduct(b - c_ * force);
  std::priority_queue<Box> open;
  const auto look_at = [&](Box& box) {
    maximise_dual(box);
    ++result_.boxes;
    if (box.bound < result_.lowest) consider(lambda_ - d_.cwiseProduct(b_tilde_ - c_lambda_));
    open.push(box);
  };
  look_at(first);
  const auto done = [&] {
    return open.empty() ||
           result_.lowest - open.top().bound <= 0.5 * proved_least_gap * result_.scale;
  };
  while (!done() && work_ < most_work && result_.boxes < most_boxes) {
    Box box = open.top();
    lambda_ = box.multiplier;
    c_lambda_ = c_tilde_ * lambda_;
    make_segments(box);
    double at = 0.0;
    const int p = worst_point(box, at);
    if (p < 0) break; // energy_rounding is all that is left
    open.pop();
    Box upper = box;
    box.high[p] = at, upper.low[p] = at;
    look_at(box);
    look_at(upper);
  }
  result_.bound = open.empty() ? result_.lowest : std::min(result_.lowest, open.top().bound);
  return result_;
}

} // namespace hvi::solver
