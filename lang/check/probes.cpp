#include "lang/check/probes.hpp"

#include <fmt/format.h>

#include <limits>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;
using solver::Group;
using solver::Probe;

bool has_probes(const Symbol& value) {
  return value.depends_on_any(slot::first_probe, std::numeric_limits<solver::Slot>::max());
}

std::optional<int> Probes::reported_part(const ast::Expr& e, const std::string& what) {
  const auto* name = std::get_if<ast::Reference>(&e.node);
  if (name) return parts_.index_of({name->name, e.span});
  mistakes_.error("E0306", e.span, fmt::format("{} is over a part, by its name", what),
                  "the part comes first; `part p = ...` declares one");
  return std::nullopt;
}

/// A probe of an expression on a part, its kind still open.
std::optional<Probe> Probes::probe_on_part(const ast::Expr& e, const std::string& what,
                                           const ast::Expr& on, const ast::Expr& of,
                                           const Scope& scope) {
  const auto part = reported_part(on, what);
  if (!part && !std::holds_alternative<ast::Reference>(on.node)) return std::nullopt;
  Scope inner = scope;
  inner.part = part.value_or(-1);
  const auto kind = part ? model_.parts[*part].kind : std::nullopt;
  inner.normal = kind.value_or(Group::Kind::facets) == Group::Kind::facets;
  at_hand_.gap = -1;
  auto value = evaluator_.scalar(of, inner);
  if (!part || !value || !pairs_.take_jumps(of.span, value->components, *part)) return std::nullopt;
  if (has_probes(value->scalar())) {
    mistakes_.error("E0306", of.span,
                    fmt::format("{} is of what has a value at every point: an integral, an extreme "
                                "and a reaction are one number",
                                what),
                    "a number stands in front: `reaction(wall).x * integral(body, y)`");
    return std::nullopt;
  }
  Probe out;
  out.origin = model_.origin(e.span);
  out.part = *part;
  out.expression = value->scalar();
  if (!states_.reads_states_of(e.span, states_.without_states_of_bodies(out.expression, *part),
                               *part, what))
    return std::nullopt;
  return out;
}

/// The value of a probe as a number of the report.
Value Probes::number_of(Probe p) {
  Field out = scalar_field(Symbol::variable(slot::probe(add(std::move(p)))));
  out.trial = Degree::nonlinear;
  return out;
}

Value Probes::integral_call(const ast::Expr& e, const ast::Call& c, const Scope& scope) {
  if (!scope.report) {
    mistakes_.error("E0306", e.span, "an integral stands in the inequality or in a report");
    return Poison{};
  }
  auto args = evaluator_.match(e, c, "integral", {"part", "of", "rule"}, 2);
  if (!args) return Poison{};
  auto p = probe_on_part(e, "an integral", *(*args)[0], *(*args)[1], scope);
  if (!p) return Poison{};
  p->kind = Probe::Kind::integral;
  if ((*args)[2]) {
    auto w = evaluator_.word(*(*args)[2], "rule", {"exact", "nodal", "midpoint", "gauss"});
    if (!w) return Poison{};
    if (*w != "nodal" && pairs_.refuse(p->part, (*args)[2]->span, "a rule of its own"))
      return Poison{};
    p->rule = *w == "nodal"      ? solver::Rule::nodal
              : *w == "midpoint" ? solver::Rule::midpoint
              : *w == "gauss"    ? solver::Rule::gauss
                                 : solver::Rule::exact;
  }
  return number_of(std::move(*p));
}

Value Probes::extreme_call(const ast::Expr& e, const ast::Call& c, const std::string& name,
                           const Scope& scope) {
  if (!scope.report) {
    mistakes_.error("E0309", e.span,
                    fmt::format("`{}` stands in a report, not in {}", name, scope.what));
    return Poison{};
  }
  auto args = evaluator_.match(e, c, name, {"part", "of"}, 2);
  if (!args) return Poison{};
  auto p = probe_on_part(e, "an extreme", *(*args)[0], *(*args)[1], scope);
  if (!p) return Poison{};
  p->kind = name == "largest" ? Probe::Kind::largest : Probe::Kind::smallest;
  return number_of(std::move(*p));
}

/// Which unknown an argument names.
std::optional<int> Probes::unknown_given(const ast::Expr& e, const std::string& what) {
  const auto* name = std::get_if<ast::Reference>(&e.node);
  const int found = name ? unknowns_.named(name->name) : -1;
  if (found >= 0) return found;
  if (name && names_.is_silent(name->name)) return std::nullopt;
  mistakes_.error("E0306", e.span, fmt::format("{} is of an unknown, by its name", what),
                  fmt::format("the unknowns: {}", unknowns_.names()));
  return std::nullopt;
}

Value Probes::reaction_call(const ast::Expr& e, const ast::Call& c, const Scope& scope) {
  if (!scope.report) {
    mistakes_.error("E0309", e.span,
                    fmt::format("`reaction` stands in a report, not in {}", scope.what));
    return Poison{};
  }
  auto args = evaluator_.match(e, c, "reaction", {"part", "of"}, 1);
  if (!args) return Poison{};
  const auto part = reported_part(*(*args)[0], "a reaction");
  const auto unknown =
      (*args)[1] ? unknown_given(*(*args)[1], "a reaction") : unknowns_.first_vector();
  if (!part || !unknown) return Poison{};
  Probe p;
  p.origin = model_.origin(e.span);
  p.kind = Probe::Kind::reaction;
  p.part = *part;
  p.unknown = *unknown;
  std::vector<Symbol> components;
  for (p.component = 0; p.component < unknowns_.components_of(*unknown); ++p.component)
    components.push_back(Symbol::variable(slot::probe(add(p))));
  const bool vector = unknowns_of(model_.space)[static_cast<std::size_t>(*unknown)].vector;
  Field out = vector ? vector_field(components) : scalar_field(components.front());
  out.trial = Degree::nonlinear;
  return out;
}

int Probes::add(Probe p) {
  model_.report.probes.push_back(std::move(p));
  return static_cast<int>(model_.report.probes.size()) - 1;
}

} // namespace hvi::lang
