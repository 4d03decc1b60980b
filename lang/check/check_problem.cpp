// The find statement: the inequality itself, term by term.
#include "lang/check/builtins.hpp"
#include "lang/check/checker.hpp"
#include "lang/diag/suggest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;
using solver::Group;
using solver::Rule;

namespace {

/// Whether d2 f / d w_k d v_l = d2 f / d w_l d v_k for the values and gradients w of a field, w and
/// v of one unknown.
bool symmetric_in(const Symbol& f, int field, int unknown) {
  constexpr int n = slot::own_derivatives;
  std::vector<std::pair<int, Symbol>> rows; // of test slots that occur
  for (int l = 0; l < n; ++l)
    if (const auto s = slot::test(slot::of_unknown(unknown, l)); f.depends_on(s))
      rows.emplace_back(l, derivative(f, s));
  std::array<std::array<std::optional<Symbol>, n>, n> hessian; // zero unless set
  for (const auto& [l, row] : rows)
    for (int k = 0; k < n; ++k)
      if (const auto s = slot::field(field, slot::of_unknown(unknown, k)); row.depends_on(s))
        hessian[l][k] = derivative(row, s);
  auto entry = [&](int l, int k, int trial) {
    const auto& d = hessian[l][k];
    if (!d || d->is_constant()) return d ? d->value() : 0.0;
    return evaluate(*d, [&](solver::Slot s) { return 0.31 + 0.17 * trial + 0.05 * (s % 7); });
  };
  for (int trial = 0; trial < 2; ++trial)
    for (int l = 0; l < n; ++l)
      for (int k = 0; k < l; ++k) {
        const double a = entry(l, k, trial), b = entry(k, l, trial);
        if (std::abs(a - b) > 1e-9 * (std::abs(a) + std::abs(b))) return false;
      }
  return true;
}

/// Of each unknown by itself: coupled ones may act on each other as they like.
bool symmetric(const Symbol& f, int field) {
  for (int b = 0; b < slot::most_unknowns; ++b)
    if (!symmetric_in(f, field, b)) return false;
  return true;
}

} // namespace

Checker::Checker(const std::vector<ast::Program>& programs, const CheckOptions& options,
                 Diagnostics& diagnostics)
    : programs_(programs), options_(options), diagnostics_(diagnostics) {
  // A script evaluates about one expression for three of its characters; a hundred times that is
  // enough for any use of functions, and soon reached by functions that double at each call.
  std::size_t size = 0;
  for (const ast::Program& program : programs_) size += program.size;
  most_evaluations_ = static_cast<long>(std::min<std::size_t>(20'000 + 30 * size, 1'000'000));
}

std::optional<Model> Checker::run() {
  collect_declarations();
  check_defines();
  locate_find();
  locate_pieces();
  if (find_) find_statement();
  // Unused declarations are checked, too: a wrong line is an error even when nothing uses it.
  for (std::size_t i = 0; i < declarations_.size(); ++i) {
    Declaration& d = declarations_[i];
    const bool used = d.used;
    const bool other_mesh = std::holds_alternative<ast::Mesh>(*d.statement) && find_;
    if (d.state == Declaration::State::untouched && !other_mesh && d.program == 0)
      value_of(static_cast<int>(i), d.span);
    if (std::holds_alternative<ast::Superpotential>(*d.statement) && d.program == 0)
      check_law_alone(static_cast<int>(i));
    if (std::holds_alternative<ast::Kernel>(*d.statement) && d.program == 0 && !used) {
      Scope scope;
      ast::Expr callee;
      callee.span = d.span;
      callee.node = ast::Reference{d.name};
      kernel_field(callee, scope);
    }
    declarations_[i].used = used;
  }
  if (find_ && readable_) {
    reports();
    plots();
    expectations();
    study();
  }
  if (!diagnostics_.has_errors()) check_locking();
  if (!diagnostics_.has_errors()) check_unused();
  if (options_.on_name) tell_facts();
  if (diagnostics_.has_errors() || !find_) return std::nullopt;
  // They were evaluated when something asked for them.
  std::ranges::sort(model_.params, {},
                    [](const ModelParam& p) { return std::pair(p.span.file, p.span.begin); });
  return std::move(model_);
}

void Checker::locate_find() {
  for (const ast::Program& program : programs_)
    for (const ast::Statement& statement : program.statements) {
      const auto* find = std::get_if<ast::Find>(&statement);
      if (!find) continue;
      if (&program != &programs_[0]) {
        error("E0405", find->keyword, "an imported file declares; it cannot have a find statement");
        continue;
      }
      if (find_) {
        diagnostics_.add(diagnose("E0405", find->keyword, "a script has one find statement")
                             .with_secondary(find_->keyword, "the first one"));
        continue;
      }
      find_ = find;
    }
  if (!find_ && !programs_.empty() && !diagnostics_.has_errors())
    error("E0404", Span{programs_[0].file, 0, 0}, "the script has no find statement",
          "state the inequality: `find u in V ... such that for all v in V ... >= ...`");
}

void Checker::find_statement() {
  const ast::Find& find = *find_;
  unknowns(find);
  // Whose names are not clear cannot be read: one mistake, not one for each use.
  readable_ = check_find_names(find);
  for (const ast::Unknown& u : find.unknowns) {
    model_.unknowns.push_back(u.unknown.text);
    model_.tests.push_back(u.test.text);
  }
  if (!readable_) return;
  time_clause(find);
  if (spaces_known_) imposed_values(find);
  forms(find);
  states();
  place_materials();
  settings(find);
  check_tables();
  check_kernels_in_time();
  check_relation(find);
  if (!diagnostics_.has_errors()) {
    check_clauses(find);
    check_one_law_per_part();
    check_states_of_laws();
    check_symmetry();
  }
}

void Checker::forms(const ast::Find& find) {
  std::vector<std::pair<const ast::FormTerm*, bool>> sources; // wait until all laws are known
  const auto take = [&](const std::vector<ast::FormTerm>& terms, bool right) {
    for (const ast::FormTerm& term : terms) {
      reads_multiplier_ = false;
      form_term(term, right, false);
      if (reads_multiplier_) sources.emplace_back(&term, right);
    }
  };
  take(find.left.terms, false);
  take(find.right.terms, true);
  for (const auto& [term, right] : sources) form_term(*term, right, true);
}

std::optional<Symbol> Checker::form_factors(const ast::FormTerm& term) {
  Symbol factor = term.minus ? -1.0 : 1.0;
  bool good = true;
  for (const ast::Expr& e : term.factors) {
    auto v = constant(e, "a factor before an integral");
    good = good && v;
    if (v) factor = factor * Symbol(*v);
  }
  return good ? std::optional(factor) : std::nullopt;
}

void Checker::form_term(const ast::FormTerm& term, bool right, bool source) {
  auto factor = form_factors(term);
  if (!term.integral) return;
  const ast::Integral& integral = *term.integral;
  auto part = part_index(integral.domain);
  Scope scope;
  scope.what = right ? "a load" : "a form";
  scope.position = scope.time = scope.unknown = scope.test = true;
  scope.source = source;
  const auto kind = part ? model_.parts[*part].kind : std::nullopt;
  scope.normal = part && (!kind || *kind == Group::Kind::facets);
  if (part && !scope.normal) scope.what = "an integral over cells";
  scope.states = source || (!right && part && model_.parts[*part].kind == Group::Kind::cells);
  ModelTerm out;
  for (const ast::Setting& option : integral.options) {
    if (option.name.text != "rule") {
      error("E0304", option.name.span,
            fmt::format("`integral` has no argument `{}`", option.name.text),
            did_you_mean(option.name.text, std::vector<std::string>{"rule"}));
      continue;
    }
    auto w = word(option.value, "rule", {"exact", "nodal", "midpoint", "gauss"});
    if (!w) continue;
    out.rule_given = true;
    out.rule = *w == "nodal"      ? Rule::nodal
               : *w == "midpoint" ? Rule::midpoint
               : *w == "gauss"    ? Rule::gauss
                                  : Rule::exact;
  }
  normal_missed_ = false;
  if (!part) scope.normal = true; // its kind is unknown: no second complaint about u.nu
  part_at_hand_ = part.value_or(-1);
  gap_part_ = -1;
  auto integrand = field(integral.integrand, scope);
  part_at_hand_ = -1;
  if (!factor || !part || !integrand) return;
  if (!take_jumps(integral.integrand.span, integrand->components, *part)) return;
  if (!source && !integrand->scalar().is(0.0) &&
      refuse_pair(*part, integral.integrand.span, "a form or load"))
    return;
  out.span = integral.span;
  out.factor_span =
      term.factors.empty() ? (term.minus ? term.sign : integral.span) : term.factors.front().span;
  out.part = *part;
  out.right = right;
  out.factor = *factor;
  out.integrand = std::move(*integrand);
  if (source && (!check_integrand(out, term, true) || !take_source(out, integral.integrand.span)))
    return;
  if (!out.integrand.laws.empty() && !out.rule_given) out.rule = Rule::nodal;
  if (!take_time(out, integral.integrand.span) || !check_integrand(out, term, false) ||
      !states_of_form(out, integral.integrand.span))
    return;
  law_factors(out, term);
  model_.terms.push_back(std::move(out));
}

bool Checker::check_integrand(const ModelTerm& term, const ast::FormTerm& written, bool source) {
  const ast::Expr& e = written.integral->integrand;
  const Field& f = term.integrand;
  if (f.rank != 0) {
    error("E0306", e.span, fmt::format("an integrand is a scalar, not {}", describe(f)),
          "contract it with the test function: `... : eps(v)` or `dot(..., v)`");
    return false;
  }
  if (f.scalar().is(0.0)) return true; // folds to zero: dropped, and the plan says so
  if (f.test == Degree::none) {
    error("E0402", e.span,
          fmt::format("this does not contain the test function {}", names_of_tests()),
          "every integral of the inequality is linear in the test function");
    return false;
  }
  if (f.test != Degree::linear) {
    error("E0401", e.span, fmt::format("this is not linear in {}", names_of_tests()));
    return false;
  }
  if (!source && term.right && f.trial != Degree::none) {
    error("E0403", e.span,
          fmt::format("the right side contains the unknown {}", names_of_unknowns()),
          "bring the term to the left of >=");
    return false;
  }
  if (!find_->time && f.scalar().depends_on(slot::t)) {
    error("E0412", e.span, "a static problem has no time `t`",
          "add `for t in [0, T] by N steps from u = 0` to the find statement");
    return false;
  }
  return true;
}

void Checker::law_factors(ModelTerm& term, const ast::FormTerm&) {
  for (LawUse& use : term.integrand.laws) {
    if (term.right) {
      error("E0410", use.span, "a superpotential stands on the left of >=",
            "bring it to the left; its sign there is +");
      continue;
    }
    const Symbol factor = term.factor * use.factor;
    const Span place = use.factor_span.valid() ? use.factor_span : term.factor_span;
    if (factor.depends_on(slot::gap)) {
      error("E0441", place, fmt::format("a gap in the factor before `{}^0`", use.name),
            "it stands in the argument of a law");
      use.factor = 1.0;
      continue;
    }
    if (factor.depends_on_any(slot::first_state, slot::first_probe)) {
      error("E0309", place, fmt::format("a state stands in the factor before `{}^0`", use.name),
            "let the superpotential itself depend on it");
      use.factor = 1.0;
      continue;
    }
    if (factor.depends_on_any(slot::first_field, slot::first_multiplier)) {
      error("E0403", place,
            fmt::format("the factor before `{}^0` depends on the unknown {}", use.name,
                        names_of_unknowns()),
            "what depends on the unknown stands in the superpotential itself");
      use.factor = 1.0; // no second complaint on the mesh
      continue;
    }
    if (factor.is_constant() && !(factor.value() > 0.0)) {
      if (factor.value() == 0.0) continue; // dropped: the effect folds to zero
      error("E0409", place, fmt::format("a negative factor before `{}^0`", use.name),
            "j^0 is a directional derivative: -j^0 is not one. Change the sign in the "
            "superpotential");
      continue;
    }
    if (factor.depends_on(slot::t))
      error("E0413", place, fmt::format("the factor before `{}^0` depends on time", use.name),
            "let the superpotential itself depend on t");
  }
}

void Checker::check_relation(const ast::Find& find) {
  const bool has_law = std::any_of(model_.terms.begin(), model_.terms.end(),
                                   [](const ModelTerm& t) { return !t.integrand.laws.empty(); });
  if (!find.inequality && has_law)
    error("E0411", find.relation, "with a superpotential the statement is an inequality",
          "write `>=` in place of `=`");
  if (find.inequality && !has_law && !diagnostics_.has_errors())
    diagnostics_.add(diagnose("W0102", find.relation, "no superpotential: this is an equation")
                         .with_help("`=` says it; `>=` for all v and -v means the same"));
}

/// W0103 where the forms on one part, summed for u and for u', are not symmetric: compared at a few
/// places and values by their second derivatives, a(w, v) against a(v, w).
void Checker::check_symmetry() {
  for (const int which : {solver::field_of_u(0), solver::field_of_u(1), solver::field_of_u(2)}) {
    std::map<int, std::pair<Symbol, Span>> sums;
    std::set<int> culprits;
    for (const ModelTerm& term : model_.terms) {
      if (term.right || term.integrand.trial == Degree::none) continue;
      auto [sum, fresh] = sums.try_emplace(term.part, Symbol(0.0), term.span);
      sum->second.first = sum->second.first + term.factor * term.integrand.scalar();
      // The first term that is not symmetric by itself is the one to look at.
      if (!symmetric(term.integrand.scalar(), which) && culprits.insert(term.part).second)
        sum->second.second = term.span;
    }
    for (const auto& [part, sum] : sums)
      if (culprits.contains(part) && !symmetric(sum.first, which)) {
        diagnostics_.add(
            diagnose("W0103", sum.second,
                     fmt::format("the form in `{}{}` on `{}` is not symmetric", name_of(0),
                                 std::string(static_cast<std::size_t>(which), '\''),
                                 model_.parts[part].name))
                .with_note(which == solver::field_of_u(1)
                               ? "H(A) asks for a symmetric A: the theorem does not apply; the "
                                 "systems are solved by LU in place of Cholesky"
                               : "the systems are solved by LU in place of Cholesky: about twice "
                                 "the time; the theory needs the coercivity only")
                .with_help("if this was not meant, look for a matrix that is not its transpose"));
        return;
      }
  }
}

void Checker::check_one_law_per_part() {
  std::map<std::pair<int, int>, Span> seen;
  for (const ModelTerm& term : model_.terms)
    for (const LawUse& use : term.integrand.laws) {
      auto [found, fresh] = seen.emplace(std::pair(use.law, term.part), use.span);
      if (fresh) continue;
      diagnostics_.add(
          diagnose("E0420", use.span,
                   fmt::format("the law `{}` stands twice on `{}`", use.name,
                               model_.parts[term.part].name))
              .with_secondary(found->second, "first here")
              .with_help("one law on one part; a factor before the integral doubles it"));
    }
}

std::optional<Model> check(const std::vector<ast::Program>& programs, const CheckOptions& options,
                           Diagnostics& diagnostics) {
  return Checker(programs, options, diagnostics).run();
}

} // namespace hvi::lang
