// See domains.hpp. Called by discretise and by the probes.
#include "solver/discrete/domains.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>

namespace hvi::solver {
namespace {

/// What is read of each unknown, and whether its gradient is.
struct Read {
  std::array<bool, slot::most_unknowns> any{}, gradient{};

  void add(int derivative) {
    const auto b = static_cast<std::size_t>(slot::unknown_of(derivative));
    any[b] = true;
    gradient[b] = gradient[b] || !slot::is_value(derivative);
  }
};

/// The expression where the block has no functions: outside the parts of cells that are all in its
/// domain.
Expr outside(const Discretisation& d, const SpaceBlock& block, const Expr& expression) {
  std::vector<std::pair<Slot, Expr>> replaced;
  for (std::size_t p = 0; p < d.parts.size(); ++p) {
    const Region& part = d.parts[p];
    const Slot inside = slot::inside(static_cast<int>(p));
    if (part.kind == Group::Kind::cells && expression.depends_on(inside) &&
        std::ranges::all_of(part.entities, [&](std::int32_t c) { return block.lives_in(c); }))
      replaced.emplace_back(inside, Expr(0.0));
  }
  return replaced.empty() ? expression : substitute(expression, replaced);
}

/// What an expression reads of the unknowns with a domain where they have no functions.
void add_expression(const Discretisation& d, const Expr& expression, Read& read) {
  for (std::size_t b = 0; b < d.space.blocks.size(); ++b) {
    if (!d.space.blocks[b].domain) continue;
    for (const Slot s : slots_of(outside(d, d.space.blocks[b], expression)))
      if (slot::is_field(s) && slot::unknown_of(slot::derivative_of(s)) == static_cast<int>(b))
        read.add(slot::derivative_of(s));
  }
}

/// A facet between cells with functions and others has values, and gradients on the side of its
/// first cell.
bool facet_is_in(const Mesh& mesh, const SpaceBlock& block, std::int32_t facet, bool gradient) {
  const Facet& f = mesh.facets[static_cast<std::size_t>(facet)];
  return block.lives_in(f.cell) || (!gradient && f.other >= 0 && block.lives_in(f.other));
}

bool is_in(const Space& space, const SpaceBlock& block, const Region& region, bool gradient) {
  const Mesh& mesh = *space.mesh;
  const auto facet = [&](std::int32_t f) { return facet_is_in(mesh, block, f, gradient); };
  switch (region.kind) {
  case Group::Kind::cells:
    return std::ranges::all_of(region.entities, [&](std::int32_t c) { return block.lives_in(c); });
  case Group::Kind::facets:
    return std::ranges::all_of(region.entities, facet) && std::ranges::all_of(region.second, facet);
  case Group::Kind::points:
    return std::ranges::all_of(region.entities, [&](std::int32_t node) {
      return block.domain->has_node[static_cast<std::size_t>(node)] != 0;
    });
  }
  return true;
}

class Checks {
public:
  Checks(const Plan& plan, const Discretisation& d) : problem_(plan.problem), d_(d) {}

  void on_part(const Read& read, int part, Origin origin, const std::string& what) {
    for (std::size_t b = 0; b < d_.space.blocks.size(); ++b) {
      const SpaceBlock& block = d_.space.blocks[b];
      if (!read.any[b] || !block.domain) continue;
      if (!is_in(d_.space, block, d_.parts[static_cast<std::size_t>(part)], read.gradient[b]))
        refuse(block, origin, fmt::format("{} on `{}` reaches beyond", what, name(part)));
    }
  }
  void at_point(const Probe& probe, const CellLocator& locator) {
    std::array<double, 4> at{};
    const int found = locator.find(probe.point, at);
    if (found < 0 || cell_that_reads(d_, probe.expression, probe.point, found, at) >= 0) return;
    Read read;
    add_expression(d_, probe.expression, read);
    for (std::size_t b = 0; b < d_.space.blocks.size(); ++b)
      if (const SpaceBlock& block = d_.space.blocks[b]; read.any[b] && block.domain)
        refuse(block, probe.origin,
               fmt::format("the point {} of `{}` lies outside",
                           describe_point(probe.point, d_.mesh.dim), probe.name));
  }

  std::vector<Failure> failures;

private:
  const std::string& name(int part) const {
    return problem_.parts[static_cast<std::size_t>(part)].name;
  }
  void refuse(const SpaceBlock& block, Origin origin, const std::string& what) {
    failures.emplace_back(
        FailureKind::bad_value, origin,
        fmt::format("`{}` lives on `{}`, and {} it", block.name, name(block.domain->part), what),
        "let it stay inside, or give the space the whole mesh");
  }

  const Problem& problem_;
  const Discretisation& d_;
};

void check_laws(const Problem& problem, const Discretisation& d, Checks& checks) {
  for (const LawTerm& term : problem.law_terms) {
    Read read;
    read.add(slot::of_unknown(term.unknown, slot::value(0)));
    for (const Expr& reading : problem.laws[static_cast<std::size_t>(term.law)].readings)
      add_expression(d, reading, read);
    checks.on_part(read, term.part, term.origin, fmt::format("the law `{}`", term.name));
  }
}

} // namespace

std::vector<Failure> outside_domains(const Plan& plan, const Discretisation& d) {
  const bool any = std::ranges::any_of(
      d.space.blocks, [](const SpaceBlock& block) { return block.domain != nullptr; });
  if (!any) return {};
  const Problem& problem = plan.problem;
  Checks checks(plan, d);
  for (const FormTerm& form : problem.forms) {
    Read read;
    for (const auto& entry : form.entries) read.add(entry.test), read.add(entry.trial);
    checks.on_part(read, form.part, form.origin, "a form");
  }
  for (const LoadTerm* const load : all_loads(problem)) {
    Read read;
    for (const auto& entry : load->entries) read.add(entry.test);
    checks.on_part(read, load->part, load->origin, "a load");
  }
  check_laws(problem, d, checks);
  for (const StateTerm& state : problem.states) {
    Read read;
    add_expression(d, state.rate, read);
    checks.on_part(read, state.part, state.origin, fmt::format("the state `{}`", state.name));
  }
  const CellLocator locator(d.mesh, plan.report.probes.size());
  for (const Probe& probe : plan.report.probes) {
    Read read;
    add_expression(d, probe.expression, read);
    using K = Probe::Kind;
    if (probe.kind == K::integral && probe.part >= 0)
      checks.on_part(read, probe.part, probe.origin, "the integral");
    if ((probe.kind == K::largest || probe.kind == K::smallest) && probe.part >= 0)
      checks.on_part(read, probe.part, probe.origin,
                     probe.kind == K::largest ? "the largest value" : "the smallest value");
    if (probe.kind == Probe::Kind::at_point && !probe.on_pair) checks.at_point(probe, locator);
  }
  return std::move(checks.failures);
}

ReadingCells::ReadingCells(const Discretisation& d, const Expr& expression, int part)
    : space_(d.space) {
  Read read;
  add_expression(d, expression, read);
  read_ = read.any;
  if (part < 0) return;
  of_part_.assign(d.mesh.cells.size(), 0);
  for (const std::int32_t cell : d.parts[static_cast<std::size_t>(part)].entities)
    of_part_[static_cast<std::size_t>(cell)] = 1;
}

bool ReadingCells::has(int cell) const {
  if (!of_part_.empty() && of_part_[static_cast<std::size_t>(cell)] == 0) return false;
  for (std::size_t b = 0; b < space_.blocks.size(); ++b)
    if (read_[b] && !space_.blocks[b].lives_in(cell)) return false;
  return true;
}

int cell_that_reads(const Discretisation& d, const Expr& expression, const Point& point, int found,
                    std::array<double, 4>& barycentric, int part) {
  const Space& space = d.space;
  const ReadingCells cells(d, expression, part);
  if (cells.has(found)) return found;
  Mesh where; // of the cells that will do
  where.dim = space.mesh->dim;
  where.nodes = space.mesh->nodes;
  std::vector<int> number;
  for (int cell = 0; cell < static_cast<int>(space.mesh->cells.size()); ++cell) {
    if (!cells.has(cell)) continue;
    number.push_back(cell);
    where.cells.push_back(space.mesh->cells[static_cast<std::size_t>(cell)]);
  }
  if (number.empty()) return -1;
  const int in = CellLocator(where).find(point, barycentric);
  return in < 0 ? -1 : number[static_cast<std::size_t>(in)];
}

} // namespace hvi::solver
