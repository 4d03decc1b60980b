#include "lang/check/form_checks.hpp"

#include "lang/check/inertia.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;

namespace {

/// By unknown: has a form it in it, or its test function; has a form or law its rate?
struct Occurrences {
  std::array<bool, slot::most_unknowns> acts{}, tested{}, rate{};
  std::array<std::string, slot::most_unknowns> law{}; ///< one that sees its gradient

  void add(const ModelTerm& term) {
    if (term.integrand.laws.empty() && term.factor.is(0.0)) return;
    for (const LawUse& use : term.integrand.laws) {
      const auto b = static_cast<std::size_t>(use.unknown);
      rate[b] = rate[b] || use.field == solver::field_of_u(1);
      if (use.sees_gradient()) law[b] = use.name;
    }
    for (const solver::Slot s : solver::slots_of(term.integrand.scalar())) {
      if (slot::is_test(s))
        tested[static_cast<std::size_t>(slot::unknown_of(s - slot::test(0)))] = true;
      if (!slot::is_field(s)) continue;
      const auto b = static_cast<std::size_t>(slot::unknown_of(slot::derivative_of(s)));
      acts[b] = acts[b] || !term.right; // a load that reads the unknown does not determine it
      rate[b] = rate[b] || solver::is_rate(slot::field_of(s));
    }
  }
};

bool has_initial_state(const ast::Find& find, const std::string& unknown) {
  return std::ranges::any_of(find.time->initial, [&](const ast::InitialValue& i) {
    return i.unknown.text == unknown && !i.rate;
  });
}

/// What is mostly left out. A law of its gradient may determine the unknown, as a power law does:
/// the form that a matrix is made of is a part of it then.
std::string form_for(const ast::Unknown& u, bool vector, const std::string& law) {
  const std::string &of = u.unknown.text, &test = u.test.text;
  const std::string form = vector ? fmt::format("eps({}) : eps({})", of, test)
                                  : fmt::format("dot(grad({}), grad({}))", of, test);
  if (!law.empty())
    return fmt::format(
        "add a form; where `{}` alone is meant, `m*{}` in a form and `- m/2*norm(xi)^2` "
        "in the law leave it as it is, for any m > 0",
        law, form);
  return vector ? fmt::format("add the elasticity: `integral(body, B : {})`", form)
                : fmt::format("add a form: `integral(body, {})`", form);
}

} // namespace

void FormChecks::check_clauses(const ast::Find& find) {
  Occurrences found;
  for (const ModelTerm& term : model_.terms) found.add(term);
  const auto all = unknowns_of(model_.space);
  for (std::size_t b = 0; b < find.unknowns.size(); ++b) {
    const std::string& u = find.unknowns[b].unknown.text;
    const Span& place = find.unknowns.size() == 1 ? find.left.span : find.unknowns[b].unknown.span;
    if (!found.acts[b])
      mistakes_.error("E0425", place,
                      fmt::format("no form acts on the unknown `{}`: nothing determines it", u),
                      form_for(find.unknowns[b], all[b].vector, found.law[b]));
    else if (!found.tested[b])
      mistakes_.error(
          "E0425", place,
          fmt::format("no form has the test function `{}`: the equation of `{}` is missing",
                      find.unknowns[b].test.text, u),
          "each unknown brings an equation, tested by its own test function");
    if (found.rate[b] && find.time && !has_initial_state(find, u))
      mistakes_.error("E0412", find.time->span,
                      fmt::format("a problem with `{}'` needs the initial state", u),
                      fmt::format("add `from {} = 0`", u));
  }
  if (find.unknowns.size() > 1) pairs_of_elements(find);
  if (!find.time || has_second_derivative(model_)) return;
  for (const ast::InitialValue& initial : find.time->initial)
    if (initial.rate)
      mistakes_.error(
          "E0431", initial.span,
          fmt::format("an initial velocity, and no term with `{}''`", initial.unknown.text),
          "a velocity is given where a form has inertia: `integral(body, rho*dot(u'', v))`");
}

namespace {

/// Of a test function (row) and an unknown (column): what forms there are.
struct Couplings {
  std::array<std::array<bool, slot::most_unknowns>, slot::most_unknowns> any{}, slopes{};

  void add(const Symbol& integrand) {
    for (const solver::Slot v : solver::slots_of(integrand)) {
      if (!slot::is_test(v)) continue;
      const int test = v - slot::test(0);
      for (const solver::Slot w : solver::slots_of(derivative(integrand, v))) {
        if (!slot::is_field(w)) continue;
        const int trial = slot::derivative_of(w);
        const auto a = static_cast<std::size_t>(slot::unknown_of(test)),
                   b = static_cast<std::size_t>(slot::unknown_of(trial));
        any[a][b] = true;
        slopes[a][b] = slopes[a][b] || !slot::is_value(trial);
      }
    }
  }
};

} // namespace

/// E0446: a pressure, an unknown without a form of its own, needs an element of lower order than
/// the unknown whose divergence it sees: in equal orders some pressures are seen by no
/// displacement. (D. Boffi, F. Brezzi, M. Fortin, Mixed Finite Element Methods and Applications,
/// 2013.)
void FormChecks::pairs_of_elements(const ast::Find& find) {
  Couplings couplings;
  std::set<int> with_laws;
  for (const ModelTerm& term : model_.terms) {
    if (!term.right) couplings.add(term.integrand.scalar());
    for (const LawUse& use : term.integrand.laws) with_laws.insert(use.unknown);
  }
  const auto all = unknowns_of(model_.space);
  for (std::size_t p = 0; p < all.size(); ++p)
    for (std::size_t u = 0; u < all.size(); ++u) {
      const bool multiplier = !couplings.any[p][p] && !with_laws.contains(static_cast<int>(p));
      if (!multiplier || !couplings.slopes[p][u] || all[p].order < all[u].order) continue;
      mistakes_.error(
          "E0446", find.unknowns[p].unknown.span,
          fmt::format("`{}` in P{} has no form of its own and sees the gradient of `{}` in P{}: "
                      "parts of it are seen by no `{}`",
                      all[p].name, all[p].order, all[u].name, all[u].order, all[u].name),
          fmt::format("take P2 for `{}` and P1 for `{}` (Taylor and Hood)", all[u].name,
                      all[p].name));
    }
}

void FormChecks::check_relation(const ast::Find& find) {
  const bool has_law = std::any_of(model_.terms.begin(), model_.terms.end(),
                                   [](const ModelTerm& t) { return !t.integrand.laws.empty(); });
  if (!find.inequality && has_law)
    mistakes_.error("E0411", find.relation, "with a superpotential the statement is an inequality",
                    "write `>=` in place of `=`");
  if (find.inequality && !has_law && !mistakes_.has_errors())
    mistakes_.add(diagnose("W0102", find.relation, "no superpotential: this is an equation")
                      .with_help("`=` says it; `>=` for all v and -v means the same"));
}

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

void FormChecks::check_symmetry() {
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
        mistakes_.add(
            diagnose("W0103", sum.second,
                     fmt::format("the form in `{}{}` on `{}` is not symmetric",
                                 unknowns_.name_of(0),
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

void FormChecks::check_one_law_per_part() {
  std::map<std::pair<int, int>, Span> seen;
  for (const ModelTerm& term : model_.terms)
    for (const LawUse& use : term.integrand.laws) {
      auto [found, fresh] = seen.emplace(std::pair(use.law, term.part), use.span);
      if (fresh) continue;
      mistakes_.add(diagnose("E0420", use.span,
                             fmt::format("the law `{}` stands twice on `{}`", use.name,
                                         model_.parts[term.part].name))
                        .with_secondary(found->second, "first here")
                        .with_help("one law on one part; a factor before the integral doubles it"));
    }
}

void FormChecks::check_multipliers_read() {
  std::set<std::string> of_vectors, said;
  for (const ModelTerm& term : model_.terms)
    for (const LawUse& use : term.integrand.laws)
      if (model_.laws[static_cast<std::size_t>(use.law)].spec.radial) of_vectors.insert(use.name);
  for (const ModelLaw& law : model_.laws)
    if (of_vectors.contains(law.spec.coupled) && said.insert(law.name).second)
      mistakes_.error("E0432", law.reads_multiplier,
                      fmt::format("`{}` is a law of a vector: a law reads the multiplier of a "
                                  "scalar one",
                                  law.spec.coupled),
                      "take that of a law of `u.nu` or of another component");
}

} // namespace hvi::lang
