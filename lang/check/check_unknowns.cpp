// The unknowns of the find statement: their names, spaces and equations.
#include "lang/check/builtins.hpp"
#include "lang/check/checker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace hvi::lang {

namespace slot = solver::slot;

int Checker::unknown_named(const std::string& name) const {
  for (std::size_t b = 0; find_ && b < find_->unknowns.size(); ++b)
    if (find_->unknowns[b].unknown.text == name) return static_cast<int>(b);
  return -1;
}

int Checker::unknown_tested_by(const std::string& name) const {
  for (std::size_t b = 0; find_ && b < find_->unknowns.size(); ++b)
    if (find_->unknowns[b].test.text == name) return static_cast<int>(b);
  return -1;
}

namespace {

std::string either(const std::vector<ast::Unknown>& all, ast::Name ast::Unknown::*name) {
  std::string out;
  for (std::size_t b = 0; b < all.size(); ++b)
    out += fmt::format("{}`{}`",
                       b == 0               ? ""
                       : b + 1 < all.size() ? ", "
                                            : " or ",
                       (all[b].*name).text);
  return out;
}

} // namespace

std::string Checker::names_of_unknowns() const {
  return either(find_->unknowns, &ast::Unknown::unknown);
}
std::string Checker::names_of_tests() const { return either(find_->unknowns, &ast::Unknown::test); }
const std::string& Checker::name_of(int unknown) const {
  return find_->unknowns[static_cast<std::size_t>(unknown)].unknown.text;
}

/// Of the values of the b-th unknown.
int Checker::components_of(int unknown) const {
  return solver::components_of(unknowns_of(model_.space)[static_cast<std::size_t>(unknown)],
                               model_.dim);
}

bool Checker::check_find_names(const ast::Find& find) {
  bool good = true;
  std::map<std::string, const ast::Name*> seen;
  std::vector<const ast::Name*> names;
  for (const ast::Unknown& u : find.unknowns) names.push_back(&u.unknown);
  for (const ast::Unknown& u : find.unknowns) names.push_back(&u.test);
  if (find.unknowns.size() > solver::slot::most_unknowns) {
    error("E0443", find.unknowns[solver::slot::most_unknowns].unknown.span,
          fmt::format("more than {} unknowns", solver::slot::most_unknowns));
    return false;
  }
  for (const ast::Name* name : names) {
    if (const auto [before, fresh] = seen.try_emplace(name->text, name); !fresh) {
      diagnostics_.add(
          diagnose("E0302", name->span,
                   find.unknowns.size() == 1
                       ? std::string("the unknown and the test function have the same name")
                       : fmt::format("two of the unknowns and test functions are called `{}`",
                                     name->text))
              .with_secondary(before->second->span, "the first one"));
      good = false;
      continue;
    }
    if (is_reserved_builtin(name->text)) {
      error("E0311", name->span, fmt::format("`{}` is built in and cannot be declared", name->text),
            "choose another name");
      good = false;
      continue;
    }
    const int index = find_declaration(name->text);
    if (index < 0) continue;
    good = false;
    diagnostics_.add(
        diagnose("E0302", name->span, fmt::format("`{}` is declared twice", name->text))
            .with_secondary(declarations_[index].span, "first declared here"));
  }
  for (const ast::Unknown& u : find.unknowns)
    if (u.test_space.text != u.space.text)
      error("E0312", u.test_space.span,
            fmt::format("the test functions run through `{}`, the space of the unknown",
                        u.space.text));
  return good;
}

/// The space of the problem: that of the unknown, or the product of those of all.
void Checker::unknowns(const ast::Find& find) {
  spaces_known_ = true;
  solver::SpaceSpec product;
  for (std::size_t b = 0; b < find.unknowns.size(); ++b) {
    const ast::Unknown& written = find.unknowns[b];
    const int index = find_declaration(written.space.text);
    if (index < 0) {
      Scope none;
      unknown_name(written.space.span, written.space.text, none);
      spaces_known_ = false;
      continue;
    }
    Value value = value_of(index, written.space.span);
    const auto* space = std::get_if<SpaceValue>(&value);
    spaces_known_ = spaces_known_ && space != nullptr;
    if (space == nullptr) {
      if (!is_poison(value))
        error("E0306", written.space.span,
              fmt::format("a space is expected here, not {}", describe(value)));
      continue;
    }
    solver::SpaceSpec one = spaces_[static_cast<std::size_t>(space->index)];
    for (solver::DirichletSpec& d : one.dirichlet) d.unknown = static_cast<int>(b);
    for (solver::PeriodicSpec& p : one.periodic) p.unknown = static_cast<int>(b);
    one.unknown = written.unknown.text;
    if (b == 0) {
      product = std::move(one);
      continue;
    }
    product.more.push_back({one.unknown, one.name, one.origin, one.vector, one.order, one.domain});
    std::ranges::move(one.dirichlet, std::back_inserter(product.dirichlet));
    std::ranges::move(one.periodic, std::back_inserter(product.periodic));
  }
  if (spaces_known_) model_.space = std::move(product);
}

namespace {

/// By unknown: has a form it in it, or its test function; has a form or law its rate?
struct Occurrences {
  std::array<bool, slot::most_unknowns> acts{}, tested{}, rate{};

  void add(const ModelTerm& term) {
    if (term.integrand.laws.empty() && term.factor.is(0.0)) return;
    for (const LawUse& use : term.integrand.laws) {
      const auto b = static_cast<std::size_t>(use.unknown);
      rate[b] = rate[b] || use.field == solver::field_of_u(1);
    }
    for (const solver::Slot s : solver::slots_of(term.integrand.scalar())) {
      if (slot::is_test(s))
        tested[static_cast<std::size_t>(slot::unknown_of(s - slot::test(0)))] = true;
      if (!slot::is_field(s) || term.right) continue;
      const auto b = static_cast<std::size_t>(slot::unknown_of(slot::derivative_of(s)));
      acts[b] = true;
      rate[b] = rate[b] || solver::is_rate(slot::field_of(s));
    }
  }
};

bool has_initial_state(const ast::Find& find, const std::string& unknown) {
  return std::ranges::any_of(find.time->initial, [&](const ast::InitialValue& i) {
    return i.unknown.text == unknown && !i.rate;
  });
}

} // namespace

/// Has each unknown an equation, and what that asks for?
void Checker::check_clauses(const ast::Find& find) {
  Occurrences found;
  for (const ModelTerm& term : model_.terms) found.add(term);
  for (std::size_t b = 0; b < find.unknowns.size(); ++b) {
    const std::string& u = find.unknowns[b].unknown.text;
    const Span& place = find.unknowns.size() == 1 ? find.left.span : find.unknowns[b].unknown.span;
    if (!found.acts[b])
      error("E0425", place,
            fmt::format("no form acts on the unknown `{}`: nothing determines it", u),
            "add the elasticity: `integral(body, B : eps(u) : eps(v))`");
    else if (!found.tested[b])
      error("E0425", place,
            fmt::format("no form has the test function `{}`: the equation of `{}` is missing",
                        find.unknowns[b].test.text, u),
            "each unknown brings an equation, tested by its own test function");
    if (found.rate[b] && find.time && !has_initial_state(find, u))
      error("E0412", find.time->span,
            fmt::format("a problem with `{}'` needs the initial state", u),
            fmt::format("add `from {} = 0`", u));
  }
  if (find.unknowns.size() > 1) {
    of_one_unknown();
    pairs_of_elements(find);
  }
  if (!find.time || has_second_derivative()) return;
  for (const ast::InitialValue& initial : find.time->initial)
    if (initial.rate)
      error("E0431", initial.span,
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
void Checker::pairs_of_elements(const ast::Find& find) {
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
      error("E0446", find.unknowns[p].unknown.span,
            fmt::format("`{}` in P{} has no form of its own and sees the gradient of `{}` in P{}: "
                        "parts of it are seen by no `{}`",
                        all[p].name, all[p].order, all[u].name, all[u].order, all[u].name),
            fmt::format("take P2 for `{}` and P1 for `{}` (Taylor and Hood)", all[u].name,
                        all[p].name));
    }
}

/// What is known for one unknown alone.
void Checker::of_one_unknown() {
  const auto all = unknowns_of(model_.space);
  int highest = 1;
  for (const auto& u : all) highest = std::max(highest, u.order);
  const auto is_low = [&](int b) { return all[static_cast<std::size_t>(b)].order < highest; };
  const auto reads_low = [&](const Symbol& reading) {
    return std::ranges::any_of(solver::slots_of(reading), [&](solver::Slot s) {
      return slot::is_field(s) && is_low(slot::unknown_of(slot::derivative_of(s)));
    });
  };
  for (const ModelTerm& term : model_.terms)
    for (const LawUse& use : term.integrand.laws) {
      if (!is_pair(term.part)) continue;
      const auto& law = model_.laws[static_cast<std::size_t>(use.law)].spec;
      if (is_low(use.unknown) || std::ranges::any_of(law.readings, reads_low))
        error("E0445", use.span,
              "a law on a pair acts on an unknown in P1 beside others in P2, or reads one",
              "take one order for all of them");
    }
}

} // namespace hvi::lang
