// The order of methods (engine.hpp).
#include "solver/inequality/engine.hpp"

#include "solver/inequality/coupled_search.hpp"
#include "solver/inequality/tangent.hpp"

#include <fmt/format.h>

namespace hvi::solver {

namespace {

/// What went wrong, as a sentence, and what can be done about it.
std::string verdict(MethodOutcome outcome, const InequalityReport& report, double tolerance) {
  const std::string numbers =
      fmt::format("after {} iterations: residual {:.1e}, inclusion {:.1e} (tolerance {:.1e})",
                  report.iterations, report.residual, report.inclusion, tolerance);
  if (outcome == MethodOutcome::indefinite)
    return "the step has no stable solution near the last one: its operator is not positive "
           "definite " +
           numbers + "; `branch = release` releases points at once";
  if (outcome == MethodOutcome::solved)
    return "the problem is too ill-conditioned for this tolerance " + numbers +
           "; look for stiffnesses or sizes many decades apart";
  return "the iterations do not settle, with the globally convergent method too, " + numbers;
}

/// Does no law act, neither with a force nor with a stiffness?
bool is_idle(const Position& at) {
  return std::ranges::all_of(at.places.d, [](double v) { return v == 0.0; }) &&
         at.places.xi_hat.isZero(0.0);
}

} // namespace

InequalityReport InequalityEngine::solve(const Vector& r, InequalityState& io) {
  InequalityReport report;
  if (r.size() != parts_.points.unknowns || !r.allFinite()) {
    report.verdict = "the right-hand side of the step is not finite: check loads and step size";
    return report;
  }
  parts_.at.balance.set_load(r);
  parts_.points.laws.refresh();
  const bool may_soften = parts_.points.laws.may_soften();
  if (may_soften && io.z_before.size() == parts_.points.rows &&
      parts_.options.branch != Branch::release)
    solve_and_follow(io, report);
  else
    solve_at_once(Methods::all, io, report);
  if (!may_soften && parts_.options.branch == Branch::least_energy && report.converged)
    report.least_gap = 0.0; // a convex problem has one solution
  io.z_before.resize(0), io.xi_before.resize(0);
  return report;
}

InequalityReport InequalityEngine::solve_coupled(const Vector& r, InequalityState& io) {
  InequalityReport report;
  if (r.size() == parts_.points.unknowns && r.allFinite())
    solver::solve_coupled(parts_, r, start_, io, report);
  return report;
}

/// Newton's method first, then the curve from the last state. The globally convergent method comes
/// last, only where the curve finds no solution: where a step is not convex it takes thousands of
/// iterations and often ends on another branch.
void InequalityEngine::solve_and_follow(InequalityState& io, InequalityReport& report) {
  note_start(parts_.points, io, start_);
  const bool newton_only = !parts_.follower.known_convex() && !parts_.options.force_fallback;
  if (newton_only) before_ = io;
  StepAnswer step{parts_.at, start_, newton_only ? Methods::newton : Methods::all, io, report};
  solve_at_once(step.methods, io, report);
  parts_.follower.follow(step);
  if (!newton_only || report.converged) return;
  const bool lost = report.not_followed;
  step.methods = Methods::all;
  io = before_;
  solve_at_once(step.methods, io, report);
  if (parts_.options.branch == Branch::least_energy && report.converged)
    parts_.follower.follow(step);
  else
    report.not_followed = report.not_followed || lost;
}

/// Without a look at other branches.
void InequalityEngine::solve_at_once(Methods methods, InequalityState& io,
                                     InequalityReport& report) {
  if (parts_.inverse.solve(parts_.at, io, report)) return;
  parts_.at.load(io);
  parts_.at.idle = is_idle(parts_.at);
  MethodOutcome outcome = parts_.components.solve_branch(parts_.at, methods, report);
  certify_found(parts_, report);
  if (!report.converged && io.c_guess.size() > 0) { // the guess may have been a bad start
    io.c_guess.resize(0), io.xi_guess.resize(0), io.s_c_guess.resize(0);
    parts_.at.load(io);
    outcome = parts_.components.solve_branch(parts_.at, methods, report);
    certify_found(parts_, report);
  }
  if (!report.converged && outcome != MethodOutcome::indefinite && report.used_fallback)
    certify_found(parts_, report, parts_.options.tolerance);
  if (parts_.at.idle && report.iterations == 1 && parts_.at.xi.isZero(0.0)) report.iterations = 0;
  parts_.at.store(io);
  if (!report.converged) report.verdict = verdict(outcome, report, parts_.options.tolerance);
}

bool InequalityEngine::respond(const InequalityState& at_state, std::span<const Vector> r,
                               std::vector<Vector>& change_c, std::vector<Vector>& change_xi) {
  parts_.points.laws.refresh();
  return solver::respond(at_state, r, parts_.at, parts_.pattern, parts_.factor, change_c,
                         change_xi);
}

} // namespace hvi::solver
