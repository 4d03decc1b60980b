// Mesh, parts and space of a plan, with every mistake of theirs found at once. First stage of the
// engine: plan -> Discretisation -> run (run.cpp), hypotheses, study.
#include "solver/time/discretise.hpp"

#include "solver/assembly/pairing.hpp"
#include "solver/common/clock.hpp"
#include "solver/common/memory_room.hpp"
#include "solver/discrete/axis_parts.hpp"
#include "solver/discrete/domains.hpp"
#include "solver/discrete/overlaps.hpp"
#include "solver/discrete/probe_places.hpp"
#include "solver/mesh/boundary_distance.hpp"
#include "solver/plan/couplings.hpp"
#include "solver/plan/validate.hpp"
#include "solver/results/law_sampler.hpp"
#include "solver/results/line_values.hpp"
#include "solver/results/reaction_forces.hpp"
#include "solver/step/start_motion.hpp"
#include "solver/time/adapt.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace hvi::solver {
namespace {

/// Runs `work`; a Failure it throws is collected. True when it went through.
template <class Work>
bool collect(std::vector<Failure>& failures, Work&& work) {
  try {
    work();
    return true;
  } catch (const Failure& failure) {
    failures.push_back(failure);
    return false;
  }
}

/// The failure with the origin of the plan item when it has none of its own.
Failure with_origin(const Failure& failure, Origin origin) {
  if (failure.origin.id >= 0) return failure;
  return Failure(failure.kind, origin, failure.what(), failure.help);
}

bool resolve_parts(const Problem& problem, Discretisation& out, std::vector<Failure>& failures) {
  const auto before = failures.size();
  out.parts.clear();
  for (const auto& part : problem.parts) {
    out.parts.emplace_back();
    try {
      out.parts.back() = resolve(out.mesh, part.region);
    } catch (const Failure& failure) {
      failures.push_back(with_origin(failure, part.origin));
    }
  }
  return failures.size() == before;
}

/// Throws Failure(too_large) where a mesh of so many nodes, the space on it and two matrices with
/// the pattern of its cells (a form and their sum) do not fit. A node of P1 has 3, 7 and 15
/// neighbours in a regular mesh, itself among them; of P2, which has 2, 4 and 8 times as many,
/// 4, 11.5 and 28.
void require_space(const Problem& problem, int dim, double nodes, double bytes_of_mesh) {
  static constexpr double neighbours[2][3] = {{3, 7, 15}, {4, 11.5, 28}};
  const auto unknowns = unknowns_of(problem.space);
  const bool quadratic =
      std::ranges::any_of(unknowns, [](const UnknownSpec& u) { return u.order == 2; });
  const int components = components_of(problem.space, dim);
  const double space_nodes = nodes * (quadratic ? std::exp2(dim) : 1.0);
  const double entries = space_nodes * neighbours[quadratic ? 1 : 0][dim - 1];
  const double matrix = entries * components * components * (sizeof(double) + sizeof(int));
  require_memory(
      bytes_of_mesh + entries * sizeof(int) + 2.0 * matrix,
      fmt::format("the mesh and the matrices of some {:.2g} unknowns", space_nodes * components));
}

/// Before the first cell is made.
void require_structured(const Problem& problem, const MeshSpec& spec) {
  for (const MeshSpec& piece : spec.pieces) require_structured(problem, piece);
  const int dim = spec.kind == MeshSpec::Kind::interval    ? 1
                  : spec.kind == MeshSpec::Kind::rectangle ? 2
                  : spec.kind == MeshSpec::Kind::box       ? 3
                                                           : 0;
  if (dim == 0) return;
  double boxes = 1.0;
  for (int a = 0; a < dim; ++a)
    boxes *= spec.grading[a].empty() ? spec.cells[a] : static_cast<double>(spec.grading[a].size());
  const double cells = boxes * (dim == 3 ? 6 : dim == 2 ? (spec.crossed ? 4 : 2) : 1);
  const double bytes = cells * (4 * sizeof(std::int32_t)) + boxes * sizeof(Point);
  require_space(problem, dim, boxes * (spec.crossed ? 2 : 1), bytes);
}

/// Matches the sides of every pair.
void check_pairs(const Problem& problem, Discretisation& out, std::vector<Failure>& failures) {
  out.alone.clear();
  for (std::size_t i = 0; i < out.parts.size(); ++i) {
    if (!out.parts[i].is_pair()) continue;
    try {
      const Pairing pairing = make_pairing(out.space, out.parts[i], out.space.order);
      if (pairing.alone > 0)
        out.alone.push_back({static_cast<int>(i), pairing.alone, pairing.first_alone});
    } catch (const Failure& failure) {
      failures.push_back(with_origin(failure, problem.parts[i].origin));
    }
  }
}

void check_grid(const Problem& problem, std::vector<Failure>& failures) {
  const auto& time = problem.time;
  const auto bad = [&](const std::string& message, Origin origin) {
    failures.emplace_back(FailureKind::bad_value, origin, message);
  };
  if (time.is_static) {
    for (const auto& form : problem.forms)
      if (form.field != field_of_u(0))
        bad("a static problem has neither a rate nor memory", form.origin);
    return;
  }
  if (time.grid.size() < 2) bad("the time grid needs at least one step", time.origin);
  for (std::size_t n = 0; n < time.grid.size(); ++n) {
    const bool increases = n == 0 || time.grid[n] > time.grid[n - 1];
    if (std::isfinite(time.grid[n]) && increases) continue;
    bad(fmt::format("time {} of the grid ({}) does not increase", n, time.grid[n]), time.origin);
    return;
  }
}

/// What the run starts from must repeat on periodic parts (to rounding and to what nodes meet by).
void check_repeats(const Problem& problem, const Discretisation& d, const Vector& given,
                   const char* what, Origin origin) {
  const double scale = given.lpNorm<Eigen::Infinity>();
  for (const DofLink& link : d.dofs.links) {
    if (std::abs(given[link.dof] - given[link.to]) <= 1e-6 * scale) continue;
    throw Failure(FailureKind::bad_value, origin,
                  fmt::format("{} does not repeat as `{}` does: it is {:.6g} for {} and {:.6g} "
                              "for {}",
                              what, problem.space.name, given[link.to],
                              describe_dof(d.space, link.to), given[link.dof],
                              describe_dof(d.space, link.dof)),
                  "start from values that are the same on both of the periodic parts");
  }
}

/// u(t0) on eliminated dofs must be what the imposed values say there (to rounding).
void check_initial(const Problem& problem, const Discretisation& d) {
  if (problem.time.is_static || problem.time.grid.empty()) return;
  const double t0 = problem.time.grid.front();
  Vector u = Vector::Zero(d.space.n_dofs());
  if (!problem.time.initial.empty())
    u = interpolate(d.space, problem.time.initial, t0, problem.time.origin);
  check_repeats(problem, d, u, "the initial state", problem.time.origin);
  Vector imposed = u;
  impose(d.space, problem.space, d.dofs, t0, imposed);
  const double scale = std::max(u.lpNorm<Eigen::Infinity>(), imposed.lpNorm<Eigen::Infinity>());
  for (const auto& e : d.dofs.eliminated) {
    if (std::abs(imposed[e.dof] - u[e.dof]) <= 1e-9 * scale) continue;
    const Origin origin =
        e.dirichlet < 0 ? problem.time.origin
                        : problem.space.dirichlet[static_cast<std::size_t>(e.dirichlet)].origin;
    throw Failure(FailureKind::bad_value, origin,
                  fmt::format("the value imposed at t = {} is {:.6g}, the initial state is {:.6g} "
                              "({})",
                              t0, imposed[e.dof], u[e.dof], describe_dof(d.space, e.dof)),
                  "start from a state that has the imposed values");
  }
}

/// A given u'(t0) must be the rate of imposed values on eliminated dofs. Of several unknowns it is
/// asked of those with a form in their second derivative: others begin with their values alone.
void check_velocity(const Problem& problem, const Discretisation& d) {
  const auto& time = problem.time;
  if (time.is_static || time.grid.empty() || !time.velocity) return;
  const Vector given =
      interpolate(d.space, *time.velocity, time.grid.front(), time.velocity_origin);
  check_repeats(problem, d, given, "the initial velocity", time.velocity_origin);
  const Vector imposed = starting_velocity(problem, d);
  const double scale = std::max(given.lpNorm<Eigen::Infinity>(), imposed.lpNorm<Eigen::Infinity>());
  const std::vector<int> orders = orders_in_time(problem);
  for (const auto& e : d.dofs.eliminated) {
    const int unknown = d.space.block_of(e.dof % d.space.components);
    if (orders[static_cast<std::size_t>(unknown)] < highest_derivative) continue;
    if (std::abs(imposed[e.dof] - given[e.dof]) <= 1e-9 * scale) continue;
    throw Failure(FailureKind::bad_value, time.velocity_origin,
                  fmt::format("the imposed value has the rate {:.6g} at t = {}, the initial "
                              "velocity is {:.6g} ({})",
                              imposed[e.dof], time.grid.front(), given[e.dof],
                              describe_dof(d.space, e.dof)),
                  "start with a velocity that imposed values have, or leave it out where the "
                  "body is at rest");
  }
}

void check_probe_points(const ReportSpec& report, const Discretisation& d,
                        std::vector<Failure>& failures) {
  const CellLocator locator(d.mesh, report.probes.size());
  std::array<double, 4> barycentric{};
  for (const auto& probe : report.probes) {
    if (probe.kind != Probe::Kind::at_point || locator.find(probe.point, barycentric) >= 0)
      continue;
    const NearestOnBoundary near = nearest_on_boundary(d.mesh, probe.point);
    const bool almost = near.distance < 0.02 * bounding_box(d.mesh).diagonal();
    failures.emplace_back(
        FailureKind::bad_value, probe.origin,
        fmt::format("the point {} of `{}` is outside the mesh",
                    describe_point(probe.point, d.mesh.dim), probe.name),
        fmt::format("the nearest point of the mesh is {:.3g} away, about {}{}", near.distance,
                    describe_point(near.at, d.mesh.dim),
                    almost ? "; sides of cells are straight, also those of round bodies" : ""));
  }
}

void check_times(const Plan& plan, std::vector<Failure>& failures) {
  const auto& grid = plan.problem.time.grid;
  const auto check = [&](const std::optional<double>& time, Origin origin,
                         const std::string& name) {
    if (!time) return;
    if (!plan.problem.time.is_static && grid.size() > 1 && *time >= grid.front() &&
        *time <= grid.back())
      return;
    failures.emplace_back(
        FailureKind::bad_value, origin,
        plan.problem.time.is_static
            ? fmt::format("`{}` asks for a time of a static problem", name)
            : fmt::format("the time {} of `{}` is outside the time interval", *time, name));
  };
  for (const auto& probe : plan.report.probes) check(probe.time, probe.origin, probe.name);
  for (const auto& picture : plan.report.pictures)
    check(picture.time, picture.origin, picture.field.name);
  for (const auto& line : plan.report.lines) check(line.time, line.origin, "line");
}

} // namespace

std::vector<Failure> discretise(const Plan& plan, Discretisation& out,
                                const std::atomic<bool>* stop) {
  const double start = cpu_seconds();
  Mesh mesh;
  require_structured(plan.problem, plan.problem.mesh);
  try {
    mesh = plan.problem.mesh.adapted > 0 ? adapted_mesh(plan, stop) : make_mesh(plan.problem.mesh);
  } catch (const Failure& failure) {
    if (failure.kind == FailureKind::interrupted) throw;
    std::vector<Failure> failures;
    check_grid(plan.problem, failures);
    check_times(plan, failures);
    failures.push_back(with_origin(failure, plan.problem.mesh.origin));
    return failures;
  }
  auto failures = discretise_on(plan, std::move(mesh), out);
  out.seconds = cpu_seconds() - start;
  return failures;
}

std::vector<Failure> discretise_on(const Plan& plan, Mesh mesh, Discretisation& out) {
  auto failures = validate(plan, mesh.dim);
  if (!failures.empty()) return failures;
  check_grid(plan.problem, failures);
  check_times(plan, failures);
  out.mesh = std::move(mesh);
  require_space(plan.problem, out.mesh.dim, static_cast<double>(out.mesh.nodes.size()), 0.0);
  check_probe_points(plan.report, out, failures);
  std::ranges::move(lines_outside(plan.report, out.mesh), std::back_inserter(failures));
  if (!resolve_parts(plan.problem, out, failures)) return failures;
  for (auto& failure : overlaps(plan.problem, out.mesh, out.parts))
    failures.push_back(std::move(failure));
  for (auto& failure : integrals_on_axis(plan, out.mesh, out.parts))
    failures.push_back(std::move(failure));
  const bool spaced = collect(failures, [&] {
    out.space = make_space(out.mesh, plan.problem.space, out.parts);
    out.dofs = make_dof_map(out.space, plan.problem.space, out.parts);
    if (out.dofs.n_unknowns() == 0)
      throw Failure(FailureKind::bad_value, plan.problem.space.origin,
                    "every degree of freedom is imposed: nothing is left to solve for");
  });
  if (spaced) check_pairs(plan.problem, out, failures);
  if (spaced && !plan.start) collect(failures, [&] { check_initial(plan.problem, out); });
  if (spaced) collect(failures, [&] { check_velocity(plan.problem, out); });
  if (!failures.empty()) return failures;
  failures = outside_domains(plan, out);
  std::ranges::move(outside_parts(plan, out), std::back_inserter(failures));
  if (!failures.empty()) return failures;
  failures = reactions_of_nothing(plan, out);
  std::ranges::move(misplaced_multipliers(plan, out), std::back_inserter(failures));
  return failures; // a law in a wrong place has no second mistake
}

} // namespace hvi::solver
