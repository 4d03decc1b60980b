// The order of methods for coupled laws (engine.hpp).
#include "solver/inequality/certificate.hpp"
#include "solver/inequality/coupled_path.hpp"
#include "solver/inequality/engine.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::solver {

namespace {
constexpr int most_coupled = 60;
} // namespace

InequalityReport InequalityEngine::solve_coupled(const Vector& r, InequalityState& io) {
  InequalityReport report;
  if (r.size() != points_.unknowns || !r.allFinite()) return report;
  search_coupled(r, io, report);
  factor_.forget(); // that of other penalties
  return report;
}

/// Newton's method from the last state; where it fails from laws without bounds, which are raised
/// then.
void InequalityEngine::search_coupled(const Vector& r, InequalityState& io,
                                      InequalityReport& report) {
  at_.balance.set_load(r);
  points_.laws.refresh();
  const bool may_leave = points_.laws.may_soften() && io.z_before.size() == points_.rows;
  if (may_leave) note_start(points_, io, start_);
  at_.load(io);
  at_.z_start = at_.z;
  std::vector<int> components = at_.places.component;
  CoupledBounds bounds(points_, at_);
  CoupledTangent tangent(at_, bounds, factor_.op());
  CoupledNewton newton(at_, bounds, tangent, options_.tolerance, report);
  const CoupledPlace start = newton.here();
  if (!newton.solve(most_coupled)) {
    newton.go(start);
    bounds.set_share(0.0);
    for (CoupledBound& b : bounds.all) bounds.set(b, 0.0);
    at_.enter_states();
    components = at_.places.component; // laws without bounds may have fewer
    if (components_.solve(at_, Methods::all, report) == MethodOutcome::solved &&
        !newton.raise_share())
      SharePath(at_, bounds, tangent, newton, report).follow();
  }
  certify_found(report);
  report.converged = report.converged && bounds.share() == 1.0;
  if (!report.converged) try_without_rounding(bounds, report);
  count_events(at_, components, report);
  at_.store(io);
  report.not_followed = may_leave && may_have_left(points_, start_, io);
  io.z_before.resize(0), io.xi_before.resize(0);
  if (!report.converged)
    report.verdict =
        fmt::format("the laws and the bounds that they give each other were not "
                    "solved together, neither by Newton's "
                    "method nor by raising the bounds from 0 (their last share: {:.3g}): "
                    "a solution may not exist, "
                    "or not near the last one; take smaller steps",
                    bounds.share());
}

/// Where bodies only just touch, what they press is rounding of the forces elsewhere, which nothing
/// can balance. Asks for the certificate without it.
void InequalityEngine::try_without_rounding(CoupledBounds& bounds, InequalityReport& report) {
  const Vector c = at_.c, xi = at_.xi;
  const double share = bounds.share();
  at_.balance.product.update(at_.c);
  const Vector& size = at_.balance.errors(at_.c, at_.xi).size;
  const auto& of_unknown = points_.problem.of_unknown;
  ByUnknown most{};
  for (Eigen::Index i = 0; i < size.size(); ++i) {
    double& of = most[of_unknown.empty() ? 0 : of_unknown[static_cast<std::size_t>(i)]];
    of = std::max(of, rounding_of_tolerance * options_.tolerance * size[i]);
  }
  if (!drop_rounding(points_.problem, most, at_.xi)) return;
  bounds.set_share(1.0);
  for (CoupledBound& b : bounds.all) bounds.set(b, at_.xi[points_[b.normal].first]);
  InequalityReport without = report;
  certify_found(without);
  if (without.converged) {
    report = without;
    return;
  }
  at_.c = c, at_.xi = xi;
  bounds.set_share(share);
  at_.update_arguments();
}

} // namespace hvi::solver
