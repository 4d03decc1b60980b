// Parts of the mesh: from the tree of a plan (groups, unions, differences, predicates) to entities.
#include "solver/fem/region.hpp"

#include "solver/common/joined.hpp"
#include "solver/kernel/tape.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

namespace hvi::solver {
namespace {

using Entities = std::vector<std::int32_t>;

const char* kind_name(Group::Kind kind) {
  switch (kind) {
  case Group::Kind::cells:
    return "cells";
  case Group::Kind::facets:
    return "facets";
  case Group::Kind::points:
    return "points";
  }
  return "";
}

std::string shown(const Mesh& mesh, const Point& p) {
  return fmt::format("({})", joined(p, mesh.dim, 9));
}

/// Levenshtein distance, for "did you mean" (R. A. Wagner, M. J. Fischer, The string-to-string
/// correction problem, J. ACM 21 (1974) 168-173).
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replace = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replace, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

Failure unknown_group(const Mesh& mesh, const RegionSpec& spec) {
  std::string list, closest;
  std::size_t best = std::max<std::size_t>(1, spec.name.size() / 3) + 1;
  for (const auto& [name, group] : mesh.groups) {
    list += (list.empty() ? "" : ", ") + name;
    const auto distance = edit_distance(name, spec.name);
    if (distance < best) {
      best = distance;
      closest = name;
    }
  }
  return Failure(FailureKind::unknown_group, spec.origin,
                 fmt::format("the mesh {} has no group `{}`; {}", mesh.description, spec.name,
                             list.empty() ? "it has no groups" : "its groups are: " + list),
                 closest.empty() ? "" : fmt::format("did you mean `{}`?", closest));
}

/// Corners of an entity.
std::span<const std::int32_t> corners(const Mesh& mesh, Group::Kind kind, const std::int32_t& e) {
  if (kind == Group::Kind::cells)
    return {mesh.cells[e].data(), static_cast<std::size_t>(mesh.nodes_per_cell())};
  if (kind == Group::Kind::facets)
    return {mesh.facets[e].nodes.data(), static_cast<std::size_t>(mesh.nodes_per_facet())};
  return {&e, 1};
}

/// The tests of a predicate: for each entity its centroid, then its corners, each moved by 1e-6 of
/// the way to the centroid (so that a predicate like y > 0.5 is not decided by rounding at corners
/// that lie on the line).
struct Samples {
  std::array<std::vector<double>, 3> x, normal;
  std::size_t per_entity = 0;

  Point at(std::size_t i) const { return {x[0][i], x[1][i], x[2][i]}; }
};

Samples sample(const Mesh& mesh, Group::Kind kind, std::span<const std::int32_t> entities,
               bool normals) {
  Samples s;
  const auto add = [&](const Point& p, const Point& n) {
    for (int a = 0; a < 3; ++a) {
      s.x[a].push_back(p[a]);
      if (normals) s.normal[a].push_back(n[a]);
    }
  };
  for (const std::int32_t& e : entities) {
    const auto nodes = corners(mesh, kind, e);
    s.per_entity = 1 + nodes.size();
    const Point n = normals ? facet_normal(mesh, e) : Point{};
    Point centre{};
    for (const auto i : nodes)
      for (int a = 0; a < 3; ++a) centre[a] += mesh.nodes[i][a] / static_cast<double>(nodes.size());
    add(centre, n);
    for (const auto i : nodes) {
      Point p = mesh.nodes[i];
      for (int a = 0; a < 3; ++a) p[a] += 1e-6 * (centre[a] - p[a]);
      add(p, n);
    }
  }
  return s;
}

/// The centres of the small simplices that an entity is divided into, those with its own
/// orientation: their share inside is that of the entity, about.
Samples sample_inside(const Mesh& mesh, Group::Kind kind, std::span<const std::int32_t> entities) {
  constexpr std::array<int, 5> divisions = {0, 1, 100, 20, 10}; // by number of corners
  Samples s;
  for (const std::int32_t& e : entities) {
    const auto nodes = corners(mesh, kind, e);
    const int n = static_cast<int>(nodes.size()), m = divisions[nodes.size()];
    std::array<int, 4> at{};
    const auto add = [&] {
      for (int a = 0; a < 3; ++a) {
        double x = 0.0;
        for (int i = 0; i < n; ++i) x += mesh.nodes[nodes[i]][a] * (at[i] + 1.0 / n) / m;
        s.x[a].push_back(x);
      }
    };
    const auto visit = [&](const auto& self, int corner, int left) -> void {
      if (corner == n - 1) return at[corner] = left, add();
      for (at[corner] = 0; at[corner] <= left; ++at[corner])
        self(self, corner + 1, left - at[corner]);
    };
    visit(visit, 0, m - 1);
  }
  s.per_entity = entities.empty() ? 0 : s.x[0].size() / entities.size();
  return s;
}

double measure_of_entity(const Mesh& mesh, Group::Kind kind, std::int32_t e) {
  return kind == Group::Kind::cells    ? cell_measure(mesh, e)
         : kind == Group::Kind::facets ? facet_measure(mesh, e)
                                       : 0.0;
}

/// A predicate compiled once, run on batches of entities.
class Predicate {
public:
  Predicate(const Mesh& mesh, const RegionSpec& spec, Group::Kind kind)
      : mesh_(mesh), spec_(spec), kind_(kind), tape_(compile({&spec.predicate, 1})) {
    for (const Slot slot : tape_.inputs) {
      const bool position = slot >= slot::x(0) && slot <= slot::x(2);
      const bool normal = slot >= slot::normal(0) && slot <= slot::normal(2);
      needs_normal_ = needs_normal_ || normal;
      if (!position && !(normal && kind == Group::Kind::facets))
        throw Failure(FailureKind::bad_value, spec.origin,
                      fmt::format("a condition that selects {} may depend on the position{} only",
                                  kind_name(kind),
                                  kind == Group::Kind::facets ? " and the normal" : ""));
    }
  }

  /// Appends the entities that are inside to `region`, keeps those cut in two.
  void select(std::span<const std::int32_t> entities, Region& region) {
    const Samples s = sample(mesh_, kind_, entities, needs_normal_);
    run(s);
    for (std::size_t i = 0; i < entities.size(); ++i) {
      std::size_t inside = 0;
      for (std::size_t k = i * s.per_entity; k < (i + 1) * s.per_entity; ++k) {
        if (std::isnan(values_[k]))
          throw Failure(
              FailureKind::bad_value, spec_.origin,
              fmt::format("the condition has no value (NaN) at {}", shown(mesh_, s.at(k))));
        if (values_[k] != 0) ++inside;
      }
      if (inside == s.per_entity)
        region.entities.push_back(entities[i]);
      else if (inside > 0)
        cut_.push_back(entities[i]);
    }
  }

  /// How many entities were cut in two so far.
  int straddling() const { return static_cast<int>(cut_.size()); }

  /// What they have inside. A condition that reads normals cuts nothing flat by these.
  CutEntities cut() {
    CutEntities out;
    if (needs_normal_) return out;
    constexpr std::size_t batch = 64;
    for (std::size_t first = 0; first < cut_.size(); first += batch) {
      const auto some = std::span(cut_).subspan(first, std::min(batch, cut_.size() - first));
      const Samples s = sample_inside(mesh_, kind_, some);
      run(s);
      for (std::size_t i = 0; i < some.size(); ++i) {
        const auto values = std::span(values_).subspan(i * s.per_entity, s.per_entity);
        const auto inside = std::ranges::count_if(
            values, [](double value) { return !std::isnan(value) && value != 0.0; });
        const double share = static_cast<double>(inside) / static_cast<double>(s.per_entity);
        out.lost += share * measure_of_entity(mesh_, kind_, some[i]);
        out.count += share >= 0.1 ? 1 : 0;
      }
    }
    return out;
  }

private:
  void run(const Samples& s) {
    values_.resize(s.x[0].size());
    std::vector<const double*> inputs;
    for (const Slot slot : tape_.inputs)
      inputs.push_back(slot <= slot::x(2) ? s.x[slot].data()
                                          : s.normal[slot - slot::normal(0)].data());
    evaluate(tape_, inputs, values_.size(), values_, workspace_);
  }

  const Mesh& mesh_;
  const RegionSpec& spec_;
  Group::Kind kind_;
  Tape tape_;
  bool needs_normal_ = false;
  Entities cut_;
  std::vector<double> values_;
  TapeWorkspace workspace_;
};

Region all_cells(const Mesh& mesh) {
  Region region{Group::Kind::cells, Entities(mesh.cells.size()), 0};
  std::iota(region.entities.begin(), region.entities.end(), 0);
  return region;
}

Region boundary(const Mesh& mesh) {
  Region region{Group::Kind::facets, {}, 0};
  for (std::size_t f = 0; f < mesh.facets.size(); ++f)
    if (mesh.facets[f].other < 0) region.entities.push_back(static_cast<std::int32_t>(f));
  return region;
}

Region find(const Mesh& mesh, const RegionSpec& spec);

/// By node: may it be the point that is meant? Empty: any.
std::vector<bool> candidates(const Mesh& mesh, const RegionSpec& spec) {
  if (spec.name.empty()) return {};
  RegionSpec piece = spec;
  piece.kind = RegionSpec::Kind::group;
  std::vector<bool> out(mesh.nodes.size(), false);
  for (const auto n : nodes_of(mesh, find(mesh, piece))) out[static_cast<std::size_t>(n)] = true;
  return out;
}

Region point(const Mesh& mesh, const RegionSpec& spec) {
  std::int32_t nearest = -1;
  double best = std::numeric_limits<double>::infinity();
  const auto among = candidates(mesh, spec);
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    if (!among.empty() && !among[i]) continue;
    const Point& p = mesh.nodes[i];
    const double d = std::hypot(p[0] - spec.point[0], p[1] - spec.point[1], p[2] - spec.point[2]);
    if (d < best) {
      best = d;
      nearest = static_cast<std::int32_t>(i);
    }
  }
  if (!(best <= 1e-9 * bounding_box(mesh).diagonal()))
    throw Failure(FailureKind::bad_value, spec.origin,
                  fmt::format("there is no node of the mesh at {}{}", shown(mesh, spec.point),
                              nearest < 0 ? ""
                                          : fmt::format("; the nearest is at {}",
                                                        shown(mesh, mesh.nodes[nearest]))),
                  "a point must be a node of the mesh");
  return {Group::Kind::points, {nearest}, 0};
}

/// Union or difference of two parts of one kind.
Region combine(const Mesh& mesh, const RegionSpec& spec) {
  if (spec.children.size() != 2)
    throw Failure(FailureKind::bad_value, spec.origin, "a union or difference needs two parts");
  const Region a = find(mesh, spec.children[0]), b = find(mesh, spec.children[1]);
  const bool unite = spec.kind == RegionSpec::Kind::unite;
  if (a.kind != b.kind)
    throw Failure(FailureKind::bad_value, spec.origin,
                  fmt::format("{} and {} cannot be {}", kind_name(a.kind), kind_name(b.kind),
                              unite ? "united" : "subtracted"),
                  "combine parts of one kind: cells with cells, sides with sides");
  Region out{a.kind, {}, a.straddling + b.straddling};
  const auto to = std::back_inserter(out.entities);
  if (unite)
    std::set_union(a.entities.begin(), a.entities.end(), b.entities.begin(), b.entities.end(), to);
  else
    std::set_difference(a.entities.begin(), a.entities.end(), b.entities.begin(), b.entities.end(),
                        to);
  return out;
}

Region where(const Mesh& mesh, const RegionSpec& spec) {
  if (spec.children.size() != 1)
    throw Failure(FailureKind::bad_value, spec.origin,
                  "a condition needs the part it selects from");
  constexpr std::size_t batch = 1024; // entities at a time: a few pages of scratch memory
  const Region all = find(mesh, spec.children[0]);
  Predicate predicate(mesh, spec, all.kind);
  Region out{all.kind, {}, all.straddling};
  const std::span<const std::int32_t> entities(all.entities);
  for (std::size_t i = 0; i < entities.size(); i += batch)
    predicate.select(entities.subspan(i, std::min(batch, entities.size() - i)), out);
  out.straddling += predicate.straddling();
  out.cut = predicate.cut();
  return out;
}

Region pair(const Mesh& mesh, const RegionSpec& spec) {
  if (spec.children.size() != 2)
    throw Failure(FailureKind::bad_value, spec.origin, "a pair has two sides");
  Region out = resolve(mesh, spec.children[0]);
  const Region second = resolve(mesh, spec.children[1]);
  if (out.kind != Group::Kind::facets || second.kind != Group::Kind::facets || out.is_pair() ||
      second.is_pair())
    throw Failure(FailureKind::bad_value, spec.origin,
                  fmt::format("a pair is of two sides, not of {} and {}", kind_name(out.kind),
                              kind_name(second.kind)));
  out.straddling += second.straddling;
  out.cut = {}; // said of the sides
  out.second = second.entities;
  out.reach = spec.reach;
  return out;
}

Region find(const Mesh& mesh, const RegionSpec& spec) {
  switch (spec.kind) {
  case RegionSpec::Kind::pair:
    return pair(mesh, spec);
  case RegionSpec::Kind::all_cells:
    return all_cells(mesh);
  case RegionSpec::Kind::boundary:
    return boundary(mesh);
  case RegionSpec::Kind::point:
    return point(mesh, spec);
  case RegionSpec::Kind::unite:
  case RegionSpec::Kind::subtract:
    return combine(mesh, spec);
  case RegionSpec::Kind::where:
    return where(mesh, spec);
  case RegionSpec::Kind::group:
    break;
  }
  const auto at = mesh.groups.find(spec.name);
  if (at == mesh.groups.end()) throw unknown_group(mesh, spec);
  return {at->second.kind, at->second.entities, 0};
}

} // namespace

Region resolve(const Mesh& mesh, const RegionSpec& spec) {
  Region region = find(mesh, spec);
  if (!region.entities.empty()) return region;
  std::string message = fmt::format("the part has no {} on this mesh", kind_name(region.kind));
  if (spec.kind == RegionSpec::Kind::group)
    message = fmt::format("the group `{}` has no {}", spec.name, kind_name(region.kind));
  throw Failure(FailureKind::empty_region, spec.origin, message,
                region.straddling == 0
                    ? ""
                    : fmt::format("{} {} lie partly inside, and only whole ones are selected: let "
                                  "the mesh follow the condition",
                                  region.straddling, kind_name(region.kind)));
}

std::vector<std::int32_t> common(const Region& a, const Region& b) {
  Entities out;
  if (a.kind == b.kind)
    std::set_intersection(a.entities.begin(), a.entities.end(), b.entities.begin(),
                          b.entities.end(), std::back_inserter(out));
  return out;
}

double region_measure(const Mesh& mesh, const Region& region) {
  double out = 0.0;
  for (const std::int32_t e : region.entities) out += measure_of_entity(mesh, region.kind, e);
  return out;
}

std::vector<std::int32_t> nodes_of(const Mesh& mesh, const Region& region) {
  std::vector<bool> used(mesh.nodes.size(), false);
  for (const std::int32_t& e : region.entities)
    for (const auto n : corners(mesh, region.kind, e)) used[n] = true;
  Entities nodes;
  for (std::size_t n = 0; n < used.size(); ++n)
    if (used[n]) nodes.push_back(static_cast<std::int32_t>(n));
  return nodes;
}

} // namespace hvi::solver
