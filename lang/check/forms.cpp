#include "lang/check/forms.hpp"

#include "lang/check/loads.hpp"
#include "lang/diag/suggest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;
using solver::Group;
using solver::Rule;

void Forms::read(const ast::Find& find) {
  std::vector<std::pair<const ast::FormTerm*, bool>> sources; // wait until all laws are known
  const auto take = [&](const std::vector<ast::FormTerm>& terms, bool right) {
    for (const ast::FormTerm& term : terms) {
      at_hand_.source = false;
      form_term(term, right, false);
      if (at_hand_.source && !mistakes_.has_error_in(term.span)) sources.emplace_back(&term, right);
    }
  };
  take(find.left.terms, false);
  take(find.right.terms, true);
  const auto written = [](const std::vector<ast::FormTerm>& terms) {
    return std::ranges::count_if(terms,
                                 [](const ast::FormTerm& t) { return t.integral.has_value(); });
  };
  const auto all = static_cast<std::size_t>(written(find.left.terms) + written(find.right.terms));
  const bool unread =
      mistakes_.has_error_in(find.left.span) || mistakes_.has_error_in(find.right.span);
  model_.lacks_terms = unread || model_.terms.size() + sources.size() != all;
  for (const auto& [term, right] : sources) form_term(*term, right, true);
  model_.lacks_terms = unread || model_.terms.size() != all;
}

std::optional<Symbol> Forms::form_factors(const ast::FormTerm& term) {
  Symbol factor = term.minus ? -1.0 : 1.0;
  bool good = true;
  for (const ast::Expr& e : term.factors) {
    auto v = evaluator_.constant(e, "a factor before an integral");
    good = good && v;
    if (v) factor = factor * Symbol(*v);
  }
  return good ? std::optional(factor) : std::nullopt;
}

/// What an integrand may read.
Scope Forms::scope_of(std::optional<int> part, bool right, bool source) const {
  Scope out;
  out.what = right ? "a load" : "a form";
  out.position = out.time = out.unknown = out.test = true;
  out.source = source;
  out.load = right && !source;
  out.part = part.value_or(-1);
  const auto kind = part ? model_.parts[*part].kind : std::nullopt;
  out.normal = part && (!kind || *kind == Group::Kind::facets);
  if (part && !out.normal) out.what = "an integral over cells";
  out.states = source || (part && kind == Group::Kind::cells);
  return out;
}

/// `rule = ...`, where it is written.
void Forms::take_rule(const ast::Integral& integral, ModelTerm& term) {
  for (const ast::Setting& option : integral.options) {
    if (option.name.text != "rule") {
      mistakes_.error("E0304", option.name.span,
                      fmt::format("`integral` has no argument `{}`", option.name.text),
                      did_you_mean(option.name.text, std::vector<std::string>{"rule"}));
      continue;
    }
    if (term.rule_given)
      mistakes_.error("E0305", option.span, "argument `rule` of `integral` is given twice");
    term.rule_given = true;
    auto w = evaluator_.word(option.value, "rule", {"exact", "nodal", "midpoint", "gauss"});
    if (!w) continue;
    term.rule = *w == "nodal"      ? Rule::nodal
                : *w == "midpoint" ? Rule::midpoint
                : *w == "gauss"    ? Rule::gauss
                                   : Rule::exact;
  }
}

void Forms::form_term(const ast::FormTerm& term, bool right, bool source) {
  auto factor = form_factors(term);
  if (!term.integral) return;
  const ast::Integral& integral = *term.integral;
  auto part = parts_.index_of(integral.domain);
  Scope scope = scope_of(part, right, source);
  ModelTerm out;
  take_rule(integral, out);
  at_hand_.normal_missed = at_hand_.reads_stress = false;
  if (!part) scope.normal = true; // its kind is unknown: no second complaint about u.nu
  at_hand_.part = part.value_or(-1);
  at_hand_.gap = -1;
  auto integrand = evaluator_.field(integral.integrand, scope);
  at_hand_.part = -1;
  if (!factor || !part || !integrand) return;
  if (!pairs_.take_jumps(integral.integrand.span, integrand->components, *part)) return;
  if (!source && !integrand->scalar().is(0.0) &&
      pairs_.refuse(*part, integral.integrand.span, "a form or load"))
    return;
  out.span = integral.span;
  out.factor_span =
      term.factors.empty() ? (term.minus ? term.sign : integral.span) : term.factors.front().span;
  out.part = *part;
  out.right = right;
  out.factor = *factor;
  out.integrand = std::move(*integrand);
  if (source && (!check_integrand(out, term, true) || !sources_.take(out, integral.integrand.span)))
    return;
  if (!out.integrand.laws.empty() && !out.rule_given) out.rule = Rule::nodal;
  if (reads_solution(out)) {
    if (!check_integrand(out, term, true) || !check_load(out, integral.integrand.span)) return;
  } else if (!states_.take_time(out, integral.integrand.span) ||
             !check_integrand(out, term, at_hand_.reads_stress)) {
    return;
  }
  if (!states_.states_of_form(out, integral.integrand.span)) return;
  law_factors(out, term);
  model_.terms.push_back(std::move(out));
}

/// A load that is not linear in the solution is found at points of its own (StateTerm::algebraic).
bool Forms::check_load(ModelTerm& load, const Span& span) {
  load.integrand.materials.clear(); // it is no form
  const auto refuse = [&](const std::string& what, const char* help) {
    mistakes_.error("E0451", span, what, help);
    return false;
  };
  if (load.rule_given)
    return refuse("a load that reads the solution has points of its own",
                  "leave out `rule`: they are Gauss's, or one in each cell where all is constant "
                  "on it");
  for (const solver::Slot s : solver::slots_of(load.integrand.scalar()))
    if (slot::is_field(s) && slot::field_of(s) == solver::field_of_u(2))
      return refuse(fmt::format("a load reads `{}''`",
                                unknowns_.name_of(slot::unknown_of(slot::derivative_of(s)))),
                    "it reads unknowns, their rates, memories and the gradients of all of them");
  return true;
}

/// `source`: what is on the right may read the solution.
bool Forms::check_integrand(const ModelTerm& term, const ast::FormTerm& written, bool source) {
  const ast::Expr& e = written.integral->integrand;
  const Field& f = term.integrand;
  if (f.rank != 0) {
    mistakes_.error("E0306", e.span, fmt::format("an integrand is a scalar, not {}", describe(f)),
                    "contract it with the test function: `... : eps(v)` or `dot(..., v)`");
    return false;
  }
  if (f.scalar().is(0.0)) return true; // folds to zero: dropped, and the plan says so
  if (f.test == Degree::none) {
    mistakes_.error(
        "E0402", e.span,
        fmt::format("this does not contain the test function {}", unknowns_.names_of_tests()),
        "every integral of the inequality is linear in the test function");
    return false;
  }
  if (f.test != Degree::linear) {
    mistakes_.error("E0401", e.span,
                    fmt::format("this is not linear in {}", unknowns_.names_of_tests()));
    return false;
  }
  if (!source && term.right && f.trial != Degree::none) {
    mistakes_.error("E0403", e.span,
                    fmt::format("the right side contains the unknown {}", unknowns_.names()),
                    "bring the term to the left side");
    return false;
  }
  if (!find_->time && f.scalar().depends_on(slot::t)) {
    mistakes_.error("E0412", e.span, "a static problem has no time `t`",
                    "add `for t in [0, T] by N steps from u = 0` to the find statement");
    return false;
  }
  return true;
}

void Forms::law_factors(ModelTerm& term, const ast::FormTerm&) {
  for (LawUse& use : term.integrand.laws) {
    if (use.sees_gradient() && term.rule_given && term.rule == Rule::nodal)
      mistakes_.error("E0414", use.span,
                      fmt::format("`{}` sees a gradient, which has no value at nodes", use.name),
                      "leave out `rule`: its points lie inside the cells");
    if (term.right) {
      mistakes_.error("E0410", use.span, "a superpotential stands on the left of >=",
                      "bring it to the left; its sign there is +");
      continue;
    }
    const Symbol factor = term.factor * use.factor;
    const Span place = use.factor_span.valid() ? use.factor_span : term.factor_span;
    if (factor.depends_on(slot::gap)) {
      mistakes_.error("E0441", place, fmt::format("a gap in the factor before `{}^0`", use.name),
                      "it stands in the argument of a law");
      use.factor = 1.0;
      continue;
    }
    if (factor.depends_on_any(slot::first_state, slot::first_probe)) {
      mistakes_.error("E0309", place,
                      fmt::format("a state stands in the factor before `{}^0`", use.name),
                      "let the superpotential itself depend on it");
      use.factor = 1.0;
      continue;
    }
    if (factor.depends_on_any(slot::first_field, slot::first_multiplier)) {
      mistakes_.error("E0403", place,
                      fmt::format("the factor before `{}^0` depends on the unknown {}", use.name,
                                  unknowns_.names()),
                      "what depends on the unknown stands in the superpotential itself");
      use.factor = 1.0; // no second complaint on the mesh
      continue;
    }
    if (factor.is_constant() && !(factor.value() > 0.0)) {
      if (factor.value() == 0.0) continue; // dropped: the effect folds to zero
      mistakes_.error("E0409", place, fmt::format("a negative factor before `{}^0`", use.name),
                      "j^0 is a directional derivative: -j^0 is not one. Change the sign in the "
                      "superpotential");
      continue;
    }
    if (factor.depends_on(slot::t))
      mistakes_.error("E0413", place,
                      fmt::format("the factor before `{}^0` depends on time", use.name),
                      "let the superpotential itself depend on t");
  }
}

} // namespace hvi::lang
