// The order of methods (engine.hpp).
#include "solver/inequality/engine.hpp"

#include "solver/inequality/certificate.hpp"
#include "solver/inequality/tangent.hpp"

#include <fmt/format.h>

namespace hvi::solver {

InequalityEngine::InequalityEngine(const ReducedProblem& problem, ReducedOperator& s,
                                   InequalityOptions options, std::span<const double> factors)
    : options_(options), points_(problem, s, factors), pattern_(points_),
      at_(points_, s, s.aim() * options.tolerance), factor_(points_, pattern_, s),
      tangent_(points_, pattern_, factor_), krylov_(pattern_, factor_),
      newton_(s.iterative() ? static_cast<TangentSolver&>(krylov_) : tangent_, options.tolerance),
      components_(factor_, newton_, options_), inverse_(points_, pattern_, s, options_),
      follower_(points_, pattern_, factor_, newton_, components_, options_) {
  points_.estimate_compliance(s, pattern_.zero());
}

namespace {

/// What went wrong, as a sentence, and what can be done about it.
std::string verdict(MethodOutcome outcome, const InequalityReport& report, double tolerance) {
  const std::string numbers =
      fmt::format("after {} iterations: residual {:.1e}, inclusion {:.1e} (tolerance {:.1e})",
                  report.iterations, report.residual, report.inclusion, tolerance);
  if (outcome == MethodOutcome::indefinite)
    return "the step has no stable solution near the last one: its operator is not positive "
           "definite " +
           numbers + "; take smaller steps, or `branch = release`";
  if (outcome == MethodOutcome::solved)
    return "the problem is too ill-conditioned for this tolerance " + numbers +
           "; look for stiffnesses or sizes many decades apart";
  return "the iterations do not settle, with the globally convergent method too, " + numbers +
         "; take smaller steps";
}

/// Does no law act, neither with a force nor with a stiffness?
bool is_idle(const Position& at) {
  for (int p = 0; p < at.points.size(); ++p)
    if (at.places.d[p] != SmallMatrix{} || at.points[p].of(at.places.xi_hat) != Small{})
      return false;
  return true;
}

} // namespace

InequalityReport InequalityEngine::solve(const Vector& r, InequalityState& io) {
  InequalityReport report;
  if (r.size() != points_.unknowns || !r.allFinite()) {
    report.verdict = "the right-hand side of the step is not finite: check loads and step size";
    return report;
  }
  at_.balance.set_load(r);
  points_.laws.refresh();
  const bool may_soften = points_.laws.may_soften();
  if (may_soften && io.z_before.size() == points_.rows && options_.branch != Branch::release)
    solve_and_follow(io, report);
  else
    solve_at_once(Methods::all, io, report);
  if (!may_soften && options_.branch == Branch::least_energy && report.converged)
    report.least_gap = 0.0; // a convex problem has one solution
  io.z_before.resize(0), io.xi_before.resize(0);
  return report;
}

/// Newton's method first, then the curve from the last state. The globally convergent method comes
/// last, only where the curve finds no solution: where a step is not convex it takes thousands of
/// iterations and often ends on another branch.
void InequalityEngine::solve_and_follow(InequalityState& io, InequalityReport& report) {
  note_start(points_, io, start_);
  const bool newton_only = !follower_.known_convex() && !options_.force_fallback;
  if (newton_only) before_ = io;
  StepAnswer step{at_, start_, newton_only ? Methods::newton : Methods::all, io, report};
  solve_at_once(step.methods, io, report);
  follower_.follow(step);
  if (!newton_only || report.converged) return;
  const bool lost = report.not_followed;
  step.methods = Methods::all;
  io = before_;
  solve_at_once(step.methods, io, report);
  if (options_.branch == Branch::least_energy && report.converged)
    follower_.follow(step);
  else
    report.not_followed = report.not_followed || lost;
}

/// The certificate of what was found, with what nothing acts on at rest.
void InequalityEngine::certify_found(InequalityReport& report, double snap) {
  at_.balance.leave_at_rest(at_.xi, at_.c);
  certify(at_, options_.tolerance, report, snap);
}

/// Without a look at other branches.
void InequalityEngine::solve_at_once(Methods methods, InequalityState& io,
                                     InequalityReport& report) {
  if (inverse_.solve(at_, io, report)) return;
  at_.load(io);
  at_.idle = is_idle(at_);
  MethodOutcome outcome = components_.solve_branch(at_, methods, report);
  certify_found(report);
  if (!report.converged && io.c_guess.size() > 0) { // the guess may have been a bad start
    io.c_guess.resize(0), io.xi_guess.resize(0), io.s_c_guess.resize(0);
    at_.load(io);
    outcome = components_.solve_branch(at_, methods, report);
    certify_found(report);
  }
  if (!report.converged && outcome != MethodOutcome::indefinite && report.used_fallback)
    certify_found(report, options_.tolerance);
  if (at_.idle && report.iterations == 1 && at_.xi.isZero(0.0)) report.iterations = 0;
  at_.store(io);
  if (!report.converged) report.verdict = verdict(outcome, report, options_.tolerance);
}

bool InequalityEngine::respond(const InequalityState& at_state, std::span<const Vector> r,
                               std::vector<Vector>& change_c, std::vector<Vector>& change_xi) {
  points_.laws.refresh();
  return solver::respond(at_state, r, at_, pattern_, factor_, change_c, change_xi);
}

} // namespace hvi::solver
