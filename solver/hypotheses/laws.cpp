// The laws of a plan as constants and as forms; see laws.hpp.
#include "solver/hypotheses/laws.hpp"

#include "solver/assembly/assembly.hpp"
#include "solver/discrete/contact_states.hpp"
#include "solver/law/known_constants.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace hvi::solver {
namespace {

/// The entities of a part as simplices, and the times of the plan.
LawDomain domain_of(const Problem& problem, const Mesh& mesh, const Region& region) {
  LawDomain out;
  if (!problem.time.is_static)
    out.t_low = problem.time.grid.front(), out.t_high = problem.time.grid.back();
  for (const auto entity : region.entities) {
    LawDomain::Simplex s;
    s.n = region.kind == Group::Kind::cells    ? mesh.nodes_per_cell()
          : region.kind == Group::Kind::facets ? mesh.nodes_per_facet()
                                               : 1;
    for (int k = 0; k < s.n; ++k) {
      const auto node = region.kind == Group::Kind::cells    ? mesh.cells[entity][k]
                        : region.kind == Group::Kind::facets ? mesh.facets[entity].nodes[k]
                                                             : entity;
      s.corners[k] = mesh.nodes[node];
    }
    out.part.push_back(s);
  }
  return out;
}

KnownConstants constants_of(const Problem& problem, const Discretisation& d,
                            const ContactTerm& term, const Law& law) {
  const double start = problem.time.is_static ? 0.0 : problem.time.grid.front();
  if (law.reads_states() || law.reads())
    return known_constants(
        law, term.points.x[0],
        initial_law_times(problem, law, term.points, start, term.first_readings).front());
  if (law.coupled() || (!law.depends_on_x() && !law.depends_on_t()))
    return known_constants(law, term.points.x[0], start);
  const auto& part = d.parts[problem.law_terms[term.points.law_term].part];
  return known_constants(law, domain_of(problem, d.mesh, part));
}

SparseMatrix trace_form(const Problem& problem, const Discretisation& d, const StateLayout& layout,
                        Trace trace) {
  std::set<int> parts;
  for (const auto& term : problem.law_terms)
    if (d.parts[term.part].kind == Group::Kind::facets) parts.insert(term.part);
  SparseMatrix sum(layout.n_unknowns, layout.n_unknowns);
  for (const int part : parts) {
    const auto rule =
        std::find_if(problem.law_terms.begin(), problem.law_terms.end(), [&](const LawTerm& t) {
          return t.part == part;
        })->rule;
    const SparseMatrix full = boundary_mass(d.space, d.parts[part], rule, trace);
    sum = SparseMatrix(sum + restrict_rows(full, layout).leftCols(layout.n_unknowns));
  }
  return sum;
}

} // namespace

std::vector<TermConstants> law_constants(const Problem& problem, const Discretisation& d,
                                         const Contact& contact) {
  std::vector<TermConstants> out;
  for (const auto& term : contact.terms) {
    const Law& law = *contact.laws[problem.law_terms[term.points.law_term].law];
    TermConstants here;
    here.term = term.points.law_term;
    here.radial = law.spec().radial;
    if (term.n_points() > 0) {
      const KnownConstants k = constants_of(problem, d, term, law);
      here.m = k.m, here.c = k.c, here.at = k.worst_at;
      here.jumps_down = k.jumps_down;
      here.lipschitz = std::max(k.m.value(), k.steepest_ascent.value());
      here.regular = k.clarke_regular || std::isfinite(k.m.value());
    }
    out.push_back(here);
  }
  return out;
}

TraceNorms trace_norms(const Problem& problem, const Discretisation& d, const StateLayout& layout,
                       const GramForm& gram) {
  const auto norm = [&](Trace trace) {
    return gram.largest(trace_form(problem, d, layout, trace)).value_or(std::nan(""));
  };
  const double all = norm(Trace::full);
  if (d.space.is_product()) return {all, all, all};    // each of its parts is at most the whole
  if (d.space.components == 1) return {all, 0.0, all}; // a scalar has one trace
  return {norm(Trace::normal), norm(Trace::tangential), all};
}

} // namespace hvi::solver
