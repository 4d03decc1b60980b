#include "lang/check/stress.hpp"

#include "lang/check/across.hpp"
#include "lang/syntax/tree_names.hpp"
#include "solver/kernel/algebra.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string>
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

/// Names that reports and rates of states read, and where the first `sigma` of them stands.
struct NamesOfResults {
  std::set<std::string> all;
  std::optional<Span> stress;
  bool stress_in_rate = false;
};

NamesOfResults names_of_results(const ast::Program& script) {
  NamesOfResults out;
  for (const ast::Statement& statement : script.statements) {
    const bool rate = std::holds_alternative<ast::State>(statement);
    if (!rate && !std::holds_alternative<ast::Report>(statement)) continue;
    NameVisitor visitor;
    visitor.use = [&](const std::string& name, const Span& span) {
      out.all.insert(name);
      if (name == "sigma" && span.valid() && !out.stress) // a page asks for it without a place
        out.stress = span, out.stress_in_rate = rate;
    };
    visitor.column = [](const std::string&, const Span&) {};
    visitor.argument = [](const std::string&, const ast::Name&) {};
    visit_names(statement, visitor);
  }
  return out;
}

} // namespace

void tell_stress_of_laws(const ast::Program& script, const Model& model, const Unknowns& unknowns,
                         Mistakes& mistakes) {
  const NamesOfResults names = names_of_results(script);
  if (!names.stress) return;
  for (const ModelTerm& term : model.terms)
    for (const LawUse& use : term.integrand.laws) {
      if (!use.sees_gradient() || use.unknown != unknowns.first_vector() ||
          names.all.contains(use.name))
        continue;
      mistakes.add(
          diagnose("W0111", *names.stress,
                   fmt::format("`sigma` is without the stress that the law `{}` adds", use.name))
              .with_secondary(use.span, "it acts inside the body")
              .with_help(names.stress_in_rate
                             ? fmt::format("it is the stress of the forms; `{}.xi` is not known in "
                                           "the rate of a body's state",
                                           use.name)
                             : fmt::format("that is `{0}.xi`, of the shape of the law's argument: "
                                           "where that is eps({1}), `sigma + {0}.xi` is the whole",
                                           use.name, unknowns.name_of(use.unknown))));
      return;
    }
}

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
