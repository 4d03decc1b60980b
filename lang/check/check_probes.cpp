// Numbers of a report that belong to parts: integrals, extremes, reactions. Used by
// check_calls.cpp.
#include "lang/check/builtins.hpp"
#include "lang/check/checker.hpp"
#include "lang/diag/suggest.hpp"

#include <fmt/format.h>

namespace hvi::lang {

namespace slot = solver::slot;
using solver::Group;
using solver::Probe;

std::optional<int> Checker::reported_part(const ast::Expr& e, const std::string& what) {
  const auto* name = std::get_if<ast::Reference>(&e.node);
  if (name) return part_index({name->name, e.span});
  error("E0306", e.span, fmt::format("{} is over a part, by its name", what));
  return std::nullopt;
}

/// The multiplier of a law on this very part: `layer.xi` meant the first one found by name.
void Checker::name_multipliers(int part, Symbol& expression) const {
  int application = 0;
  std::vector<std::pair<solver::Slot, Symbol>> rename;
  for (const ModelTerm& term : model_.terms)
    for (const LawUse& use : term.integrand.laws) {
      if (term.part == part) {
        int first = 0;
        for (const ModelTerm& other : model_.terms)
          for (const LawUse& earlier : other.integrand.laws) {
            if (earlier.name == use.name && first != application &&
                expression.depends_on_any(slot::multiplier(first, 0),
                                          slot::multiplier(first, slot::rows_of_multiplier)))
              for (int k = 0; k < 3; ++k)
                rename.emplace_back(slot::multiplier(first, k),
                                    Symbol::variable(slot::multiplier(application, k)));
            ++first;
          }
      }
      ++application;
    }
  expression = substitute(expression, rename);
}

/// A probe of an expression on a part, its kind still open.
std::optional<Probe> Checker::probe_on_part(const ast::Expr& e, const std::string& what,
                                            const ast::Expr& on, const ast::Expr& of,
                                            const Scope& scope) {
  const auto part = reported_part(on, what);
  Scope inner = scope;
  const auto kind = part ? model_.parts[*part].kind : std::nullopt;
  inner.normal = kind.value_or(Group::Kind::facets) == Group::Kind::facets;
  gap_part_ = -1;
  auto value = scalar(of, inner);
  if (!part || !value || !take_jumps(of.span, value->components, *part)) return std::nullopt;
  Probe out;
  out.origin = model_.origin(e.span);
  out.part = *part;
  out.expression = value->scalar();
  name_multipliers(*part, out.expression);
  if (!reads_states_of(e.span, without_states_known(out.expression, *part), *part, what))
    return std::nullopt;
  return out;
}

/// The value of a probe as a number of the report.
Value Checker::number_of(Probe p) {
  Field out = scalar_field(Symbol::variable(slot::probe(probe(std::move(p)))));
  out.trial = Degree::nonlinear;
  return out;
}

/// integral(part, expression) in a report.
Value Checker::integral_call(const ast::Expr& e, const ast::Call& c, const Scope& scope) {
  if (!scope.report) {
    error("E0306", e.span, "an integral stands in the inequality or in a report");
    return Poison{};
  }
  auto args = match(e, c, "integral", {"part", "of", "rule"}, 2);
  if (!args) return Poison{};
  auto p = probe_on_part(e, "an integral", *(*args)[0], *(*args)[1], scope);
  if (!p) return Poison{};
  p->kind = Probe::Kind::integral;
  if ((*args)[2]) {
    auto w = word(*(*args)[2], "rule", {"exact", "nodal", "midpoint", "gauss"});
    if (!w) return Poison{};
    if (*w != "nodal" && refuse_pair(p->part, (*args)[2]->span, "a rule of its own"))
      return Poison{};
    p->rule = *w == "nodal"      ? solver::Rule::nodal
              : *w == "midpoint" ? solver::Rule::midpoint
              : *w == "gauss"    ? solver::Rule::gauss
                                 : solver::Rule::exact;
  }
  return number_of(std::move(*p));
}

/// largest(part, expression), smallest(part, expression).
Value Checker::extreme_call(const ast::Expr& e, const ast::Call& c, const std::string& name,
                            const Scope& scope) {
  if (!scope.report) {
    error("E0309", e.span, fmt::format("`{}` stands in a report, not in {}", name, scope.what));
    return Poison{};
  }
  auto args = match(e, c, name, {"part", "of"}, 2);
  if (!args) return Poison{};
  auto p = probe_on_part(e, "an extreme", *(*args)[0], *(*args)[1], scope);
  if (!p) return Poison{};
  p->kind = name == "largest" ? Probe::Kind::largest : Probe::Kind::smallest;
  return number_of(std::move(*p));
}

/// Which unknown an argument names.
std::optional<int> Checker::unknown_given(const ast::Expr& e, const std::string& what) {
  const auto* name = std::get_if<ast::Reference>(&e.node);
  const int found = name ? unknown_named(name->name) : -1;
  if (found >= 0) return found;
  if (name && is_silent(name->name)) return std::nullopt;
  error("E0306", e.span, fmt::format("{} is of an unknown, by its name", what),
        fmt::format("the unknowns: {}", names_of_unknowns()));
  return std::nullopt;
}

/// reaction(part), reaction(part, theta): a probe for each component of the unknown.
Value Checker::reaction_call(const ast::Expr& e, const ast::Call& c, const Scope& scope) {
  if (!scope.report) {
    error("E0309", e.span, fmt::format("`reaction` stands in a report, not in {}", scope.what));
    return Poison{};
  }
  auto args = match(e, c, "reaction", {"part", "of"}, 1);
  if (!args) return Poison{};
  const auto part = reported_part(*(*args)[0], "a reaction");
  const auto unknown =
      (*args)[1] ? unknown_given(*(*args)[1], "a reaction") : first_vector_unknown();
  if (!part || !unknown) return Poison{};
  Probe p;
  p.origin = model_.origin(e.span);
  p.kind = Probe::Kind::reaction;
  p.part = *part;
  p.unknown = *unknown;
  std::vector<Symbol> components;
  for (p.component = 0; p.component < components_of(*unknown); ++p.component)
    components.push_back(Symbol::variable(slot::probe(probe(p))));
  const bool vector = unknowns_of(model_.space)[static_cast<std::size_t>(*unknown)].vector;
  Field out = vector ? vector_field(components) : scalar_field(components.front());
  out.trial = Degree::nonlinear;
  return out;
}

} // namespace hvi::lang
