#include "lang/check/stress.hpp"

#include "lang/check/across.hpp"
#include "solver/kernel/algebra.hpp"

#include <utility>
#include <vector>

namespace hvi::lang {

namespace slot = solver::slot;
using solver::Group;

namespace {

/// With t in the place of states that are t: a report knows the time everywhere.
void put_time(const Model& model, Field& out) {
  std::vector<std::pair<solver::Slot, Symbol>> times;
  for (std::size_t i = 0; i < model.states.size(); ++i)
    if (model.states[i].declaration < 0)
      times.emplace_back(slot::state(static_cast<int>(i)), Symbol::variable(slot::t));
  if (times.empty()) return;
  for (auto* all : {&out.components, &out.across})
    for (Symbol& entry : *all) entry = substitute(entry, times);
}

} // namespace

Field stress(const Model& model, const Unknowns& unknowns) {
  const int unknown = unknowns.first_vector();
  const bool vector = unknowns.is_vector(unknown);
  const int d = unknowns.components_of(unknown);
  const auto of = [&](int derivative) { return slot::test(slot::of_unknown(unknown, derivative)); };
  Field out = matrix_field(d, model.dim, std::vector<Symbol>(d * model.dim, Symbol(0.0)));
  if (vector && d == 2 && !model.mesh.axisymmetric) out.across = {Symbol(0.0)};
  const bool ring = model.mesh.axisymmetric && vector;
  Symbol hoop = 0.0;
  for (const ModelTerm& term : model.terms) {
    if (term.right || model.parts[term.part].kind != Group::Kind::cells) continue;
    const bool whole = model.parts[term.part].region.kind == solver::RegionSpec::Kind::all_cells;
    const Symbol where = whole ? Symbol(1.0) : Symbol::variable(slot::inside(term.part));
    for (int i = 0; i < d; ++i)
      for (int j = 0; j < model.dim; ++j) {
        Symbol entry = derivative(term.integrand.scalar(), of(slot::gradient(i, j)));
        out.components[i * model.dim + j] =
            out.components[i * model.dim + j] + term.factor * where * entry;
      }
    const auto across = stress_across(term.integrand, unknown);
    if (across.empty()) out.across.clear();
    if (!out.across.empty()) out.across[0] = out.across[0] + term.factor * where * across[0];
    if (ring)
      hoop = hoop + term.factor * where * derivative(term.integrand.scalar(), of(slot::hoop));
  }
  if (ring) {
    const std::vector<Symbol> s = out.components;
    out = matrix_field(3, 3, {s[0], s[1], 0.0, s[2], s[3], 0.0, 0.0, 0.0, hoop});
  }
  if (!vector) {
    out.rank = 1;
    out.rows = model.dim;
    out.columns = 1;
  }
  out.trial = Degree::linear;
  put_time(model, out);
  return out;
}

} // namespace hvi::lang
