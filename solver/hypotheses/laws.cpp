// The laws of a plan as constants and as forms; see laws.hpp.
#include "solver/hypotheses/laws.hpp"

#include "solver/assembly/assembly.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace hvi::solver {
namespace {

constexpr int most_points = 200; ///< of a law that changes in space; the others lie between them
constexpr int most_times = 9;    ///< of a law that changes in time

std::vector<double> sample_times(const Plan& plan, const Law& law) {
  if (plan.time.is_static) return {0.0};
  const double t0 = plan.time.grid.front(), t1 = plan.time.grid.back();
  if (!law.depends_on_t()) return {t0};
  std::vector<double> out;
  for (int k = 0; k < most_times; ++k) out.push_back(t0 + (t1 - t0) * k / (most_times - 1));
  return out;
}

void take(const LawConstants& here, bool everywhere, TermConstants& out) {
  const auto known = [&](double value) {
    return here.exact && everywhere ? Bracket::exactly(value) : Bracket::at_least(value);
  };
  if (here.m > out.m.low) out.at = here.worst_at;
  out.m = larger(out.m, known(here.m));
  out.c = larger(out.c, known(here.c));
  out.regular = out.regular && (here.clarke_regular || std::isfinite(here.m));
}

SparseMatrix trace_form(const Plan& plan, const Discretisation& d, const StateLayout& layout,
                        Trace trace) {
  std::set<int> parts;
  for (const auto& term : plan.law_terms)
    if (d.parts[term.part].kind == Group::Kind::facets) parts.insert(term.part);
  SparseMatrix sum(layout.n_unknowns, layout.n_unknowns);
  for (const int part : parts) {
    const auto rule =
        std::find_if(plan.law_terms.begin(), plan.law_terms.end(), [&](const LawTerm& t) {
          return t.part == part;
        })->rule;
    const SparseMatrix full = boundary_mass(d.space, d.parts[part], rule, trace);
    sum = SparseMatrix(sum + restrict_rows(full, layout).leftCols(layout.n_unknowns));
  }
  return sum;
}

} // namespace

std::vector<TermConstants> law_constants(const Plan& plan, const Contact& contact) {
  std::vector<TermConstants> out;
  for (const auto& term : contact.terms) {
    const Law& law = *contact.laws[plan.law_terms[term.points.law_term].law];
    TermConstants here;
    here.term = term.points.law_term;
    here.radial = law.spec().radial;
    const int points = law.depends_on_x() ? term.n_points() : std::min(term.n_points(), 1);
    const int stride = std::max(1, points / most_points);
    const auto times = sample_times(plan, law);
    const bool everywhere = !law.depends_on_x() && times.size() == 1;
    for (int p = 0; p < points; p += stride)
      for (const double t : times) take(law.constants(term.points.x[p], t), everywhere, here);
    out.push_back(here);
  }
  return out;
}

TraceNorms trace_norms(const Plan& plan, const Discretisation& d, const StateLayout& layout,
                       const GramForm& gram) {
  const auto norm = [&](Trace trace) {
    return gram.largest(trace_form(plan, d, layout, trace)).value_or(std::nan(""));
  };
  if (d.space.components == 1) { // a scalar has one trace
    const double all = norm(Trace::full);
    return {all, 0.0, all};
  }
  return {norm(Trace::normal), norm(Trace::tangential), norm(Trace::full)};
}

} // namespace hvi::solver
