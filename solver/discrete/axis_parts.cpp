// See axis_parts.hpp.
#include "solver/discrete/axis_parts.hpp"

#include "solver/fem/region.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::solver {
namespace {

bool lies_on_axis(const Mesh& mesh, const Region& region) {
  return region.kind == Group::Kind::facets && !region.entities.empty() &&
         std::ranges::all_of(region.entities, [&](std::int32_t e) {
           const auto& nodes = mesh.facets[static_cast<std::size_t>(e)].nodes;
           return mesh.nodes[static_cast<std::size_t>(nodes[0])][0] == 0.0 &&
                  mesh.nodes[static_cast<std::size_t>(nodes[1])][0] == 0.0;
         });
}

} // namespace

std::vector<Failure> integrals_on_axis(const Plan& plan, const Mesh& mesh,
                                       std::span<const Region> parts) {
  std::vector<Failure> out;
  if (!mesh.axisymmetric) return out;
  const Problem& problem = plan.problem;
  const auto look = [&](int part, Origin origin) {
    if (part < 0 || !lies_on_axis(mesh, parts[static_cast<std::size_t>(part)])) return;
    out.emplace_back(
        FailureKind::empty_region, origin,
        fmt::format("`{}` lies on the axis: it has no area, and integrals over it are zero",
                    problem.parts[static_cast<std::size_t>(part)].name),
        "the axis is inside the body of revolution; `u.x = 0` holds there by itself");
  };
  for (const auto& form : problem.forms) look(form.part, form.origin);
  for (const auto& law : problem.law_terms) look(law.part, law.origin);
  for (const LoadTerm* const load : all_loads(problem)) look(load->part, load->origin);
  for (const auto& state : problem.states) look(state.part, state.origin);
  for (const auto& probe : plan.report.probes)
    if (probe.kind == Probe::Kind::integral) look(probe.part, probe.origin);
  return out;
}

} // namespace hvi::solver
