// Semismooth Newton on coupled laws (coupled.hpp).
#include "solver/inequality/coupled.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>

namespace hvi::solver {

namespace {

/// Stiffness, against the body's own at the point, that holds a resting point in a linear step:
/// what it gives way the next step takes back, and more would cost digits of the multiplier.
constexpr double holding = 1e8;
/// Steps after which the merit function must be below what it was.
constexpr std::size_t memory_of_merit = 6;
constexpr double shortest_step = 1.0 / 256.0;
constexpr int most_bad_steps = 4;
constexpr int most_iterations = 60;
constexpr double smallest_raise = 1e-4;
constexpr int most_raises = 60;

double norm(const Small& v) { return std::hypot(v[0], v[1], v[2]); }

} // namespace

InequalityEngine::Coupled::Coupled(InequalityEngine& engine) : w(engine) {
  lu = w.op.unsymmetric();
  target_xi = w.xi;
  bound_of.assign(static_cast<std::size_t>(w.n_points), -1);
  std::vector<int> point_of(static_cast<std::size_t>(w.n_rows), -1);
  for (int p = 0; p < w.n_points; ++p) point_of[w.points[p].first] = p;
  for (const CoupledPoint& q : w.problem.coupled) {
    bound_of[q.point] = static_cast<int>(bounds.size());
    bounds.push_back({q.point, point_of[q.row], q.x, {}, 0.0, 0.0, false});
  }
  for (PointData& q : w.points) {
    penalties.push_back(q.penalty);
    q.penalty = std::min(q.penalty, holding / q.local);
  }
}

InequalityEngine::Coupled::~Coupled() {
  for (int p = 0; p < w.n_points; ++p) w.points[p].penalty = penalties[p];
  w.refresh_laws(); // the graphs of the problem again, not those of `bounds`
  w.factored = false;
}

void InequalityEngine::Coupled::go(const Place& place) {
  w.c = place.c, w.xi = place.xi, w.state = place.state, w.component = place.component;
  w.update_z();
}

void InequalityEngine::Coupled::set_share(double value) {
  share = value;
  for (Bound& b : bounds) b.known = false;
}

void InequalityEngine::Coupled::set_bound(Bound& b, double multiplier) {
  if (b.known && b.multiplier == multiplier) return;
  // A trial far inside an obstacle has no pressure that could bound anything; its own law says so.
  if (!(std::abs(multiplier) < unbounded_slope)) {
    if (b.known) return;
    multiplier = 0.0;
  }
  PreparedLaw& law = w.prepared[w.points[b.point].law];
  b.multiplier = multiplier, b.known = true;
  b.graph = law.law().graph(b.x, {w.problem.t, share * multiplier});
  law = PreparedLaw(law.law(), b.graph);
  w.component[b.point] = std::clamp(w.component[b.point], 0, law.components() - 1);
}

/// A difference to a bound a little larger: exact for bounds that are linear in the multiplier.
double InequalityEngine::Coupled::slope_rate(const Bound& b) const {
  const Law& law = w.prepared[w.points[b.point].law].law();
  const double size = std::max(std::abs(b.multiplier), 1e-6 * w.xi.lpNorm<Eigen::Infinity>());
  const double step = std::copysign(1e-6 * std::max(size, 1e-300), b.multiplier);
  const LawGraph other = law.graph(b.x, {w.problem.t, share * (b.multiplier + step)});
  const double r = norm(w.at(w.z_hat, b.point));
  const int piece = w.state[b.point] / 2;
  if (other.pieces() != b.graph.pieces() || w.state[b.point] < 0) return 0.0;
  const double rate = (law.slope(other, piece, r) - law.slope(b.graph, piece, r)) / step;
  return std::isfinite(rate) ? rate : 0.0;
}

double InequalityEngine::Coupled::projected(int p) const {
  const PointData& q = w.points[p];
  if (w.state[p] % 2 == 0) return w.xi_hat[q.first];
  return w.xi[q.first] + (w.z[q.first] - w.z_hat[q.first]) / (scale * q.gamma);
}

/// Places all points on their graphs: first those with a law of their own, then the coupled ones.
void InequalityEngine::Coupled::classify() {
  for (int p = 0; p < w.n_points; ++p)
    if (bound_of[p] < 0) w.classify(p, scale);
  for (Bound& b : bounds) {
    set_bound(b, projected(b.normal));
    w.classify(b.point, scale);
    b.rate = slope_rate(b);
  }
}

/// xi at the present z on the linearised graphs, in `out`.
void InequalityEngine::Coupled::linear_multipliers(Vector& out) const {
  for (int p = 0; p < w.n_points; ++p) {
    Small v = w.at(w.z, p);
    const Small base = w.at(w.z_hat, p), x0 = w.at(w.xi_hat, p);
    for (int i = 0; i < 3; ++i) v[i] -= base[i];
    v = w.apply_d(p, v);
    w.put(out, p, {x0[0] + v[0], x0[1] + v[1], x0[2] + v[2]});
  }
}

/// H = sum_p w_p G_p^T D_p G_p, and w_t G_t^T e (d slope / d multiplier) D_n G_n for coupled
/// points.
void InequalityEngine::Coupled::assemble() {
  entries.clear();
  const auto add = [&](int row, int column, double factor) {
    if (factor == 0.0) return;
    for (SparseMatrix::InnerIterator i(w.problem.g, row); i; ++i)
      for (SparseMatrix::InnerIterator j(w.problem.g, column); j; ++j)
        entries.emplace_back(static_cast<int>(i.col()), static_cast<int>(j.col()),
                             factor * i.value() * j.value());
  };
  for (int p = 0; p < w.n_points; ++p) {
    const PointData& q = w.points[p];
    for (int a = 0; a < q.rows; ++a)
      for (int b = 0; b < q.rows; ++b) add(q.first + a, q.first + b, q.weight * w.d[p][3 * a + b]);
  }
  for (const Bound& b : bounds) {
    const PointData &q = w.points[b.point], &other = w.points[b.normal];
    const Small e = slip(b);
    for (int a = 0; a < q.rows; ++a)
      add(q.first + a, other.first, q.weight * e[a] * b.rate * w.d[b.normal][0]);
  }
  matrix.resize(w.n, w.n);
  matrix.setFromTriplets(entries.begin(), entries.end());
}

Small InequalityEngine::Coupled::slip(const Bound& b) const {
  const Small z = w.at(w.z_hat, b.point);
  const double r = norm(z);
  return r > 0.0 ? Small{z[0] / r, z[1] / r, z[2] / r} : Small{};
}

/// dc, and the multipliers after the full step in `target_xi`; false: no regular matrix.
bool InequalityEngine::Coupled::direction() {
  linear_multipliers(target_xi);
  for (const Bound& b : bounds)
    add_slip(b, b.rate * (target_xi[w.points[b.normal].first] - b.multiplier));
  w.update_product();
  w.gather(target_xi);
  w.residual = *w.rhs - w.sc - w.force;
  assemble();
  ++w.report.factorisations, ++w.report.iterations;
  if (!lu->factor(matrix, {})) return false;
  lu->solve(w.residual, w.dc);
  if (!w.dc.allFinite()) return false;
  w.dz.noalias() = w.problem.g * w.dc;
  for (int p = 0; p < w.n_points; ++p) {
    const Small v = w.apply_d(p, w.at(w.dz, p)), x = w.at(target_xi, p);
    w.put(target_xi, p, {x[0] + v[0], x[1] + v[1], x[2] + v[2]});
  }
  for (const Bound& b : bounds) {
    const int row = w.points[b.normal].first;
    add_slip(b, b.rate * w.d[b.normal][0] * w.dz[row]);
  }
  return true;
}

void InequalityEngine::Coupled::add_slip(const Bound& b, double size) {
  const Small e = slip(b);
  for (int k = 0; k < w.points[b.point].rows; ++k)
    target_xi[w.points[b.point].first + k] += size * e[k];
}

/// |F1|^2 / S_ii + |F2|^2 w / gamma at (c, xi), an energy; places the points.
double InequalityEngine::Coupled::merit() {
  w.update_product();
  w.update_z();
  classify();
  w.gather(w.xi);
  double sum = 0.0;
  for (int i = 0; i < w.n; ++i) {
    const double f = (*w.rhs)[i] - w.sc[i] - w.force[i];
    sum += f * f / std::max(std::abs(w.diagonal[i]), 1e-300);
  }
  for (int p = 0; p < w.n_points; ++p)
    for (int row = w.points[p].first; row < w.points[p].first + w.points[p].rows; ++row) {
      const double f = w.z[row] - w.z_hat[row];
      sum += f * f * w.points[p].weight / (scale * w.points[p].gamma);
    }
  return sum;
}

/// The componentwise residual with multipliers that stand for certain (in `trial`): those of the
/// other laws first, for they are the bounds.
double InequalityEngine::Coupled::multipliers() {
  const auto place_bounds = [&](bool slipping_only) {
    for (Bound& b : bounds) {
      set_bound(b, w.trial[w.points[b.normal].first]);
      if (!slipping_only || !w.resting(b.point)) w.put(w.trial, b.point, w.multiplier(b.point));
    }
  };
  w.update_product();
  w.update_reach();
  for (int p = 0; p < w.n_points; ++p)
    if (bound_of[p] < 0) w.put(w.trial, p, w.multiplier(p));
  place_bounds(false);
  const double ratio = w.residual_ratio(w.trial);
  bool balanced = false;
  for (int p = 0; p < w.n_points; ++p)
    if (bound_of[p] < 0 && w.points[p].exclusive && w.resting(p)) balanced |= w.balance(p);
  if (balanced) place_bounds(true);
  for (int p = 0; p < w.n_points; ++p)
    if (bound_of[p] >= 0 && w.points[p].exclusive && w.resting(p)) balanced |= w.balance(p);
  return balanced ? w.residual_ratio(w.trial) : ratio;
}

/// Puts resting points exactly where they rest; true when the multipliers then solve the problem.
bool InequalityEngine::Coupled::finish(double& ratio) {
  const Vector before = w.c;
  for (int p = 0; p < w.n_points; ++p) w.settle(p);
  w.update_z();
  ratio = multipliers();
  if (ratio <= w.target()) {
    w.xi = w.trial;
    return true;
  }
  w.c = before;
  w.update_z();
  classify(); // the bounds of (c, xi) again
  return false;
}

/// The longest of the steps 1, 1/2, ... that gets below `limit`, else the best of them.
double InequalityEngine::Coupled::line_search(double limit, double& after) {
  const Vector c0 = w.c, xi0 = w.xi, dc = w.dc, xi1 = target_xi;
  double best = 1.0;
  after = std::numeric_limits<double>::infinity();
  const auto try_step = [&](double t) {
    w.c = c0 + t * dc;
    w.xi = xi0 + t * (xi1 - xi0);
    return merit();
  };
  for (double t = 1.0; t >= shortest_step; t /= 2.0) {
    const double value = try_step(t);
    if (value < after) after = value, best = t;
    if (value <= (1.0 - 1e-2 * t) * limit) return t;
  }
  try_step(best);
  return 0.0;
}

bool InequalityEngine::Coupled::newton(int limit) {
  std::deque<double> merits{merit()};
  double ratio = 0.0, last_ratio = std::numeric_limits<double>::infinity();
  for (int k = 0, bad = 0; k < limit && bad < most_bad_steps; ++k) {
    w.snap_factor = k < 8 ? tight_snap : certificate_snap;
    if (!direction()) return false;
    double after = 0.0;
    const double step = line_search(*std::max_element(merits.begin(), merits.end()), after);
    if (!std::isfinite(after)) return false;
    if (finish(ratio)) return true;
    if (step == 1.0 && ratio <= w.options.tolerance && ratio > 0.25 * last_ratio) {
      w.xi = w.trial; // at rounding
      return true;
    }
    last_ratio = ratio;
    bad += step == 0.0;
    merits.push_back(after);
    if (merits.size() > memory_of_merit) merits.pop_front();
  }
  return false;
}

/// Newton's method with z weighed against xi in one way, then in others.
bool InequalityEngine::Coupled::newton_with_scales(int limit) {
  const Place start = here();
  for (const double weight : {1.0, 0.1, 10.0}) {
    scale = weight;
    if (newton(limit)) return true;
    go(start);
  }
  return false;
}

/// Points that leave a component of their law are moved to the next, as for laws without bounds.
bool InequalityEngine::Coupled::solve(int limit) {
  for (int round = 0; round <= 20 * w.n_points + 100; ++round) {
    if (!newton_with_scales(limit)) return false;
    if (w.release_next(round < 40 ? 1e-9 : 0.02 * (round - 39)) == 0) return true;
    w.z_start = w.z;
  }
  return false;
}

/// With bounds that read nothing the laws are plain ones.
bool InequalityEngine::Coupled::solve_uncoupled() {
  for (Bound& b : bounds) set_bound(b, 0.0);
  for (int p = 0; p < w.n_points; ++p) w.enter_state(p);
  return w.solve_components() == Outcome::solved;
}

/// From a solution with share s to those with larger shares; false with the last one it reached.
bool InequalityEngine::Coupled::raise_share() {
  double step = 1.0 - share;
  Place last = here();
  double reached = share;
  for (int raise = 0; reached < 1.0; ++raise) {
    set_share(std::min(1.0, reached + step));
    if (solve(25)) {
      reached = share, last = here();
      step *= 2.0;
      continue;
    }
    go(last);
    step /= 4.0;
    if (step < smallest_raise || raise > most_raises) {
      set_share(reached);
      return false;
    }
  }
  return true;
}

InequalityReport InequalityEngine::solve_coupled(const Vector& right_side, InequalityState& io) {
  report = {};
  rhs = &right_side;
  if (right_side.size() != n || !right_side.allFinite()) return report;
  refresh_laws();
  const bool may_leave = may_soften && io.z_before.size() == n_rows;
  if (may_leave) note_start(io);
  load(io);
  z_start = z;
  components_before = component;
  Coupled f(*this);
  const Coupled::Place start = f.here();
  if (!f.solve(most_iterations)) {
    f.go(start);
    f.set_share(0.0);
    if (f.solve_uncoupled() && !f.raise_share()) f.follow_share();
  }
  certify();
  count_events(components_before);
  store(io);
  report.not_followed = may_leave && may_have_left(io);
  io.z_before.resize(0), io.xi_before.resize(0);
  if (!report.converged)
    report.verdict =
        fmt::format("the laws and the bounds that they give each other were not "
                    "solved together, neither by Newton's "
                    "method nor by raising the bounds from 0 (their last share: {:.3g}): "
                    "a solution may not exist, "
                    "or not near the last one; take smaller steps",
                    f.share);
  return report;
}

} // namespace hvi::solver
