// The branch that continues the last state, where a step may have several solutions (engine.hpp).
//
// A step is solved at once first. Where the problem is not known to be convex and a point came
// onto, across or off a piece whose slope falls (or a point changed its place while another stands
// on one), the answer may belong to another branch: the equilibrium curve from the last state says
// which answer continues it, and where branches end on the way.
#include "solver/inequality/engine.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {

namespace {
/// Beyond these the dense compliance of the points takes too much room or time.
constexpr int most_points = 1200;
constexpr double most_entries = 2.5e7;
/// Arguments this close, by the largest, are the same solution.
constexpr double same_solution = 1e-7;
} // namespace

void InequalityEngine::prepare_following() {
  may_soften = false;
  for (const PreparedLaw& law : prepared) {
    may_soften = may_soften || law.components() > 1;
    for (int i = 0; i < law.graph().pieces(); ++i) may_soften = may_soften || law.softens(i);
  }
}

/// Where the path of this step begins.
void InequalityEngine::note_start(const InequalityState& io) {
  const bool told = io.xi_before.size() == n_rows;
  const Vector& at_start = told ? io.xi_before : io.xi;
  xi_before = at_start.size() == n_rows ? at_start : Vector::Zero(n_rows);
  state_before = told ? io.state_before : io.state;
  if (static_cast<int>(state_before.size()) == n_points) return;
  state_before.resize(n_points);
  for (int p = 0; p < n_points; ++p) {
    const PreparedLaw& law = prepared[points[p].law];
    const double at = io.z_before[points[p].first];
    state_before[p] = 2 * piece_of(law.graph(), law.radial() ? std::abs(at) : at);
  }
}

/// Did the step go where another branch may have taken over?
bool InequalityEngine::may_have_left(const InequalityState& now) const {
  bool soft = false, moved = false;
  for (int p = 0; p < n_points; ++p) {
    const PreparedLaw& law = prepared[points[p].law];
    const int before = state_before[p], after = now.state[p];
    const int from = std::clamp(std::min(before, after) / 2, 0, law.graph().pieces() - 1),
              to = std::clamp(std::max(before, after) / 2, 0, law.graph().pieces() - 1);
    if (law.component_of_piece(from) != law.component_of_piece(to)) return true;
    for (int i = from; i <= to; ++i) {
      const int degree = law.graph().smooth[i].degree;
      soft = soft || law.softens(i);
      moved = moved || (law.softens(i) && degree != 0 && degree != 1);
    }
    moved = moved || before != after;
  }
  return soft && moved;
}

/// The compliance of the body at the points, C = G S^-1 G^T, once for S. False: too large, a vector
/// law, or no energy that says which states are stable.
bool InequalityEngine::prepare_curve() {
  curve_graphs.clear();
  for (const PreparedLaw& law : prepared) curve_graphs.emplace_back(law);
  if (curve) return true;
  if (!op.symmetric() || n_points > most_points || 1.0 * n * n_rows > most_entries) return false;
  for (const PointData& q : points)
    if (q.rows != 1) return false;
  Vector column(n), right(n);
  response.resize(n, n_points);
  for (int p = 0; p < n_points; ++p) {
    right.setZero();
    for (SparseMatrix::InnerIterator it(problem.g, points[p].first); it; ++it)
      right[it.col()] += it.value();
    op.solve(right, column);
    response.col(p) = column;
  }
  DenseMatrix compliance(n_points, n_points);
  for (int p = 0; p < n_points; ++p) {
    compliance.row(p).setZero();
    for (SparseMatrix::InnerIterator it(problem.g, points[p].first); it; ++it)
      compliance.row(p) += it.value() * response.row(it.col());
  }
  if (!compliance.allFinite() || !(compliance.diagonal().minCoeff() > 0.0)) return false;
  curve_graphs.reserve(prepared.size()); // points keep their addresses
  std::vector<CurvePoint> all;
  for (const PointData& q : points) all.push_back({&curve_graphs[q.law], q.weight});
  curve.emplace(compliance, std::move(all), op.symmetric());
  return true;
}

/// Where the curve begins: the last state's arguments, those that rest exactly on their breaks.
Vector InequalityEngine::curve_start(const InequalityState& io) const {
  Vector z0(n_points);
  for (int p = 0; p < n_points; ++p) {
    z0[p] = io.z_before[points[p].first];
    const PreparedLaw& law = prepared[points[p].law];
    if (!law.valid_state(state_before[p])) continue;
    if (state_before[p] < 0) z0[p] = 0.0;
    if (state_before[p] >= 0 && state_before[p] % 2 == 1) {
      const double at_break = law.graph().breaks[state_before[p] / 2];
      z0[p] = law.radial() ? std::copysign(at_break, z0[p]) : at_break;
    }
  }
  return z0;
}

/// Goes to a solution of the curve; Newton's method takes it to rounding. False: it went elsewhere.
bool InequalityEngine::settle_on(const CurveSolution& found, InequalityState& io) {
  load(InequalityState{});
  c = found.c;
  for (int p = 0; p < n_points; ++p) xi[points[p].first] = found.xi[p];
  update_z();
  for (int p = 0; p < n_points; ++p) {
    const CurveGraph& g = curve_graphs[points[p].law];
    state[p] = g.engine_state(found.places[p]);
    component[p] = g.component(found.places[p]);
    enter_state(p);
  }
  z_start = z;
  if (newton(options.max_iterations) != Outcome::solved) return false;
  double apart = 0.0, size = 0.0;
  for (int p = 0; p < n_points; ++p) {
    apart = std::max(apart, std::abs(z[points[p].first] - found.z[p]));
    size = std::max(size, std::abs(found.z[p]));
  }
  if (!(apart <= same_solution * size)) return false;
  return accept_found(io);
}

/// The engine's state as the step's answer, if it is certified.
bool InequalityEngine::accept_found(InequalityState& io) {
  certify();
  if (!report.converged) return false;
  report.events = report.reattached = 0;
  for (int p = 0; p < n_points; ++p) {
    const PreparedLaw& law = prepared[points[p].law];
    const int before = std::clamp(state_before[p] / 2, 0, law.graph().pieces() - 1);
    count_crossings(p, law.component_of_piece(before));
  }
  store(io);
  return true;
}

InequalityEngine::CurveSolution InequalityEngine::on_curve(const Vector& free) const {
  CurveSolution out{free, curve->z(), curve->xi(), curve->places()};
  for (int p = 0; p < n_points; ++p) out.c -= response.col(p) * (points[p].weight * out.xi[p]);
  return out;
}

/// The answer of a step that was solved at once, or the one that continues the last state.
void InequalityEngine::follow(InequalityState& io) {
  const bool least = options.branch == Branch::least_energy;
  if (report.converged && !least && !may_have_left(io)) return;
  if (!known_convex) known_convex = convex();
  if (least)
    report.least_gap =
        *known_convex && problem.coupled.empty() ? 0.0 : std::numeric_limits<double>::infinity();
  if (*known_convex) return;
  std::fill(h.valuePtr(), h.valuePtr() + h.nonZeros(), 0.0);
  factored = false; // S itself
  if ((least && !problem.coupled.empty()) || !op.factor(h, {}) || !prepare_curve()) {
    report.not_followed = !least;
    return;
  }
  Vector free(n), xi0(n_points), b1(n_points);
  op.solve(*rhs, free);
  const Vector z1 = problem.g * free + problem.offset;
  for (int p = 0; p < n_points; ++p)
    xi0[p] = xi_before[points[p].first], b1[p] = z1[points[p].first];
  if (least) {
    find_least_energy(b1, free, io);
    if (report.least_gap > proved_least_gap) least_on_curve(curve_start(io), xi0, b1, free, io);
    return;
  }
  const bool arrived =
      curve->follow(curve_start(io), xi0, b1) == EquilibriumCurve::Outcome::arrived;
  report.inner_steps = curve->steps();
  report.not_followed = !arrived;
  if (!arrived) return;
  for (const auto& end : curve->ends()) report.branch_ends.push_back(end.load);
  if (report.converged && is_same(curve->z(), io)) return;
  const InequalityReport at_once = report;
  const InequalityState other = io;
  if (settle_on(on_curve(free), io)) return;
  io = other;
  report = at_once;
  report.branch_ends.clear();
  report.not_followed = true;
}

bool InequalityEngine::is_same(const Vector& on_the_curve, const InequalityState& now) const {
  const Vector z1 = problem.g * now.c + problem.offset;
  double apart = 0.0;
  for (int p = 0; p < n_points; ++p)
    apart = std::max(apart, std::abs(z1[points[p].first] - on_the_curve[p]));
  return apart <= same_solution * on_the_curve.lpNorm<Eigen::Infinity>();
}

} // namespace hvi::solver
