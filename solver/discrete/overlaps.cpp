// Parts that may not share entities; called by discretise.
#include "solver/discrete/overlaps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace hvi::solver {
namespace {

/// Three of each unknown.
using Components = std::array<bool, 3 * slot::most_unknowns>;

/// Facets of `region` imposed with all `wanted` components by the Dirichlet entries together.
std::vector<std::int32_t> clamped_facets(const Problem& problem, std::span<const Region> parts,
                                         const Region& region, const Components& wanted) {
  std::vector<std::int32_t> left = region.entities;
  for (std::size_t c = 0; c < wanted.size() && !left.empty(); ++c) {
    if (!wanted[c]) continue;
    const int component = static_cast<int>(c % 3), unknown = static_cast<int>(c / 3);
    std::vector<std::int32_t> imposed;
    for (const auto& entry : problem.space.dirichlet) {
      if (entry.unknown != unknown) continue;
      if (entry.component != -1 && entry.component != component) continue;
      Region candidates{region.kind, left, 0};
      for (const auto facet : common(candidates, parts[entry.part])) imposed.push_back(facet);
    }
    std::sort(imposed.begin(), imposed.end());
    imposed.erase(std::unique(imposed.begin(), imposed.end()), imposed.end());
    left = std::move(imposed);
  }
  return left;
}

Components acted_on(const LawTerm& term) {
  Components out{};
  const auto first = static_cast<std::size_t>(3 * term.unknown);
  for (const auto& row : term.rows)
    for (std::size_t i = 0; i < 3; ++i) out[first + i] = out[first + i] || !row.u[i].is(0.0);
  return out;
}

Components acted_on(const LoadTerm& term) {
  Components out{};
  for (const auto& entry : term.entries) {
    const int component = slot::component_of(entry.test);
    out[static_cast<std::size_t>(3 * slot::unknown_of(entry.test) + component)] = true;
  }
  return out;
}

/// Where a facet is, for messages: its centroid.
std::string place(const Mesh& mesh, std::int32_t facet) {
  Point centre{};
  for (int k = 0; k < mesh.nodes_per_facet(); ++k)
    for (int i = 0; i < 3; ++i)
      centre[i] += mesh.nodes[mesh.facets[facet].nodes[k]][i] / mesh.nodes_per_facet();
  if (mesh.dim == 1) return fmt::format("{:.6g}", centre[0]);
  if (mesh.dim == 2) return fmt::format("({:.6g}, {:.6g})", centre[0], centre[1]);
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", centre[0], centre[1], centre[2]);
}

bool same_rows(const LawTerm& a, const LawTerm& b) {
  if (a.unknown != b.unknown || a.mean != b.mean) return false;
  if (a.rows.size() != b.rows.size()) return false;
  for (std::size_t r = 0; r < a.rows.size(); ++r)
    for (int i = 0; i < 3; ++i)
      if (!(a.rows[r].u[i] == b.rows[r].u[i])) return false;
  return true;
}

void check_clamped(const Problem& problem, const Mesh& mesh, std::span<const Region> parts,
                   Origin origin, int part, const Components& components, const std::string& what,
                   std::vector<Failure>& failures) {
  if (parts[part].kind != Group::Kind::facets) return;
  const auto clamped = clamped_facets(problem, parts, parts[part], components);
  if (clamped.empty()) return;
  failures.emplace_back(FailureKind::overlapping_regions, origin,
                        fmt::format("{} acts on part `{}`, of which {} facet{} clamped (at {})",
                                    what, problem.parts[part].name, clamped.size(),
                                    clamped.size() == 1 ? " is" : "s are",
                                    place(mesh, clamped.front())),
                        "take the clamped facets out of the part: `part - clamped`");
}

} // namespace

std::vector<Failure> overlaps(const Problem& problem, const Mesh& mesh,
                              std::span<const Region> parts) {
  std::vector<Failure> failures;
  for (const auto& term : problem.law_terms)
    check_clamped(problem, mesh, parts, term.origin, term.part, acted_on(term),
                  "the law `" + term.name + "`", failures);
  for (const LoadTerm* const load : all_loads(problem))
    check_clamped(problem, mesh, parts, load->origin, load->part, acted_on(*load), "a load",
                  failures);
  for (std::size_t b = 0; b < problem.law_terms.size(); ++b)
    for (std::size_t a = 0; a < b; ++a) {
      const auto &first = problem.law_terms[a], &second = problem.law_terms[b];
      if (first.law != second.law || !same_rows(first, second) ||
          parts[first.part].second != parts[second.part].second ||
          common(parts[first.part], parts[second.part]).empty())
        continue;
      failures.emplace_back(FailureKind::overlapping_regions, second.origin,
                            fmt::format("the law `{}` acts twice on part `{}`", second.name,
                                        problem.parts[second.part].name),
                            "put a factor before it instead");
    }
  return failures;
}

} // namespace hvi::solver
