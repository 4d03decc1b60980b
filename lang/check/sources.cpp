// Sources: linear forms on the part of a law that read its multiplier, as the heat of friction, or
// a state that lives at its points, as what leaks where a coating is worn,
//
//   - integral(ground, dot(slip.xi, u'.tau) * eta)
//   - integral(seam, dot(slip.xi, jump(u').tau) * mean(eta))
//   - integral(ground, leak(wear) * eta)
//
// What stands before a test function is the slope of a law of its unknown, j(s) = g s, that reads
// g at its points; so a step finds it with its solution, and the certificate sees it.
#include "lang/check/sources.hpp"

#include <fmt/format.h>

#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;

namespace {

bool reads_multiplier(const Symbol& integrand) {
  return integrand.depends_on_any(slot::first_multiplier, slot::first_inside);
}

} // namespace

/// The law j(s) = g s; nothing (reported) where g reads what no law can.
std::optional<int> Sources::source_law(const std::string& name, const Symbol& g, bool on_pair,
                                       const Span& span) {
  solver::LawSpec spec;
  spec.name = name;
  spec.origin = model_.origin(span);
  Symbol expression = g * Symbol::variable(slot::argument(0));
  const auto states = states_.take_states(expression, span);
  if (!states) return std::nullopt;
  spec.states = *states;
  if (!laws_.take_readings(name, span, expression, on_pair, spec)) return std::nullopt;
  return laws_.add({name, span, spec}, on_pair);
}

/// The rule of a source is that of the law it reads, of states one on their part, if none is given;
/// returns the unknown whose elements that is of.
int Sources::take_rule(ModelTerm& source, const Symbol& integrand) const {
  const bool states_alone = !reads_multiplier(integrand);
  int application = 0;
  for (const ModelTerm& term : model_.terms)
    for (const LawUse& use : term.integrand.laws) {
      const solver::Slot first = slot::multiplier(application++, 0);
      if (states_alone ? term.part != source.part
                       : !integrand.depends_on_any(first, first + slot::most_arguments))
        continue;
      if (!source.rule_given) source.rule = term.rule, source.rule_given = term.rule_given;
      return use.rule_of.value_or(use.unknown);
    }
  return 0;
}

bool Sources::take(ModelTerm& term, const Span& span) {
  Symbol integrand =
      (term.right ? Symbol(-1.0) : Symbol(1.0)) * term.factor * term.integrand.scalar();
  if (!term.integrand.laws.empty()) {
    if (reads_multiplier(integrand))
      mistakes_.error("E0447", span, "a law and what reads a multiplier stand in one integral",
                      "write two integrals");
    else
      mistakes_.error("E0309", span, "a law and a state beside it stand in one integral",
                      "let the superpotential itself depend on the state, or write two integrals");
    return false;
  }
  if (!multipliers_.take_on_part(span, term.part, integrand) ||
      !states_.reads_states_of(span, integrand, term.part, "the load"))
    return false;
  if (!term.right && !reads_multiplier(integrand) && term.integrand.trial != Degree::none) {
    mistakes_.error("E0309", span, "a form on a boundary reads a state",
                    "let a superpotential depend on it: `spring(r) = 0.5*wear*r^2`");
    return false;
  }
  const int rule_of = take_rule(term, integrand);
  const bool on_pair = pairs_.is_pair(term.part);
  Field out = scalar_field(0.0);
  out.test = Degree::linear;
  for (const solver::Slot s : solver::slots_of(integrand)) {
    if (!slot::is_test(s)) continue;
    const Symbol g = derivative(integrand, s);
    if (g.is(0.0)) continue;
    LawUse use;
    const int tested = s - slot::test(0), unknown = slot::unknown_of(tested);
    use.mean = on_pair && slot::may_be_mean(tested);
    if (!slot::is_value(tested) && !use.mean) {
      mistakes_.error(
          "E0447", span,
          fmt::format("a {} at the points of a law stands before a derivative of the test "
                      "function",
                      reads_multiplier(integrand) ? "multiplier" : "state"),
          "it acts on values: `slip.xi * eta`, `dot(slip.xi, v)`, `wear * eta`");
      return false;
    }
    use.name = fmt::format("source of {}", unknowns_.name_of(unknown));
    const auto law = source_law(use.name, g, on_pair, span);
    if (!law) return false;
    use.law = *law;
    use.span = span;
    use.field = solver::field_of_u(0);
    use.unknown = unknown;
    use.rule_of = rule_of;
    LawRow row;
    row.u[static_cast<std::size_t>(slot::component_of(tested))] = 1.0;
    row.offset = 0.0;
    use.rows.push_back(std::move(row));
    out.laws.push_back(std::move(use));
  }
  term.integrand = std::move(out);
  term.factor = 1.0;
  term.right = false;
  return true;
}

} // namespace hvi::lang
