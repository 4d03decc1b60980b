// What a mesh that was read from a file does to a script's problem; see mesh_report.hpp.
#include "lang/mesh_report.hpp"

#include "lang/check/mesh_findings.hpp"
#include "solver/kernel/expr.hpp"
#include "solver/kernel/slot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <string_view>
#include <vector>

namespace hvi::lang {

namespace {

using solver::Group;

/// What may stop a piece from floating.
enum Holder : unsigned { by_values = 1, by_law = 2, by_form = 4, by_node = 8 };

std::string holders(unsigned by) {
  if (by & by_values) return "held by boundary values";
  if (by & by_law) return "held by a law only";
  if (by & by_form) return "held by a form without derivatives";
  return by & by_node ? "hanging on single nodes of another" : "held by nothing";
}

bool has_values(const solver::FormTerm& form) {
  return std::any_of(form.entries.begin(), form.entries.end(), [](const auto& e) {
    return solver::slot::is_value(e.test) || solver::slot::is_value(e.trial);
  });
}

/// Which pieces parts of the plan touch.
class Holding {
public:
  Holding(const solver::Discretisation& d, const std::vector<std::int32_t>& piece_of,
          std::size_t pieces)
      : d_(d), piece_of_(piece_of), by_(pieces, 0), piece_of_node_(d.mesh.nodes.size(), -1) {
    for (std::size_t c = 0; c < d.mesh.cells.size(); ++c)
      for (int k = 0; k <= d.mesh.dim; ++k) {
        auto& known = piece_of_node_[d.mesh.cells[c][k]];
        if (known >= 0 && known != piece_of[c]) by_[known] |= by_node, by_[piece_of[c]] |= by_node;
        known = piece_of[c];
      }
  }
  void note(int part, Holder holder) {
    const solver::Region& region = d_.parts[static_cast<std::size_t>(part)];
    for (const auto e : region.second) by_[piece_of_[d_.mesh.facets[e].cell]] |= holder;
    for (const auto e : region.entities) {
      if (region.kind == Group::Kind::points) {
        by_[piece_of_node_[e]] |= holder;
        continue;
      }
      const bool facet = region.kind == Group::Kind::facets;
      by_[piece_of_[facet ? d_.mesh.facets[e].cell : e]] |= holder;
      if (facet && d_.mesh.facets[e].other >= 0) by_[piece_of_[d_.mesh.facets[e].other]] |= holder;
    }
  }
  unsigned by(std::size_t piece) const { return by_[piece]; }

private:
  const solver::Discretisation& d_;
  const std::vector<std::int32_t>& piece_of_;
  std::vector<unsigned> by_;
  std::vector<std::int32_t> piece_of_node_; ///< one of them, where pieces touch in a node
};

/// Whether pairs of sides join all pieces: then they are meant to be apart.
bool joined_by_pairs(const solver::Discretisation& d, const std::vector<std::int32_t>& piece_of,
                     std::size_t pieces) {
  std::vector<std::size_t> group(pieces);
  std::iota(group.begin(), group.end(), std::size_t{0});
  for (const solver::Region& region : d.parts) {
    if (!region.is_pair() || region.entities.empty()) continue;
    const auto of = [&](std::int32_t facet) {
      return group[static_cast<std::size_t>(piece_of[d.mesh.facets[facet].cell])];
    };
    const std::size_t one = of(region.entities.front());
    const auto join = [&](std::int32_t facet) {
      std::ranges::replace(group, std::size_t{of(facet)}, one);
    };
    std::ranges::for_each(region.entities, join);
    std::ranges::for_each(region.second, join);
  }
  return std::ranges::all_of(group, [&](std::size_t g) { return g == group.front(); });
}

/// Points of pairs that have no partner.
void report_alone(Script& script, const solver::Discretisation& d) {
  for (const auto& alone : d.alone) {
    const auto& part = script.model->parts[static_cast<std::size_t>(alone.part)];
    script.diagnostics.add(
        diagnose("W0607", part.span,
                 fmt::format("{} node{} of the first side of `{}` {} no partner on the second one, "
                             "and {} free ({}at {})",
                             alone.points, alone.points == 1 ? "" : "s", part.name,
                             alone.points == 1 ? "has" : "have", alone.points == 1 ? "is" : "are",
                             alone.points == 1 ? "" : "the first one ",
                             solver::describe_point(alone.first, d.mesh.dim)))
            .with_help("where sides are to touch beyond that, `pair(a, b, reach = ..)` looks "
                       "farther; else take these facets out of the part"));
  }
}

/// Conditions that cut cells or sides: what is cut is left out, and the part is smaller. Not of a
/// side chosen by a thin band, `x > 1.99`, which cuts the sides around it by that little, nor of a
/// curved side that ends within a small facet.
void report_cut(Script& script, const solver::Discretisation& d) {
  constexpr double little = 0.1;
  for (std::size_t i = 0; i < d.parts.size(); ++i) {
    const solver::Region& region = d.parts[i];
    if (region.cut.count == 0) continue;
    const double kept = solver::region_measure(d.mesh, region), whole = kept + region.cut.lost;
    if (region.cut.lost <= little * whole) continue;
    const auto& part = script.model->parts[i];
    const bool cells = region.kind == Group::Kind::cells, one = region.cut.count == 1;
    const int dim = d.mesh.dim - (cells ? 0 : 1);
    script.diagnostics.add(
        diagnose("W0608", part.span,
                 fmt::format("the condition of `{}` cuts {} {}{}, which {} left out: the part has "
                             "the {} {:.4g} instead of {:.4g}",
                             part.name, region.cut.count, cells ? "cell" : "side", one ? "" : "s",
                             one ? "is" : "are",
                             dim == 1   ? "length"
                             : dim == 2 ? "area"
                                        : "volume",
                             kept, whole))
            .with_help("a part has whole cells and sides: let the mesh follow the condition, by "
                       "the number of its cells or an edge in its geometry"));
  }
}

/// Is a part made of a group of which that holds, among others?
bool has_group(const solver::Mesh& mesh, const solver::RegionSpec& region, bool Group::*what) {
  const auto group = region.kind == solver::RegionSpec::Kind::group ? mesh.groups.find(region.name)
                                                                    : mesh.groups.end();
  if (group != mesh.groups.end() && group->second.*what) return true;
  return std::ranges::any_of(region.children, [&](const solver::RegionSpec& child) {
    return has_group(mesh, child, what);
  });
}

/// Lines in space are no parts of a body's boundary: forces and values on them have no limit as
/// cells become small. Their nodes may hold a body as single points do.
void report_lines(Script& script, const solver::Discretisation& d) {
  for (std::size_t i = 0; i < d.parts.size(); ++i) {
    if (!has_group(d.mesh, script.plan->problem.parts[i].region, &Group::of_lines)) continue;
    const auto& part = script.model->parts[i];
    const std::size_t n = d.parts[i].entities.size();
    script.diagnostics.add(
        diagnose(
            "W0610", part.span,
            fmt::format("`{}` is made of lines in space, of which the {} node{} at the ends of "
                        "edges {} taken: an integral is the sum over them, not over a length",
                        part.name, n, n == 1 ? "" : "s", n == 1 ? "is" : "are"))
            .with_help(
                "take a narrow strip of the boundary, `body.boundary where ...`, or a group "
                "of surfaces: there forces are per area, and P2 is held between the corners, too"));
  }
}

/// Of the mesh, or of the piece whose boundary is the group `of_piece`.
bool names_boundary(const solver::RegionSpec& region, const std::string& of_piece) {
  using Kind = solver::RegionSpec::Kind;
  const bool own = of_piece.empty() ? region.kind == Kind::boundary
                                    : region.kind == Kind::group && region.name == of_piece;
  return own || std::ranges::any_of(region.children, [&](const solver::RegionSpec& child) {
           return names_boundary(child, of_piece);
         });
}

std::vector<std::int32_t> outer_facets(const solver::Mesh& mesh) {
  std::vector<std::int32_t> out;
  for (std::size_t f = 0; f < mesh.facets.size(); ++f)
    if (mesh.facets[f].other < 0) out.push_back(static_cast<std::int32_t>(f));
  return out;
}

void report_boundary(Script& script, const solver::Discretisation& d, const Group& group,
                     const std::string& of_piece, const std::vector<std::int32_t>& all) {
  if (group.kind == Group::Kind::facets && group.entities == all) return;
  for (std::size_t i = 0; i < d.parts.size(); ++i) {
    const auto& part = script.model->parts[i];
    if (!names_boundary(script.plan->problem.parts[i].region, of_piece)) continue;
    script.diagnostics.add(
        diagnose("W0611", part.span,
                 fmt::format("`{}` is made of all of the boundary, and the file has a group "
                             "\"boundary\", which is something else",
                             part.name))
            .with_help("the group is `.group(\"boundary\")`"));
  }
}

/// `m.boundary` is all of it, also where the file has a group of that name.
void report_boundaries(Script& script, const solver::Discretisation& d) {
  const std::string of_file = ".group(\"boundary\")";
  for (const auto& [name, group] : d.mesh.groups) {
    if (name == "boundary") report_boundary(script, d, group, {}, outer_facets(d.mesh));
    if (!name.ends_with(of_file)) continue;
    const std::string whole = name.substr(0, name.size() - of_file.size()) + ".boundary";
    if (const auto all = d.mesh.groups.find(whole); all != d.mesh.groups.end())
      report_boundary(script, d, group, whole, all->second.entities);
  }
}

/// Does a number change with the sign of the normal? Tried at a few places.
bool turns_with_normal(const solver::Expr& e) {
  namespace slot = solver::slot;
  if (!e.depends_on_any(slot::normal(0), slot::normal(2) + 1)) return false;
  for (const double shift : {0.37, 1.91}) {
    const auto along = [&](double sign) {
      return solver::evaluate(e, [&](solver::Slot s) {
        const bool normal = s >= slot::normal(0) && s <= slot::normal(2);
        return (normal ? sign : 1.0) * (0.5 + 0.4 * std::sin(shift * (1.0 + s)));
      });
    };
    const double one = along(1.0), other = along(-1.0);
    if (std::abs(one - other) > 1e-9 * std::max(std::abs(one), std::abs(other))) return true;
  }
  return false;
}

/// The parts on which something depends on the side that the normal points out of: what is counted
/// along it (pressures, normal laws, `u.nu`), and gradients, which are those of that side.
std::vector<bool> parts_with_side(const solver::Plan& plan) {
  std::vector<bool> out(plan.problem.parts.size(), false);
  const auto mark = [&](int part) { out[static_cast<std::size_t>(part)] = true; };
  const auto note = [&](int part, const solver::Expr& e) {
    const bool gradient = std::ranges::any_of(solver::slots_of(e), solver::slot::is_field_gradient);
    if (part >= 0 && (gradient || turns_with_normal(e))) mark(part);
  };
  for (const auto& form : plan.problem.forms)
    for (const auto& e : form.entries) {
      note(form.part, e.coefficient);
      if (!solver::slot::is_value(e.test) || !solver::slot::is_value(e.trial)) mark(form.part);
    }
  for (const auto* loads : {&plan.problem.loads, &plan.problem.state_loads})
    for (const auto& load : *loads)
      for (const auto& e : load.entries) note(load.part, e.value);
  for (const auto& law : plan.problem.law_terms)
    for (const auto& row : law.rows)
      for (const auto& e : row.u) note(law.part, e);
  for (const auto& state : plan.problem.states) note(state.part, state.rate);
  for (const auto& probe : plan.report.probes) note(probe.part, probe.expression);
  return out;
}

/// Where two facets inside the body meet whose normals point to different sides: a node of it.
std::optional<std::int32_t> turned_at(const solver::Mesh& mesh, const solver::Region& region) {
  using Ridge = std::array<std::int32_t, 2>;
  std::map<Ridge, std::vector<bool>> runs; // the facets at a ridge: which way do they go round it?
  for (const std::int32_t f : region.entities) {
    const solver::Facet& facet = mesh.facets[f];
    if (facet.other < 0) continue;
    for (int k = 0; k < mesh.dim; ++k) {
      const std::int32_t a = facet.nodes[k], b = facet.nodes[(k + 1) % mesh.dim];
      if (mesh.dim == 2) runs[{a, a}].push_back(k == 0);
      if (mesh.dim == 3) runs[{std::min(a, b), std::max(a, b)}].push_back(a < b);
    }
  }
  for (const auto& [ridge, ways] : runs)
    if (ways.size() == 2 && ways[0] == ways[1]) return ridge[0];
  return std::nullopt;
}

/// Facets inside the body have the normals that the order of their nodes in the file gives.
void report_turned(Script& script, const solver::Discretisation& d) {
  const auto with_side = parts_with_side(*script.plan);
  for (std::size_t i = 0; i < d.parts.size(); ++i) {
    if (!with_side[i] || d.parts[i].kind != Group::Kind::facets || d.parts[i].is_pair()) continue;
    const auto& part = script.model->parts[i];
    if (has_group(d.mesh, script.plan->problem.parts[i].region, &Group::against_another)) {
      script.diagnostics.add(
          diagnose("W0609", part.span,
                   fmt::format("`{}` has facets inside the body that another group of the file has "
                               "the other way round: their normals are those of that group",
                               part.name))
              .with_help("a facet has one normal: count along it on one of the groups, with a "
                         "minus before what belongs to the other side"));
      continue;
    }
    const auto node = turned_at(d.mesh, d.parts[i]);
    if (!node) continue;
    script.diagnostics.add(
        diagnose("W0609", part.span,
                 fmt::format("`{}` lies inside the body, and its normals do not point to one side: "
                             "they turn at {}",
                             part.name, solver::describe_point(d.mesh.nodes[*node], d.mesh.dim)))
            .with_help("the order of the nodes in the file makes them: in gmsh write curves and "
                       "surfaces that run the other way with a minus, `Physical Curve(\"seam\") = "
                       "{5, -6};`"));
  }
}

} // namespace

void report_misfits(Script& script, const solver::Discretisation& d) {
  const solver::Problem& problem = script.plan->problem;
  report_alone(script, d);
  report_cut(script, d);
  report_turned(script, d);
  report_lines(script, d);
  report_boundaries(script, d);
  if (problem.mesh.kind != solver::MeshSpec::Kind::file) return;
  const Span span = script.model->origins[static_cast<std::size_t>(problem.mesh.origin.id)];
  const auto add = [&](const MeshFinding& f) {
    script.diagnostics.add(diagnose(f.code, span, f.message).with_help(f.help));
  };
  const bool apart = std::ranges::any_of(d.parts, [](const auto& part) { return part.is_pair(); });
  for (const MeshFinding& f : misfits(d.mesh))
    if (!apart || f.code != std::string_view("W0603"))
      add(f); // the sides of a pair are meant to be two
  const auto piece_of = solver::pieces_of(d.mesh);
  const auto all = solver::measure_pieces(d.mesh, piece_of);
  if (all.size() < 2) return;
  Holding holding(d, piece_of, all.size());
  for (const auto& values : problem.space.dirichlet) holding.note(values.part, by_values);
  for (const auto& law : problem.law_terms) holding.note(law.part, by_law);
  for (const auto& form : problem.forms)
    if (has_values(form)) holding.note(form.part, by_form);
  std::vector<std::string> held;
  for (std::size_t p = 0; p < all.size(); ++p) held.push_back(holders(holding.by(p)));
  if (!joined_by_pairs(d, piece_of, all.size())) add(pieces(all, held, d.mesh.dim));
  for (std::size_t p = 0; p < all.size(); ++p) {
    if (holding.by(p) != 0) continue;
    add({"E0425",
         fmt::format("a piece of the body is held by nothing: {}",
                     describe_piece(all[p], d.mesh.dim)),
         "clamp it (`zero on ...`), give it a law, or join it to the rest: in gmsh with `Coherence "
         "Mesh;` or BooleanFragments"});
    return;
  }
}

} // namespace hvi::lang
