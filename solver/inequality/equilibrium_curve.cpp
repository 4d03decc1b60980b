// The equilibrium curve between two loads (equilibrium_curve.hpp).
#include "solver/inequality/equilibrium_curve.hpp"

#include "solver/common/numbers.hpp"
#include "solver/linear/dense.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {
/// The start leaves corners of the graph by this part of the step, a little different for each
/// point: no two of them reach an end at the same load then. b_1 knows nothing of it.
constexpr double off_corner = 1e-10;
/// z that differs by this part of the problem's size from a break is on it.
constexpr double rounding = 1e-12;
/// A turn on a curved piece is left for a load this much larger: at the turn itself Newton's method
/// has nothing to go by.
constexpr double beyond_turn = 1e-11;
constexpr int most_corrections = 8;

/// Between 1/2 and 1, of points as different as can be (multiples of the golden ratio).
double spread(int p) { return 0.5 + 0.5 * std::fmod(0.6180339887498949 * (p + 1), 1.0); }
} // namespace

EquilibriumCurve::EquilibriumCurve(DenseMatrix compliance, std::vector<CurvePoint> points,
                                   bool symmetric)
    : compliance_(std::move(compliance)), a_(compliance_), points_(std::move(points)),
      symmetric_(symmetric), n_(static_cast<int>(points_.size())) {
  for (int p = 0; p < n_; ++p) a_.col(p) *= points_[p].weight;
  most_ = 2000 + 100 * n_;
}

// ---------------------------------------------------------------- the start

void EquilibriumCurve::put_on_graph(int p, double noise) {
  const CurveGraph& g = *points_[p].graph;
  int piece = 0;
  while (piece + 1 < g.pieces() && z_[p] > g.high(piece) + noise) ++piece;
  place_[p] = 2 * piece;
  if (piece + 1 == g.pieces() || z_[p] < g.high(piece) - noise) return;
  const double below = g.below(piece), above = g.above(piece); // at a break
  z_[p] = g.at(piece);
  if (below < above) {
    place_[p] = 2 * piece + 1;
    xi_[p] = std::clamp(xi_[p], below, above);
  } else if (below > above && xi_[p] < 0.5 * (below + above)) {
    place_[p] = 2 * (piece + 1);
  }
}

void EquilibriumCurve::move_off_corner(int p, double room) {
  const double low = end(p, -1), high = end(p, 1), now = unknown(p);
  const double by = std::min(room * spread(p), 0.25 * (high - low));
  const double to = now - low < by ? low + by : (high - now < by ? high - by : now);
  if (upright(p))
    xi_[p] = to / a_(p, p);
  else
    z_[p] = to;
}

void EquilibriumCurve::start(const Vector& z, const Vector& xi, const Vector& b1) {
  z_ = z, xi_ = xi, d_ = Vector::Zero(n_);
  place_.assign(n_, 0);
  ends_.clear();
  steps_ = 0, load_ = 0.0;
  size_ = std::max(z.lpNorm<Eigen::Infinity>(), b1.lpNorm<Eigen::Infinity>());
  if (!(size_ > 0.0)) size_ = 1.0;
  for (int p = 0; p < n_; ++p) put_on_graph(p, rounding * size_);
  update_xi();
  size_ = std::max(size_, (z_ + a_ * xi_).lpNorm<Eigen::Infinity>());
  const double room = off_corner * (b1 - z_ - a_ * xi_).lpNorm<Eigen::Infinity>();
  for (int p = 0; p < n_; ++p) move_off_corner(p, room);
  update_xi();
  b0_ = z_ + a_ * xi_;
  db_ = b1 - b0_;
  stride_ = 0.05;
}

// ---------------------------------------------------------------- the graph

bool EquilibriumCurve::drop(int p) const {
  const int b = place_[p] / 2;
  return upright(p) && points_[p].graph->below(b) > points_[p].graph->above(b);
}

double EquilibriumCurve::end(int p, int side) const {
  const CurveGraph& g = *points_[p].graph;
  const int i = place_[p] / 2;
  if (!upright(p)) return side > 0 ? g.high(i) : g.low(i);
  const double s = side > 0 ? std::max(g.below(i), g.above(i)) : std::min(g.below(i), g.above(i));
  return s * a_(p, p);
}

void EquilibriumCurve::update_xi() {
  for (int p = 0; p < n_; ++p)
    if (!upright(p)) points_[p].graph->slope(place_[p] / 2, z_[p], xi_[p], d_[p]);
}

// ---------------------------------------------------------------- tangents and corrections

void EquilibriumCurve::make_jacobian() {
  jacobian_.resize(n_, n_);
  for (int p = 0; p < n_; ++p) {
    jacobian_.col(p) = a_.col(p) * (upright(p) ? 1.0 / a_(p, p) : d_[p]);
    if (!upright(p)) jacobian_(p, p) += 1.0;
  }
}

/// The tangent of unit length; its sign is the caller's.
bool EquilibriumCurve::tangent() {
  make_jacobian();
  lu_.compute(jacobian_);
  way_ = lu_.solve(db_);
  const double length = std::hypot(way_.norm() / (size_ * std::sqrt(1.0 * n_)), 1.0);
  way_ /= length, way_load_ = 1.0 / length;
  return way_.allFinite() && std::isfinite(length);
}

/// Newton's method at right angles to the tangent.
bool EquilibriumCurve::correct() {
  const double weight = 1.0 / (size_ * size_ * n_);
  double last = infinity;
  for (int k = 0; k < most_corrections; ++k) {
    update_xi();
    const Vector f = z_ + a_ * xi_ - b0_ - load_ * db_;
    const double error = f.lpNorm<Eigen::Infinity>();
    if (!std::isfinite(error)) return false;
    if (error <= 1e-14 * size_ || (error <= 1e-12 * size_ && error > 0.1 * last)) return true;
    if (error > last) return false;
    last = error;
    make_jacobian();
    bordered_.resize(n_ + 1, n_ + 1);
    bordered_.topLeftCorner(n_, n_) = jacobian_;
    bordered_.topRightCorner(n_, 1) = -db_;
    bordered_.bottomLeftCorner(1, n_) = weight * way_.transpose();
    bordered_(n_, n_) = way_load_;
    Vector right(n_ + 1);
    right.head(n_) = -f;
    right[n_] = 0.0;
    const Vector x = bordered_.partialPivLu().solve(right);
    if (!x.allFinite()) return false;
    for (int p = 0; p < n_; ++p) upright(p) ? xi_[p] += x[p] / a_(p, p) : z_[p] += x[p];
    load_ += x[n_];
  }
  return last <= 1e-10 * size_;
}

/// S + H positive definite, upright points held. Without symmetry, what is the same with it: S + s
/// H regular for all s from 0 to 1, no real eigenvalue of 1 + C W D below 0.
bool EquilibriumCurve::stable() {
  for (int p = 0; p < n_; ++p)
    if (drop(p)) return false;
  if (!symmetric_) {
    make_jacobian();
    for (int p = 0; p < n_; ++p)
      if (upright(p)) jacobian_.col(p) *= 1e9, jacobian_(p, p) += 1.0;
    const auto values = eigenvalues(jacobian_);
    return std::none_of(values.begin(), values.end(),
                        [](const auto& v) { return v.real() <= 0.0 && v.imag() == 0.0; });
  }
  if (root_.size() == 0) {
    DenseMatrix c = 0.5 * (compliance_ + compliance_.transpose());
    c.diagonal().array() += 1e-13 * c.diagonal().maxCoeff();
    root_ = c.llt().matrixL();
  }
  Vector stiffness(n_);
  for (int p = 0; p < n_; ++p) stiffness[p] = points_[p].weight * d_[p];
  for (int p = 0; p < n_; ++p)
    if (upright(p)) stiffness[p] = 1e9 * points_[p].weight / a_(p, p);
  DenseMatrix m = root_.transpose() * stiffness.asDiagonal() * root_;
  m.diagonal().array() += 1.0;
  return m.llt().info() == Eigen::Success;
}

// ---------------------------------------------------------------- steps

/// What is met first on the tangent: the end of a point's place, or the load `target`.
EquilibriumCurve::Event EquilibriumCurve::next_event(double target) const {
  Event out{infinity, none, 0};
  const double load = (target - load_) / way_load_;
  if (load > 0.0) out = {load, by_load, 0};
  for (int p = 0; p < n_; ++p) {
    if (way_[p] == 0.0) continue;
    const int side = way_[p] > 0.0 ? 1 : -1;
    const double length = std::max(0.0, (end(p, side) - unknown(p)) / way_[p]);
    if (length < out.length) out = {length, p, side};
  }
  if (load > 0.0 && load <= out.length + rounding) return {load, by_load, 0};
  return out;
}

bool EquilibriumCurve::go(double length) {
  for (int p = 0; p < n_; ++p) {
    const double by = length * way_[p];
    upright(p) ? xi_[p] += by / a_(p, p) : z_[p] += by;
  }
  load_ += length * way_load_;
  ++steps_;
  return correct();
}

/// What a step went beyond, the farthest; `length` is by how much.
EquilibriumCurve::Event EquilibriumCurve::overrun(double target, bool seeks_load) const {
  Event out{0.0, none, 0};
  double beyond = 0.0; // a point that is there as well goes on from the load
  if (seeks_load && (load_ - target) * way_load_ >= 0.0) {
    out = {std::abs(load_ - target), by_load, 0};
    beyond = std::max(out.length, rounding);
  }
  for (int p = 0; p < n_; ++p)
    for (const int side : {1, -1}) {
      const double over = side * (unknown(p) - end(p, side)) / size_;
      if (over > beyond) out = {over, p, side}, beyond = over;
    }
  return out;
}

/// Puts a point exactly on the end it has reached and on the next place; the way goes on there.
bool EquilibriumCurve::cross(const Event& e) {
  const int p = e.point;
  const CurveGraph& g = *points_[p].graph;
  int side = e.side;
  if (upright(p)) {
    const int b = place_[p] / 2;
    if (drop(p)) side = -side; // xi falls on the way up
    place_[p] = 2 * (side > 0 ? b + 1 : b);
    z_[p] = g.at(b);
  } else {
    const int piece = place_[p] / 2, b = side > 0 ? piece : piece - 1;
    z_[p] = g.at(b);
    if (g.below(b) == g.above(b)) {
      place_[p] = 2 * (side > 0 ? b + 1 : b);
    } else {
      place_[p] = 2 * b + 1;
      xi_[p] = side > 0 ? g.below(b) : g.above(b);
    }
  }
  update_xi();
  if (!tangent()) return false;
  const double forward = (drop(p) ? -way_[p] : way_[p]) * side;
  if (forward < 0.0) reverse();
  return true;
}

/// How far curved pieces let one step go: no point moves by more than `stride_` of the size.
double EquilibriumCurve::longest_curved() const {
  double fastest = 0.0;
  for (int p = 0; p < n_; ++p)
    if (curved(p)) fastest = std::max(fastest, std::abs(way_[p]));
  return fastest > 0.0 ? stride_ * size_ / fastest : infinity;
}

EquilibriumCurve::Step EquilibriumCurve::step(double target) {
  const Event e = next_event(target);
  if (longest_curved() < infinity) return step_on_curved(e, target);
  if (e.point == none || !go(e.length)) return Step::failed;
  if (e.point == by_load) {
    load_ = target;
    return Step::at_load;
  }
  return cross(e) ? Step::crossed : Step::failed;
}

/// One step with corrections; shorter until it ends at what it met, or met nothing.
EquilibriumCurve::Step EquilibriumCurve::step_on_curved(const Event& e, double target) {
  const Vector z = z_, xi = xi_, way = way_;
  const double load = load_, way_load = way_load_;
  const bool seeks_load = (target - load) * way_load > 0.0;
  if (e.point >= 0 && e.length * std::abs(way[e.point]) <= rounding * 0.1 * size_)
    return cross(e) ? Step::crossed : Step::failed;
  double length = std::min(1.05 * e.length, longest_curved());
  for (int tries = 0; tries < 80; ++tries) {
    z_ = z, xi_ = xi, load_ = load, way_ = way, way_load_ = way_load;
    update_xi();
    const bool found = go(length);
    const Event over = found ? overrun(target, seeks_load) : Event{0.0, none, 0};
    if (found && over.point != none && over.length > rounding) {
      const int p = over.point;
      const double from = p == by_load ? load : (upright(p) ? xi[p] * a_(p, p) : z[p]);
      const double now = p == by_load ? load_ : unknown(p);
      const double to = p == by_load ? target : end(p, over.side);
      length *= std::clamp((to - from) / (now - from), 0.01, 1.0 - 1e-3 * (tries > 20));
      continue;
    }
    if (over.point == by_load && found) return to_load(target) ? Step::at_load : Step::failed;
    if (over.point != none && found) return cross(over) ? Step::crossed : Step::failed;
    if (found && tangent()) {
      double cosine = way_.dot(way) / (size_ * size_ * n_) + way_load_ * way_load;
      if (cosine < 0.0) reverse(), cosine = -cosine;
      if (cosine > 0.98) {
        if (tries == 0 && cosine > 0.998) stride_ = std::min(2.0 * stride_, 0.2);
        return Step::moved;
      }
    }
    length *= 0.5, stride_ *= 0.5;
    if (stride_ < 1e-14) return Step::failed;
  }
  return Step::failed;
}

/// Newton's method at the load itself.
bool EquilibriumCurve::to_load(double target) {
  load_ = target;
  const Vector way = way_;
  const double way_load = way_load_;
  way_.setZero(), way_load_ = 1.0;
  const bool found = correct();
  if (!tangent()) return false;
  if (way_.dot(way) / (size_ * size_ * n_) + way_load_ * way_load < 0.0) reverse();
  return found;
}

/// On a curved piece the load was rising before the last step and falls after it: back to where it
/// is largest. Called with the state before the step.
void EquilibriumCurve::locate_turn() {
  double length = longest_curved();
  for (int k = 0; k < 60 && length * way_load_ > 1e-15; ++k) {
    const Vector z = z_, xi = xi_, way = way_;
    const double load = load_, way_load = way_load_;
    const bool found = go(length) && tangent();
    const double cosine = way_.dot(way) / (size_ * size_ * n_) + way_load_ * way_load;
    if (cosine < 0.0) reverse();
    if (found && way_load_ > 0.0) continue;
    z_ = z, xi_ = xi, load_ = load, way_ = way, way_load_ = way_load;
    update_xi();
    length *= 0.5;
  }
}

// ---------------------------------------------------------------- branches

/// On along the curve until it is stable at this load again.
bool EquilibriumCurve::jump_at(double load) {
  while (steps_ < most_) {
    const Step s = step(load);
    if (s == Step::failed) return false;
    if (s == Step::at_load && way_load_ > 0.0 && stable()) return true;
  }
  return false;
}

EquilibriumCurve::Outcome EquilibriumCurve::follow(const Vector& z, const Vector& xi,
                                                   const Vector& b1) {
  start(z, xi, b1);
  if (!tangent()) return Outcome::lost;
  if (!stable()) {
    reverse();
    ends_.push_back({0.0, false});
    if (!jump_at(0.0)) return Outcome::lost;
  }
  while (steps_ < most_) {
    const Vector z_last = z_, xi_last = xi_, way = way_;
    const double load_last = load_, way_load = way_load_;
    const Step s = step(1.0);
    if (s == Step::failed) return Outcome::lost;
    if (s == Step::at_load) return stable() ? Outcome::arrived : Outcome::lost;
    if (way_load_ > 0.0) continue;
    bool dropped = false;
    for (int p = 0; p < n_; ++p) dropped = dropped || drop(p);
    if (s == Step::moved) {
      z_ = z_last, xi_ = xi_last, load_ = load_last, way_ = way, way_load_ = way_load;
      update_xi();
      locate_turn();
    }
    ends_.push_back({load_, dropped});
    const double beside = s == Step::moved ? std::min(1.0, load_ + beyond_turn) : load_;
    if (!jump_at(beside)) return Outcome::lost;
  }
  return Outcome::lost;
}

/// To the curve's end on one side.
void EquilibriumCurve::trace(const std::function<void()>& solution) {
  while (steps_ < most_) {
    const Step s = step(1.0);
    if (s == Step::failed) return;
    if (s == Step::at_load) solution();
  }
}

void EquilibriumCurve::visit(const Vector& z, const Vector& xi, const Vector& b1,
                             const std::function<void()>& solution) {
  for (const bool back : {false, true}) {
    start(z, xi, b1);
    if (!tangent()) return;
    if (back) reverse();
    trace(solution);
  }
}

} // namespace hvi::solver
