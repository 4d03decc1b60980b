// The order of methods for coupled laws (coupled_search.hpp).
#include "solver/inequality/coupled_search.hpp"

#include "solver/inequality/certificate.hpp"
#include "solver/inequality/coupled_path.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::solver {

namespace {

constexpr int most_coupled = 60;

std::string verdict_of_share(double last_share) {
  return fmt::format("the laws and the bounds that they give each other were not solved together, "
                     "neither by Newton's method nor by raising the bounds from 0 (their last "
                     "share: {:.3g}): a solution may not exist, or not near the last one; take "
                     "smaller steps",
                     last_share);
}

/// Where bodies only just touch, what they press is rounding of the forces elsewhere, which nothing
/// can balance. Asks for the certificate without it.
void try_without_rounding(EngineParts& parts, CoupledBounds& bounds, InequalityReport& report) {
  Position& at = parts.at;
  const Vector c = at.c, xi = at.xi;
  const double share = bounds.share();
  at.balance.product.update(at.c);
  const Vector& size = at.balance.errors(at.c, at.xi).size;
  const auto& of_unknown = parts.points.problem.of_unknown;
  ByUnknown most{};
  for (Eigen::Index i = 0; i < size.size(); ++i) {
    double& of = most[of_unknown.empty() ? 0 : of_unknown[static_cast<std::size_t>(i)]];
    of = std::max(of, rounding_of_tolerance * parts.options.tolerance * size[i]);
  }
  if (!drop_rounding(parts.points.problem, most, at.xi)) return;
  bounds.set_share(1.0);
  for (CoupledBound& b : bounds.all) bounds.set(b, at.xi[parts.points[b.normal].first]);
  InequalityReport without = report;
  certify_found(parts, without);
  if (without.converged) {
    report = without;
    return;
  }
  at.c = c, at.xi = xi;
  bounds.set_share(share);
  at.update_arguments();
}

} // namespace

void solve_coupled(EngineParts& parts, const Vector& r, StepStart& start, InequalityState& io,
                   InequalityReport& report) {
  Position& at = parts.at;
  at.balance.set_load(r);
  parts.points.laws.refresh();
  const bool may_leave = parts.points.laws.may_soften() && io.z_before.size() == parts.points.rows;
  if (may_leave) note_start(parts.points, io, start);
  at.load(io);
  at.z_start = at.z;
  std::vector<int> components = at.places.component;
  CoupledBounds bounds(parts.points, at);
  CoupledTangent tangent(at, bounds, parts.pattern, parts.factor.op());
  CoupledNewton newton(at, bounds, tangent, parts.options.tolerance, report);
  const CoupledPlace last = newton.here();
  if (!newton.solve(most_coupled)) {
    newton.go(last);
    bounds.set_share(0.0);
    for (CoupledBound& b : bounds.all) bounds.set(b, 0.0);
    at.enter_states();
    components = at.places.component; // laws without bounds may have fewer
    if (parts.components.solve(at, Methods::all, report) == MethodOutcome::solved &&
        !newton.raise_share())
      SharePath(at, bounds, tangent, newton, report).follow();
  }
  certify_found(parts, report);
  report.converged = report.converged && bounds.share() == 1.0;
  if (!report.converged) try_without_rounding(parts, bounds, report);
  count_events(at, components, report);
  at.store(io);
  report.not_followed = may_leave && may_have_left(parts.points, start, io);
  io.z_before.resize(0), io.xi_before.resize(0);
  if (!report.converged) report.verdict = verdict_of_share(bounds.share());
  parts.factor.forget(); // that of other penalties
}

} // namespace hvi::solver
