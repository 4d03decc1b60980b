// The branch that continues the last state (follow.hpp).
//
// A step is solved at once first. Where the problem is not known to be convex and a point came
// onto, across or off a piece whose slope falls (or a point changed its place while another stands
// on one), the answer may belong to another branch: the equilibrium curve from the last state says
// which answer continues it, and where branches end on the way.
#include "solver/inequality/follow.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hvi::solver {

namespace {

/// Arguments this close, by the largest, are the same solution.
constexpr double same_solution = 1e-7;

bool is_same(const Vector& z, const Vector& on_curve) {
  double apart = 0.0;
  for (Eigen::Index p = 0; p < z.size(); ++p) apart = std::max(apart, std::abs(z[p] - on_curve[p]));
  return apart <= same_solution * on_curve.lpNorm<Eigen::Infinity>();
}

} // namespace

BranchFollower::BranchFollower(const ContactPoints& points, const StiffnessPattern& pattern,
                               LastFactor& factor, ActiveSetNewton& newton,
                               ComponentSearch& components, const InequalityOptions& options)
    : points_(points), pattern_(pattern), factor_(factor), newton_(newton), components_(components),
      options_(options), curve_(points) {}

bool BranchFollower::known_convex() {
  if (revision_ != points_.laws.revision()) convex_.reset();
  revision_ = points_.laws.revision();
  return convex_ && *convex_;
}

std::optional<bool> BranchFollower::convexity() const {
  return revision_ == points_.laws.revision() ? convex_ : std::nullopt;
}

void BranchFollower::restore(std::optional<bool> convexity) {
  convex_ = convexity;
  revision_ = points_.laws.revision();
}

bool BranchFollower::convex() {
  known_convex(); // forgets what is known of other laws
  if (!convex_) convex_ = is_convex(points_, pattern_, factor_);
  return *convex_;
}

bool BranchFollower::settle_on(const CurveSolution& found, StepAnswer& step) {
  curve_.go(found, step.at);
  if (newton_.solve(step.at, options_.max_iterations, step.report) != MethodOutcome::solved)
    return false;
  return is_same(curve_.on_curve(step.at.z), found.z) && accept_answer(step, options_.tolerance);
}

void BranchFollower::follow(StepAnswer& step) {
  InequalityReport& report = step.report;
  const bool least = options_.branch == Branch::least_energy;
  if (report.converged && !least && !may_have_left(points_, step.start, step.io)) return;
  const bool one_solution = convex(), coupled = !points_.problem.coupled.empty();
  if (least)
    report.least_gap = one_solution && !coupled ? 0.0 : std::numeric_limits<double>::infinity();
  if (one_solution) return;
  const ReducedOperator& s = factor_.op();
  // The factor of S takes the place of one that the next steps would use.
  const bool can = !(least && coupled) && curve_.serves(s);
  if (!can || !factor_.make_other(pattern_.zero()) ||
      !curve_.prepare(s, options_.before_iteration)) {
    report.not_followed = !least;
    return;
  }
  Vector free(points_.unknowns);
  s.solve(step.at.balance.load(), free);
  const Vector b1 = curve_.on_curve(points_.g * free + points_.problem.offset);
  if (!least) return continue_branch(step, free, b1);
  LeastState search(curve_, components_, options_.tolerance);
  search.descend(step, b1, free);
  if (report.least_gap > proved_least_gap)
    search.along_curve(step, b1, free,
                       [&](const CurveSolution& found) { return settle_on(found, step); });
}

void BranchFollower::continue_branch(StepAnswer& step, const Vector& free, const Vector& b1) {
  InequalityReport& report = step.report;
  const FollowedBranch branch =
      curve_.curve().follow(curve_.start(step.start), curve_.on_curve(step.start.xi), b1);
  report.inner_steps = branch.steps;
  report.not_followed = !branch.arrived;
  if (!branch.arrived) return;
  report.branch_ends.insert(report.branch_ends.end(), branch.ends.begin(), branch.ends.end());
  const Vector z1 = points_.g * step.io.c + points_.problem.offset;
  if (report.converged && is_same(curve_.on_curve(z1), branch.state.z)) return;
  const InequalityReport at_once = report;
  const InequalityState other = step.io;
  if (settle_on(curve_.solution(branch.state, free), step)) return;
  step.io = other;
  report = at_once;
  report.branch_ends.clear();
  report.not_followed = true;
}

} // namespace hvi::solver
