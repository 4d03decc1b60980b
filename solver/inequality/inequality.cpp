// The reduced inequality of one step: set-up and the order of methods (inequality.hpp).
#include "solver/inequality/inequality.hpp"

#include "solver/inequality/engine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver {

InequalityEngine::InequalityEngine(const ReducedProblem& problem_, ReducedOperator& s_,
                                   InequalityOptions options_)
    : problem(problem_), op(s_), options(options_), n(s_.size()),
      n_rows(static_cast<int>(problem_.g.rows())),
      n_points(static_cast<int>(problem_.points.size())) {
  if (problem.g.cols() != n && n_rows > 0)
    throw Failure(FailureKind::bad_value, {}, "the contact matrix does not fit the operator");
  for (Vector* v : {&c, &sc, &magnitude, &force, &force_magnitude, &residual, &row_size, &dc, &cg_r,
                    &cg_z, &cg_p, &cg_mp, &cg_q, &cg_kept, &c_of_product, &s_dc, &reach})
    *v = Vector::Zero(n);
  for (Vector* v : {&z, &xi, &dz, &trial, &z_hat, &xi_hat, &z_start}) *v = Vector::Zero(n_rows);
  state.resize(n_points), component.resize(n_points), d.resize(n_points);
  far_point.resize(n_points);
  forget_far();
  refresh_laws();
  prepare_points();
  prepare_pattern();
  estimate_compliance();
  prepare_inverse();
}

/// Prepares the graphs that points use; again those of laws that move with time, and those that
/// changed place.
void InequalityEngine::refresh_laws() {
  if (prepared.empty()) {
    prepared_of.assign(problem.graphs.size(), -1);
    for (const ContactPoint& p : problem.points) {
      if (prepared_of[p.graph] >= 0) continue;
      prepared_of[p.graph] = static_cast<int>(prepared.size());
      graph_of.push_back(p.graph);
      prepared.emplace_back(*problem.laws[p.law], problem.graphs[p.graph]);
    }
    prepare_following();
    return;
  }
  bool any = false;
  for (std::size_t k = 0; k < prepared.size(); ++k) {
    const LawGraph& graph = problem.graphs[graph_of[k]];
    const Law& law = prepared[k].law();
    if (!law.depends_on_t() && &prepared[k].graph() == &graph) continue;
    prepared[k] = PreparedLaw(law, graph);
    any = true;
  }
  if (!any) return;
  known_convex.reset();
  prepare_following();
}

/// Stiffness of the body felt at a point, sum S_ii G_i^2 / (sum G_i^2)^2 averaged over its rows,
/// sets both scales: gamma = w / k, penalty = kappa k / w. Where a row touches one unknown only,
/// the penalty stands on the diagonal and cannot spoil the factor; else it costs digits.
void InequalityEngine::prepare_points() {
  diagonal = op.diagonal();
  const double typical = n > 0 ? diagonal.cwiseAbs().maxCoeff() : 1.0;
  std::vector<int> users(n, 0);
  for (int row = 0; row < n_rows; ++row)
    for (SparseMatrix::InnerIterator it(problem.g, row); it; ++it)
      users[it.col()] += it.value() != 0.0;
  points.resize(n_points);
  for (int p = 0; p < n_points; ++p) {
    const ContactPoint& in = problem.points[p];
    if (!(in.weight > 0.0) || in.rows < 1 || in.rows > 3 || in.first_row + in.rows > n_rows)
      throw Failure(FailureKind::bad_value, {},
                    "a contact point needs a positive weight and 1 to 3 rows");
    double k = 0.0;
    bool single = true, exclusive = true;
    for (int row = in.first_row; row < in.first_row + in.rows; ++row) {
      double sum = 0.0, weighted = 0.0;
      int entries = 0;
      for (SparseMatrix::InnerIterator it(problem.g, row); it; ++it) {
        sum += it.value() * it.value();
        weighted += std::abs(diagonal[it.col()]) * it.value() * it.value();
        entries += it.value() != 0.0;
        exclusive = exclusive && users[it.col()] == 1 && it.value() != 0.0;
      }
      single = single && entries <= 1;
      exclusive = exclusive && entries == 1;
      if (sum > 0.0) k += weighted / (sum * sum) / in.rows;
    }
    if (!(k > 0.0)) k = typical > 0.0 ? typical : 1.0;
    PointData& q = points[p];
    q.law = prepared_of[in.graph];
    q.first = in.first_row, q.rows = in.rows, q.weight = in.weight;
    q.gamma = q.local = in.weight / k;
    q.single = single, q.exclusive = exclusive;
    q.penalty = (single ? 1e13 : 1e7) * k / in.weight;
  }
}

/// gamma = w G S^-1 G^T: how far the body gives way at the point when nothing else is held. With
/// a smaller gamma, points that slip overshoot the range where they would stick. The diagonal of
/// S^-1 by eight probes with entries +-1 (Hutchinson, Bekas): the size is all that matters.
void InequalityEngine::estimate_compliance() {
  if (n_points == 0 || !op.factor(h, {})) return;
  Vector probe(n), answer(n), flexibility = Vector::Zero(n);
  std::uint32_t random = 12345;
  for (int k = 0; k < 8; ++k) {
    for (double& v : probe) {
      random = random * 1664525u + 1013904223u;
      v = random >> 31 ? 1.0 : -1.0;
    }
    op.solve(probe, answer);
    flexibility += probe.cwiseProduct(answer) / 8.0;
  }
  if (!flexibility.allFinite()) return;
  for (PointData& q : points) {
    double compliance = 0.0;
    for (int row = q.first; row < q.first + q.rows; ++row)
      for (SparseMatrix::InnerIterator it(problem.g, row); it; ++it)
        compliance += it.value() * it.value() * flexibility[it.col()] / q.rows;
    q.gamma = std::clamp(q.weight * compliance, q.local, 1e6 * q.local);
  }
}

/// The pattern of H = sum w_p G_p^T D_p G_p once, and where each product of two entries of G goes.
void InequalityEngine::prepare_pattern() {
  std::vector<Eigen::Triplet<double>> pattern, weights;
  const auto for_pairs = [&](int p, const auto& f) {
    const PointData& q = points[p];
    for (int a = 0; a < q.rows; ++a)
      for (int b = 0; b < q.rows; ++b)
        for (SparseMatrix::InnerIterator i(problem.g, q.first + a); i; ++i)
          for (SparseMatrix::InnerIterator j(problem.g, q.first + b); j; ++j)
            f(static_cast<int>(i.col()), static_cast<int>(j.col()), 3 * a + b,
              q.weight * i.value() * j.value());
  };
  for (int p = 0; p < n_points; ++p) {
    for_pairs(p, [&](int i, int j, int, double) { pattern.emplace_back(i, j, 0.0); });
    for (int row = points[p].first; row < points[p].first + points[p].rows; ++row)
      for (SparseMatrix::InnerIterator i(problem.g, row); i; ++i)
        weights.emplace_back(static_cast<int>(i.col()), row, points[p].weight * i.value());
  }
  h.resize(n, n);
  h.setFromTriplets(pattern.begin(), pattern.end());
  drift = h;
  force_of.resize(n, n_rows);
  force_of.setFromTriplets(weights.begin(), weights.end());
  first_contribution.assign(1, 0);
  for (int p = 0; p < n_points; ++p) {
    for_pairs(p, [&](int i, int j, int entry, double coefficient) {
      const int* begin = h.innerIndexPtr() + h.outerIndexPtr()[i];
      const int* end = h.innerIndexPtr() + h.outerIndexPtr()[i + 1];
      const auto value = static_cast<int>(std::lower_bound(begin, end, j) - h.innerIndexPtr());
      contributions.push_back({value, entry, coefficient});
    });
    first_contribution.push_back(static_cast<int>(contributions.size()));
  }
}

void InequalityEngine::load(const InequalityState& from) {
  if (from.c.size() == n)
    c = from.c;
  else
    c.setZero();
  if (from.xi.size() == n_rows)
    xi = from.xi;
  else
    xi.setZero();
  update_z();
  z_start = z;
  const bool given = static_cast<int>(from.state.size()) == n_points;
  for (int p = 0; p < n_points; ++p) {
    const PreparedLaw& law = prepared[points[p].law];
    const Small zp = at(z, p);
    if (given && law.valid_state(from.state[p])) {
      state[p] = from.state[p];
    } else {
      const double r = law.radial() ? std::hypot(zp[0], zp[1], zp[2]) : zp[0];
      state[p] = law.radial() && r == 0.0 ? -1 : 2 * piece_of(law.graph(), r);
    }
    component[p] = law.component_of_piece(std::max(state[p], 0) / 2);
    enter_state(p);
  }
  if (from.c_guess.size() == n && from.xi_guess.size() == n_rows) move_to_guess(from);
}

/// Goes to the guess; what each point does there its resolvent says, on the component it has.
void InequalityEngine::move_to_guess(const InequalityState& from) {
  c = from.c_guess, xi = from.xi_guess;
  if (from.s_c_guess.size() == n) sc = from.s_c_guess, c_of_product = c, have_magnitude = false;
  update_z();
  for (int p = 0; p < n_points; ++p) classify(p, 1.0);
}

void InequalityEngine::store(InequalityState& to) const { to.c = c, to.xi = xi, to.state = state; }

/// What went wrong, as a sentence, and what can be done about it.
std::string InequalityEngine::verdict(Outcome outcome) const {
  const std::string numbers =
      fmt::format("after {} iterations: residual {:.1e}, inclusion {:.1e} (tolerance {:.1e})",
                  report.iterations, report.residual, report.inclusion, options.tolerance);
  if (outcome == Outcome::indefinite)
    return "the step has no stable solution near the last one: its operator is not positive "
           "definite " +
           numbers + "; take smaller steps, or `branch = release`";
  if (outcome == Outcome::solved)
    return "the problem is too ill-conditioned for this tolerance " + numbers +
           "; look for stiffnesses or sizes many decades apart";
  return "the iterations do not settle, with the globally convergent method too, " + numbers +
         "; take smaller steps";
}

InequalityReport InequalityEngine::solve(const Vector& right_side, InequalityState& io) {
  report = {};
  rhs = &right_side;
  if (right_side.size() != n || !right_side.allFinite()) {
    report.verdict = "the right-hand side of the step is not finite: check loads and step size";
    return report;
  }
  refresh_laws();
  const bool follows =
      may_soften && io.z_before.size() == n_rows && options.branch != Branch::release;
  follows ? solve_and_follow(io) : solve_at_once(io);
  if (!may_soften && options.branch == Branch::least_energy && report.converged)
    report.least_gap = 0.0; // a convex problem has no other state
  io.z_before.resize(0), io.xi_before.resize(0);
  return report;
}

/// Newton's method first, then the curve from the last state. Where the step is not convex the
/// globally convergent method takes thousands of iterations to some state, often of another
/// branch: only where the curve leads nowhere.
void InequalityEngine::solve_and_follow(InequalityState& io) {
  note_start(io);
  newton_only = !(known_convex && *known_convex) && !options.force_fallback;
  if (newton_only) followed_from = io;
  solve_at_once(io);
  follow(io);
  if (newton_only && !report.converged) {
    const bool lost = report.not_followed;
    newton_only = false;
    io = followed_from;
    solve_at_once(io);
    if (options.branch == Branch::least_energy && report.converged)
      follow(io);
    else
      report.not_followed = report.not_followed || lost;
  }
  newton_only = false;
}

/// Without a look at other branches.
void InequalityEngine::solve_at_once(InequalityState& io) {
  if (solve_with_inverse(io)) return;
  load(io);
  idle = true;
  for (int p = 0; p < n_points; ++p)
    idle = idle && d[p] == std::array<double, 9>{} && at(xi_hat, p) == Small{};
  Outcome outcome = solve_branch();
  certify();
  if (!report.converged && io.c_guess.size() > 0) { // the guess may have led astray
    io.c_guess.resize(0), io.xi_guess.resize(0), io.s_c_guess.resize(0);
    load(io);
    outcome = solve_branch();
    certify();
  }
  if (idle && report.iterations == 1 && xi.isZero(0.0)) report.iterations = 0;
  store(io);
  if (!report.converged) report.verdict = verdict(outcome);
}

struct InequalitySolver::Impl : InequalityEngine {
  using InequalityEngine::InequalityEngine;
};

InequalitySolver::InequalitySolver(const ReducedProblem& problem, ReducedOperator& s,
                                   InequalityOptions options)
    : impl_(std::make_unique<Impl>(problem, s, options)) {}
InequalitySolver::~InequalitySolver() = default;

InequalityReport InequalitySolver::solve(const Vector& r, InequalityState& state) {
  return impl_->solve(r, state);
}

InequalityReport InequalitySolver::solve_coupled(const Vector& r, InequalityState& state) {
  return impl_->solve_coupled(r, state);
}

bool InequalitySolver::convex() { return impl_->convex(); }
bool InequalitySolver::respond(const InequalityState& at_state, std::span<const Vector> r,
                               std::vector<Vector>& change_c, std::vector<Vector>& change_xi) {
  return impl_->respond(at_state, r, change_c, change_xi);
}
void InequalitySolver::save(std::ostream& out) const { impl_->save(out); }
void InequalitySolver::restore(std::istream& in) { impl_->restore(in); }

} // namespace hvi::solver
