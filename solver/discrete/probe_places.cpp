// See probe_places.hpp. Called by discretise, and by the session for its warnings.
#include "solver/discrete/probe_places.hpp"

#include "solver/discrete/domains.hpp"
#include "solver/discrete/fields_read.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace hvi::solver {
namespace {

/// Coordinates of a point in a cell that differ by no more are the same.
constexpr double same_place = 1e-9;

using Barycentric = std::array<double, 4>;

bool holds(const Mesh& mesh, const Barycentric& at) {
  return *std::min_element(at.begin(), at.begin() + mesh.dim + 1) > -same_place;
}

/// The unknowns of the nodes that the values at a point of a cell are made of; a node whose values
/// are all imposed stands for itself. Conforming cells have the same ones, and so have those that
/// periodic parts join.
std::vector<std::int32_t> made_of(const Discretisation& d, int cell, const Barycentric& at) {
  std::vector<std::int32_t> out;
  const auto nodes = d.space.nodes_of_cell(cell);
  for (int v = 0; v <= d.mesh.dim; ++v) {
    if (at[static_cast<std::size_t>(v)] <= same_place) continue;
    for (int c = 0; c < d.space.components; ++c) {
      const int dof = d.space.dof(nodes[static_cast<std::size_t>(v)], c);
      const std::int32_t unknown = d.dofs.unknown_of[static_cast<std::size_t>(dof)];
      out.push_back(unknown >= 0 ? unknown : -1 - dof);
    }
  }
  std::ranges::sort(out);
  return out;
}

Point centre(const Mesh& mesh, int cell) {
  Point out{};
  const auto& corners = mesh.cells[static_cast<std::size_t>(cell)];
  for (int v = 0; v <= mesh.dim; ++v)
    for (std::size_t i = 0; i < 3; ++i)
      out[i] += mesh.nodes[static_cast<std::size_t>(corners[static_cast<std::size_t>(v)])][i] /
                (mesh.dim + 1);
  return out;
}

bool is_of_fields(const Probe& probe) {
  return probe.kind == Probe::Kind::at_point && !probe.on_pair &&
         !reads_multiplier(probe.expression) &&
         std::ranges::any_of(probe.expression.slots(), slot::is_field);
}

} // namespace

std::vector<Failure> outside_parts(const Plan& plan, const Discretisation& d) {
  std::vector<Failure> out;
  const CellLocator locator(d.mesh, plan.report.probes.size());
  Barycentric at{};
  for (const Probe& probe : plan.report.probes) {
    if (probe.kind != Probe::Kind::at_point || probe.on_pair || probe.part < 0) continue;
    const auto part = static_cast<std::size_t>(probe.part);
    const std::string& name = plan.problem.parts[part].name;
    const char* const help = "`on` names a part of cells that has the point";
    if (d.parts[part].kind != Group::Kind::cells) {
      out.emplace_back(FailureKind::bad_value, probe.origin,
                       fmt::format("`{}` is no part of cells", name), help);
      continue;
    }
    const int found = locator.find(probe.point, at);
    if (found < 0 || cell_that_reads(d, Expr(0.0), probe.point, found, at, probe.part) >= 0)
      continue;
    out.emplace_back(FailureKind::bad_value, probe.origin,
                     fmt::format("the point {} of `{}` is outside `{}`",
                                 describe_point(probe.point, d.mesh.dim), probe.name, name),
                     help);
  }
  return out;
}

std::vector<SeveralValues> several_values(const ReportSpec& report, const Discretisation& d) {
  std::vector<SeveralValues> out;
  const CellLocator locator(d.mesh, report.probes.size());
  for (const Probe& probe : report.probes) {
    if (!is_of_fields(probe)) continue;
    Barycentric at{};
    const int found = locator.find(probe.point, at);
    const int taken =
        found < 0 ? -1 : cell_that_reads(d, probe.expression, probe.point, found, at, probe.part);
    const bool inside = *std::min_element(at.begin(), at.begin() + d.mesh.dim + 1) > same_place;
    if (taken < 0 || inside) continue;
    const ReadingCells cells(d, probe.expression, probe.part);
    const auto nodes = made_of(d, taken, at);
    for (int cell = 0; cell < static_cast<int>(d.mesh.cells.size()); ++cell) {
      const Barycentric there = barycentric_of(d.mesh, cell, probe.point);
      if (!holds(d.mesh, there) || !cells.has(cell) || made_of(d, cell, there) == nodes) continue;
      out.push_back({&probe, centre(d.mesh, taken), centre(d.mesh, cell)});
      break;
    }
  }
  return out;
}

} // namespace hvi::solver
