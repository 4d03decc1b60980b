// Point-wise operations of the inequality solver: states of the graph, linearisations, products
// with G (engine.hpp).
#include "solver/inequality/engine.hpp"
#include "solver/inequality/rounding_of_arguments.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

namespace {

double norm(const Small& v) { return std::hypot(v[0], v[1], v[2]); }
double dot(const Small& a, const Small& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// v / |v|, or the second choice, or the first axis, when v is 0.
Small direction_of(const Small& v, const Small& otherwise) {
  for (const Small* u : {&v, &otherwise}) {
    const double length = norm(*u);
    if (length > 0.0) return {(*u)[0] / length, (*u)[1] / length, (*u)[2] / length};
  }
  return {1.0, 0.0, 0.0};
}

} // namespace

Small InequalityEngine::at(const Vector& v, int p) const {
  Small out{};
  for (int k = 0; k < points[p].rows; ++k) out[k] = v[points[p].first + k];
  return out;
}

void InequalityEngine::put(Vector& v, int p, const Small& value) const {
  for (int k = 0; k < points[p].rows; ++k) v[points[p].first + k] = value[k];
}

void InequalityEngine::update_z() {
  z.noalias() = problem.g * c;
  z += problem.offset;
}

void InequalityEngine::gather(const Vector& x) { force.noalias() = force_of * x; }

/// force = G^T W x, and the sum of the absolute values of what makes it.
void InequalityEngine::gather_with_magnitude(const Vector& x) {
  const int* start = force_of.outerIndexPtr();
  const int* column = force_of.innerIndexPtr();
  const double* value = force_of.valuePtr();
  for (int i = 0; i < n; ++i) {
    double sum = 0.0, size = 0.0;
    for (int e = start[i]; e < start[i + 1]; ++e) {
      const double term = value[e] * x[column[e]];
      sum += term;
      size += std::abs(term);
    }
    force[i] = sum;
    force_magnitude[i] = size;
  }
}

/// reach_i = |c_i| + (|r_i| + |(S c)_i - S_ii c_i|) / S_ii: how far unknown i would go under the
/// forces of its own equation, were the others held. It stays where all displacements are rounding.
/// And a part of the largest: where nothing acts, the displacement is rounding of the others.
void InequalityEngine::update_reach() {
  for (int i = 0; i < n; ++i) {
    const double stiffness = std::abs(diagonal[i]);
    reach[i] = std::abs(c[i]);
    if (stiffness > 0.0)
      reach[i] += (std::abs((*rhs)[i]) + std::abs(sc[i] - diagonal[i] * c[i])) / stiffness;
  }
  if (n > 0) reach.array() += part_of_largest_reach * reach.maxCoeff();
}

/// z within this of a break counts as on it: rounding of G c + g before anything cancels in it
/// (which depends on the axes), and of the displacements that the forces at the point amount to.
double InequalityEngine::snap(int p) const {
  const PointData& q = points[p];
  const Vector& known = problem.offset_size.size() == n_rows ? problem.offset_size : problem.offset;
  double size = 0.0;
  for (int row = q.first; row < q.first + q.rows; ++row) {
    double sum = std::abs(known[row]);
    for (SparseMatrix::InnerIterator it(problem.g, row); it; ++it)
      sum += std::abs(it.value()) * reach[it.col()];
    size = std::max(size, sum);
  }
  return snap_factor * size;
}

/// All rows of the point are held: at a break of a scalar law, at the origin of a radial one.
bool InequalityEngine::resting(int p) const {
  if (state[p] < 0) return true;
  return state[p] % 2 == 1 && points[p].rows == 1;
}

/// Adds the residual of a resting point's own equations to its multiplier, if the law allows it.
bool InequalityEngine::balance(int p) {
  const PointData& q = points[p];
  const PreparedLaw& law = prepared[q.law];
  const Small before = at(trial, p);
  Small value = before;
  for (int k = 0; k < q.rows; ++k)
    for (SparseMatrix::InnerIterator it(problem.g, q.first + k); it; ++it)
      value[k] += residual[it.col()] / (q.weight * it.value());
  const Small zp = at(z, p);
  const double distance =
      inclusion_distance(law.law(), law.graph(), zp.data(), value.data(), q.rows, snap(p));
  if (!(distance <= 1e-14 * norm(value))) return false;
  put(trial, p, value);
  return value != before;
}

/// Puts a point that rests at a break exactly there, where its rows touch one unknown each: its
/// finite stiffness left it there up to 1e-13 of its compliance.
void InequalityEngine::settle(int p) {
  const PointData& q = points[p];
  if (!q.single || !resting(p)) return;
  for (int k = 0; k < q.rows; ++k) {
    const int row = q.first + k;
    for (SparseMatrix::InnerIterator it(problem.g, row); it; ++it)
      if (it.value() != 0.0) c[it.col()] = (z_hat[row] - problem.offset[row]) / it.value();
  }
}

Small InequalityEngine::apply_d(int p, const Small& v) const {
  const auto& m = d[p];
  return {m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
          m[6] * v[0] + m[7] * v[1] + m[8] * v[2]};
}

/// The smallest multiplier that the law of a point allows at a break.
double InequalityEngine::least_at_break(int p, int i) const {
  const LawGraph& g = prepared[points[p].law].graph();
  return std::clamp(0.0, std::min(g.left[i], g.right[i]), std::max(g.left[i], g.right[i]));
}

/// Linearises the graph about a point of it: xi = xi_hat + D (z - z_hat). A state at a break holds
/// z there by a large stiffness around the present multiplier; repeating the step makes it exact.
/// Where points share unknowns, some parts of their multipliers have no effect and would stay what
/// they were for ever: a point that comes to rest brings none with it.
void InequalityEngine::linearise(int p, const GraphPoint& hit, const Small& e) {
  const PointData& q = points[p];
  const bool at_break = hit.state < 0 || hit.state % 2 == 1;
  const bool comes = at_break && !q.exclusive && state[p] != hit.state;
  state[p] = hit.state;
  auto& m = d[p];
  m.fill(0.0);
  if (!prepared[q.law].radial()) {
    m[0] = at_break ? q.penalty : std::clamp(hit.d, -q.penalty, q.penalty);
    put(z_hat, p, {hit.z, 0.0, 0.0});
    if (!at_break)
      put(xi_hat, p, {hit.s, 0.0, 0.0});
    else
      put(xi_hat, p, comes ? Small{least_at_break(p, hit.state / 2), 0.0, 0.0} : at(xi, p));
    return;
  }
  if (hit.state < 0) {
    for (int k = 0; k < q.rows; ++k) m[4 * k] = q.penalty;
    put(z_hat, p, {});
    put(xi_hat, p, comes ? Small{} : at(xi, p));
    return;
  }
  const double s = at_break ? dot(at(xi, p), e) : hit.s;
  const double across = std::min(s / hit.z, q.penalty);
  const double along = at_break ? q.penalty : std::clamp(hit.d, -q.penalty, q.penalty);
  for (int i = 0; i < q.rows; ++i)
    for (int j = 0; j < q.rows; ++j)
      m[3 * i + j] = (along - across) * e[i] * e[j] + (i == j ? across : 0.0);
  put(z_hat, p, {hit.z * e[0], hit.z * e[1], hit.z * e[2]});
  put(xi_hat, p, {s * e[0], s * e[1], s * e[2]});
}

void InequalityEngine::enter_state(int p) {
  const PreparedLaw& law = prepared[points[p].law];
  const LawGraph& g = law.graph();
  const Small zp = at(z, p), xp = at(xi, p);
  const int i = state[p] / 2;
  if (state[p] < 0) return linearise(p, {-1, 0.0, 0.0, 0.0}, {});
  const Small e = law.radial() ? direction_of(zp, xp) : Small{1.0, 0.0, 0.0};
  if (state[p] % 2 == 1) return linearise(p, {state[p], g.breaks[i], 0.0, 0.0}, e);
  const LawComponent& k = law.component(component[p]);
  double r = law.radial() ? norm(zp) : zp[0];
  // The tangent is taken inside the piece, or on the extension of an outer one.
  if (i > k.first) r = std::max(r, g.breaks[i - 1]);
  if (i < k.last) r = std::min(r, g.breaks[i]);
  GraphPoint hit = law.on_component(component[p], r);
  if (hit.state != 2 * i) { // at a break: of the two pieces that meet there the wrong one
    hit.state = 2 * i, hit.z = r;
    law.law().slope_and_curvature(g, i, r, hit.s, hit.d);
  }
  if (law.radial() && !(r > 0.0)) return linearise(p, {-1, 0.0, 0.0, 0.0}, {});
  if (!std::isfinite(hit.d)) hit.d = 0.0;
  linearise(p, hit, e);
}

void InequalityEngine::classify(int p, double shrink) {
  const PointData& q = points[p];
  const PreparedLaw& law = prepared[q.law];
  const LawComponent& k = law.component(component[p]);
  const double gamma = q.gamma * shrink;
  const Small zp = at(z, p), xp = at(xi, p);
  Small y;
  for (int i = 0; i < 3; ++i) y[i] = zp[i] + gamma * (xp[i] + k.m * zp[i]);
  const GraphPoint hint{state[p], law.radial() ? norm(zp) : zp[0], 0.0, 0.0};
  const Small e = law.radial() ? direction_of(y, zp) : Small{1.0, 0.0, 0.0};
  linearise(p, law.resolvent(component[p], law.radial() ? norm(y) : y[0], gamma, hint), e);
}

Small InequalityEngine::multiplier(int p) const {
  const PointData& q = points[p];
  const PreparedLaw& law = prepared[q.law];
  const LawGraph& g = law.graph();
  const Small zp = at(z, p), xp = at(xi, p);
  const double tolerance = snap(p);
  const int i = state[p] / 2;
  // A slope that stands for infinity is no multiplier: no state there solves anything.
  const auto slope_at = [&](double r) {
    const double s = law.on_component(component[p], r).s;
    return std::abs(s) < unbounded_slope ? s : std::numeric_limits<double>::quiet_NaN();
  };
  const auto clipped = [&](double v) {
    return std::clamp(v, std::min(g.left[i], g.right[i]), std::max(g.left[i], g.right[i]));
  };
  if (!law.radial()) {
    if (state[p] % 2 == 1 && std::abs(zp[0] - g.breaks[i]) <= tolerance)
      return {clipped(xp[0]), 0, 0};
    const double s = slope_at(zp[0]);
    // Far stiffer than the body: z cannot say what xi is, the increments of Newton's step can.
    const double slack = std::abs(d[p][0]) * tolerance;
    const bool stiff = state[p] % 2 == 0 && std::abs(d[p][0]) * q.local > far_stiffer;
    return {stiff ? std::clamp(xp[0], s - slack, s + slack) : s, 0.0, 0.0};
  }
  const double r = norm(zp);
  // A slip that is rounding has no direction: there, too, it is xi that says where it pulls.
  if ((state[p] == -1 || state[p] == 0) && r <= tolerance) {
    const double ball = std::abs(law.on_component(component[p], 0.0).s), size = norm(xp);
    const double f = size > ball ? ball / size : 1.0;
    return {f * xp[0], f * xp[1], f * xp[2]};
  }
  const Small e = direction_of(zp, xp);
  double s = 0.0;
  if (state[p] % 2 == 1 && state[p] > 0 && std::abs(r - g.breaks[i]) <= tolerance)
    s = clipped(dot(xp, e));
  else
    s = slope_at(r);
  return {s * e[0], s * e[1], s * e[2]};
}

} // namespace hvi::solver
