// States of the points and their linearisations (graph_states.hpp).
#include "solver/inequality/graph_states.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {

/// The smallest multiplier that a law allows at a break.
double least_at_break(const LawGraph& g, int i) {
  return std::clamp(0.0, std::min(g.left[i], g.right[i]), std::max(g.left[i], g.right[i]));
}

} // namespace

Small least_multiplier(const PreparedLaw& law, const Small& z) {
  const double r = size_of(law, z);
  const auto rows = static_cast<int>(z.size());
  if (law.radial() && !(r > 0.0)) return Small::Zero(rows);
  const Interval all = clarke(law.law(), law.graph(), r);
  const double least = std::clamp(0.0, all.low, all.high);
  const double s = std::abs(least) < unbounded_slope ? least : 0.0;
  if (!law.radial()) return along_first(rows, s);
  return s * (z / r);
}

/// Where z is imposed the place follows from it, and no multiplier changes anything.
void GraphStates::enter_given(int p, const Small& z) {
  const PreparedLaw& law = points_.law(p);
  const LawGraph& g = law.graph();
  const double r = size_of(law, z);
  const int piece = piece_of(g, r);
  const bool at_break = piece + 1 < g.pieces() && g.breaks[piece] == r;
  state[p] = law.radial() && !(r > 0.0) ? -1 : 2 * piece;
  if (state[p] >= 0 && at_break && law.valid_state(2 * piece + 1)) state[p] = 2 * piece + 1;
  component[p] = law.component_of_piece(piece);
  std::ranges::fill(points_[p].block(d), 0.0);
  points_[p].put(z_hat, z);
  points_[p].put(xi_hat, least_multiplier(law, z));
}

GraphStates::GraphStates(const ContactPoints& points)
    : state(points.size()), component(points.size()), z_hat(Vector::Zero(points.rows)),
      xi_hat(z_hat), d(points.no_matrices()), points_(points) {}

bool GraphStates::resting(int p) const {
  if (state[p] < 0) return true;
  return state[p] % 2 == 1 && points_[p].rows == 1;
}

void GraphStates::settle(int p, Vector& c) const {
  const PointData& q = points_[p];
  if (!q.single || !resting(p)) return;
  for (int k = 0; k < q.rows; ++k) {
    const int row = q.first + k;
    for (SparseMatrix::InnerIterator it(points_.g, row); it; ++it)
      if (it.value() != 0.0) c[it.col()] = (z_hat[row] - points_.problem.offset[row]) / it.value();
  }
}

Small GraphStates::times_stiffness(int p, const Small& v) const {
  const PointData& q = points_[p];
  const double* entry = q.block(d).data();
  Small out(q.rows);
  for (int i = 0; i < q.rows; ++i) {
    double sum = 0.0;
    for (int j = 0; j < q.rows; ++j) sum += *entry++ * v[j];
    out[i] = sum;
  }
  return out;
}

Small GraphStates::on_tangent(int p, const Vector& z) const {
  const PointData& q = points_[p];
  return q.of(xi_hat) + times_stiffness(p, q.of(z) - q.of(z_hat));
}

/// A point at a break is held there by a large stiffness around its present multiplier; repeated
/// steps make the multiplier exact. Where points share unknowns, parts of their multipliers cancel
/// in the equations and no step would change them: a point that comes to rest begins without.
void GraphStates::linearise(int p, const GraphPoint& hit, const Small& e, const Vector& xi) {
  const PointData& q = points_[p];
  const PreparedLaw& law = points_.law(p);
  const bool at_break = hit.state < 0 || hit.state % 2 == 1;
  const bool comes = at_break && !q.exclusive && state[p] != hit.state;
  state[p] = hit.state;
  const auto m = q.block(d);
  if (!law.radial()) {
    m[0] = at_break ? q.penalty : std::clamp(hit.d, -q.penalty, q.penalty);
    z_hat[q.first] = hit.z;
    xi_hat[q.first] = !at_break ? hit.s
                      : comes   ? least_at_break(law.graph(), hit.state / 2)
                                : xi[q.first];
    return;
  }
  if (hit.state < 0) {
    q.put_multiple(d, q.penalty);
    q.put(z_hat, Small::Zero(q.rows));
    q.put(xi_hat, comes ? Small(Small::Zero(q.rows)) : q.of(xi));
    return;
  }
  const double s = at_break ? q.of(xi).dot(e) : hit.s;
  const double across = std::min(s / hit.z, q.penalty);
  const double along = at_break ? q.penalty : std::clamp(hit.d, -q.penalty, q.penalty);
  for (int i = 0; i < q.rows; ++i)
    for (int j = 0; j < q.rows; ++j)
      m[q.rows * i + j] = (along - across) * e[i] * e[j] + (i == j ? across : 0.0);
  q.put(z_hat, hit.z * e);
  q.put(xi_hat, s * e);
}

void GraphStates::enter(int p, const Vector& z, const Vector& xi) {
  const PreparedLaw& law = points_.law(p);
  const LawGraph& g = law.graph();
  const Small zp = points_[p].of(z), xp = points_[p].of(xi);
  if (points_[p].given) return enter_given(p, zp);
  const int i = state[p] / 2;
  if (state[p] < 0) return linearise(p, {-1, 0.0, 0.0, 0.0}, {}, xi);
  const Small e = law.radial() ? direction_of(zp, xp) : Small();
  if (state[p] % 2 == 1) return linearise(p, {state[p], g.breaks[i], 0.0, 0.0}, e, xi);
  const LawComponent& k = law.component(component[p]);
  double r = size_of(law, zp);
  // The tangent is taken inside the piece, or on the extension of an outer one.
  if (i > k.first) r = std::max(r, g.breaks[i - 1]);
  if (i < k.last) r = std::min(r, g.breaks[i]);
  GraphPoint hit = law.on_component(component[p], r);
  if (hit.state != 2 * i) { // at a break: of the two pieces that meet there the wrong one
    hit.state = 2 * i, hit.z = r;
    law.law().slope_and_curvature(g, i, r, hit.s, hit.d);
  }
  if (law.radial() && !(r > 0.0)) return linearise(p, {-1, 0.0, 0.0, 0.0}, {}, xi);
  if (!std::isfinite(hit.d)) hit.d = 0.0;
  linearise(p, hit, e, xi);
}

void GraphStates::classify(int p, const Vector& z, const Vector& xi, double shrink) {
  const PointData& q = points_[p];
  if (q.given) return enter_given(p, q.of(z));
  const PreparedLaw& law = points_.law(p);
  const LawComponent& k = law.component(component[p]);
  const double gamma = q.gamma * shrink;
  const Small zp = q.of(z), xp = q.of(xi);
  const Small y = zp + gamma * (xp + k.m * zp);
  const GraphPoint hint{state[p], size_of(law, zp), 0.0, 0.0};
  const Small e = law.radial() ? direction_of(y, zp) : Small();
  linearise(p, law.resolvent(component[p], size_of(law, y), gamma, hint), e, xi);
}

} // namespace hvi::solver
