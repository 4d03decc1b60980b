// j^0(at; direction) in the inequality: what it sees, its rows, and whether its law can stand
// there.
#include "lang/check/law_applications.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;

namespace {

bool offset_in_time(const std::vector<LawRow>& rows) {
  return std::any_of(rows.begin(), rows.end(),
                     [](const LawRow& row) { return row.offset.depends_on(slot::t); });
}

/// Equal as symbols, or at a few points that share no special value.
bool agree(const Symbol& a, const Symbol& b) {
  if (a == b) return true;
  for (int trial = 0; trial < 4; ++trial) {
    auto at = [&](solver::Slot s) { return std::sin(1.7 * s + 2.3 * trial + 0.4) + 0.1 * trial; };
    const double x = evaluate(a, at), y = evaluate(b, at);
    if (std::isnan(x) && std::isnan(y)) continue;
    if (!(std::abs(x - y) <= 1e-12 * (std::abs(x) + std::abs(y) + 1.0))) return false;
  }
  return true;
}

/// The c with a = c b at a few points that share no special value.
std::optional<double> ratio(const Symbol& a, const Symbol& b) {
  std::optional<double> out;
  for (int trial = 0; trial < 4; ++trial) {
    const auto at = [&](solver::Slot s) { return std::sin(1.7 * s + 2.3 * trial + 0.4); };
    const double x = evaluate(a, at), y = evaluate(b, at);
    if (x == 0.0 && y == 0.0) continue;
    const double c = x / y;
    if (!std::isfinite(c) || c == 0.0 || (out && std::abs(c - *out) > 1e-12 * std::abs(c)))
      return std::nullopt;
    if (!out) out = c;
  }
  return out;
}

/// A factor that an earlier row has up to rounding is that one: rows with the same sum are alike.
double as_before(const std::vector<std::vector<solver::SeenField>>& rows, int field, double times) {
  for (const auto& row : rows)
    for (const solver::SeenField& seen : row)
      if (seen.field == field && std::abs(seen.times - times) <= 1e-12 * std::abs(times))
        return seen.times;
  return times;
}

} // namespace

/// What the argument of a law is made of: u, u', memories, and inside a body their gradients;
/// nothing (reported) when there is anything else in it.
std::optional<std::set<int>> LawApplications::law_fields(const ast::Clarke& clarke,
                                                         const Field& at) {
  std::set<int> out;
  using Kind = solver::Group::Kind;
  const auto kind =
      at_hand_.part < 0 ? std::nullopt : model_.parts[static_cast<std::size_t>(at_hand_.part)].kind;
  const bool inside = kind.value_or(Kind::cells) == Kind::cells; // unknown: no second complaint
  for (const Symbol& component : at.components)
    for (const solver::Slot s : solver::slots_of(component)) {
      if (!slot::is_field(s)) continue;
      if (slot::is_field_gradient(s) && !inside) {
        mistakes_.error("E0414", clarke.at->span,
                        "M takes values of the unknown: its trace, a part of it or itself",
                        "write `u.nu`, `u.tau`, a component, `u` or `u.nu - gap`; laws see "
                        "gradients inside a body only");
        return std::nullopt;
      }
      out.insert(slot::field_of(s));
    }
  if (out.contains(solver::field_of_u(2))) {
    mistakes_.error("E0415", clarke.at->span,
                    fmt::format("a law does not act on `{}''`", unknowns_.name_of(0)),
                    "laws act on the unknown, its rate or a memory, or on a sum of them");
    return std::nullopt;
  }
  return out;
}

/// The unknown whose values a law sees, in the argument and in the direction.
std::optional<int> LawApplications::law_unknown(const ast::Clarke& clarke, const Field& at,
                                                const Field& direction) {
  std::set<int> seen, tested;
  for (const Symbol& component : at.components)
    for (const solver::Slot s : solver::slots_of(component))
      if (slot::is_field(s)) seen.insert(slot::unknown_of(slot::derivative_of(s)));
  for (const Symbol& component : direction.components)
    for (const solver::Slot s : solver::slots_of(component))
      if (slot::is_test(s)) tested.insert(slot::unknown_of(s - slot::test(0)));
  if (seen.size() > 1) {
    mistakes_.error("E0444", clarke.at->span, "the argument of a law has two unknowns in it",
                    "a law sees one of them; its superpotential may read others");
    return std::nullopt;
  }
  if (seen.empty() || tested == seen) return seen.empty() ? 0 : *seen.begin();
  const auto& mine = find_->unknowns[static_cast<std::size_t>(*seen.begin())];
  mistakes_.error(
      "E0444", clarke.direction->span,
      fmt::format("the argument is of `{}`, the direction not of its test function `{}`",
                  mine.unknown.text, mine.test.text),
      "j^0(Mu; Mv) takes the same M of an unknown and of its own test function");
  return std::nullopt;
}

/// Does something stand before a value of the unknown that makes a law's argument not linear in it
/// (reported)?
bool LawApplications::stands_before(const ast::Clarke& clarke, const Symbol& own, int field,
                                    int unknown) {
  for (int j = 0; j < slot::own_derivatives; ++j)
    if (own.depends_on(slot::field(field, slot::of_unknown(unknown, j)))) {
      mistakes_.error("E0403", clarke.at->span,
                      fmt::format("the argument of a law is linear in `{}{}`",
                                  unknowns_.name_of(unknown),
                                  field == solver::field_of_u(1) ? "'" : ""));
      return true;
    }
  if (!own.depends_on_any(slot::first_state, slot::first_probe)) return false;
  mistakes_.error("E0403", clarke.at->span,
                  "a state stands before the unknown in the argument of a law",
                  "the superpotential itself may depend on it");
  return true;
}

/// The same where several fields are seen: each row is M of a sum of them, c_0 u + c_1 u' + ...,
/// with constants, and M is that of the direction.
bool LawApplications::law_rows_of_sums(const ast::Clarke& clarke, const Field& at,
                                       const Field& direction, const std::set<int>& fields,
                                       LawUse& use) {
  const auto own_slot = [&](int i) { return slot::of_unknown(use.unknown, i); };
  std::vector<std::pair<solver::Slot, Symbol>> at_rest;
  for (const int field : fields)
    for (int k = 0; k < slot::n_derivatives; ++k)
      at_rest.emplace_back(slot::field(field, k), Symbol(0.0));
  for (std::size_t c = 0; c < at.components.size(); ++c) {
    LawRow row;
    for (int i = 0; i < slot::own_derivatives; ++i)
      row.u[i] = derivative(direction.components[c], slot::test(own_slot(i)));
    std::vector<solver::SeenField> seen;
    for (const int field : fields) {
      std::optional<double> times;
      std::vector<Symbol> own;
      for (int i = 0; i < slot::own_derivatives; ++i) {
        own.push_back(derivative(at.components[c], slot::field(field, own_slot(i))));
        if (stands_before(clarke, own.back(), field, use.unknown)) return false;
        if (!times && !own.back().is(0.0)) times = ratio(own.back(), row.u[i]);
      }
      for (std::size_t i = 0; i < own.size(); ++i)
        if (!agree(own[i], Symbol(times.value_or(0.0)) * row.u[i])) {
          mistakes_.error(
              "E0415", clarke.at->span,
              "the argument is not M of a sum of fields with constants, M that of the direction",
              fmt::format("write `{0}.nu + 0.1*{0}'.nu` with `{1}.nu`, or `[{0}.x, {0}'.y]` with "
                          "`[{1}.x, {1}.y]`",
                          unknowns_.name_of(use.unknown),
                          find_->unknowns[static_cast<std::size_t>(use.unknown)].test.text));
          return false;
        }
      if (times) seen.push_back({field, as_before(use.seen, field, *times)});
    }
    row.offset = substitute(at.components[c], at_rest);
    use.rows.push_back(std::move(row));
    use.seen.push_back(std::move(seen));
  }
  // A row without an unknown moves with any of the others.
  const auto any = std::ranges::find_if(use.seen, [](const auto& row) { return !row.empty(); });
  for (auto& row : use.seen)
    if (row.empty()) row = *any;
  return true;
}

/// The rows of a law's argument, whose direction has the same: M is one operator. A kernel's
/// constant factor stands before its memory: there the direction has the rows, and the argument
/// `of_memory` times them.
bool LawApplications::law_rows(const ast::Clarke& clarke, const Field& at, const Field& direction,
                               LawUse& use) {
  const std::string& u = unknowns_.name_of(use.unknown);
  const auto own_slot = [&](int i) { return slot::of_unknown(use.unknown, i); };
  const std::string seen = use.field == solver::field_of_u(1) ? u + "'" : u;
  std::optional<double> of_memory;
  std::vector<std::pair<solver::Slot, Symbol>> at_rest;
  for (int k = 0; k < slot::n_derivatives; ++k)
    at_rest.emplace_back(slot::field(use.field, k), Symbol(0.0));
  for (std::size_t c = 0; c < at.components.size(); ++c) {
    LawRow row;
    for (int i = 0; i < slot::own_derivatives; ++i) {
      Symbol own = derivative(at.components[c], slot::field(use.field, own_slot(i)));
      if (stands_before(clarke, own, use.field, use.unknown)) return false;
      const Symbol v = derivative(direction.components[c], slot::test(own_slot(i)));
      if (solver::is_memory(use.field) && !own.is(0.0)) {
        if (!of_memory) of_memory = ratio(own, v);
        if (of_memory && agree(own, Symbol(*of_memory) * v)) own = v;
      }
      row.u[i] = own;
      if (!agree(own, v)) {
        mistakes_.add(
            diagnose("E0414", clarke.direction->span,
                     fmt::format("the direction is not the argument with `{}` in place of `{}`",
                                 find_->unknowns[static_cast<std::size_t>(use.unknown)].test.text,
                                 seen))
                .with_secondary(clarke.at->span, "the argument")
                .with_help("j^0(Mu; Mv) takes the same M twice: `j^0(u.nu; v.nu)`, "
                           "`j^0(-u.nu; -v.nu)`"));
        return false;
      }
    }
    row.offset = substitute(at.components[c], at_rest);
    use.rows.push_back(std::move(row));
  }
  use.of_memory = of_memory.value_or(1.0);
  return true;
}

/// The declaration of the superpotential before `^0`; nothing (reported) where there is none.
std::optional<int> LawApplications::superpotential_of(const ast::Clarke& clarke,
                                                      const Scope& scope) {
  const auto* r = std::get_if<ast::Reference>(&clarke.law->node);
  const int index = r ? names_.find(r->name) : -1;
  if (index >= 0 && std::holds_alternative<ast::Superpotential>(*names_[index].statement))
    return index;
  Value v = evaluator_.expr(*clarke.law, scope);
  if (!is_poison(v))
    mistakes_.error("E0306", clarke.law->span,
                    fmt::format("`^0` takes a superpotential, not {}", describe(v)),
                    "declare it: `superpotential j(r) = ...`");
  return std::nullopt;
}

/// Are argument and direction of one shape, one of the unknown, the other of v (else reported)?
bool LawApplications::is_pair_of_law(const ast::Clarke& clarke, const std::string& law,
                                     const Field& at, const Field& direction) {
  const std::string u = unknowns_.name_of(0), v = find_->unknowns.front().test.text;
  const std::string right = unknowns_.is_vector(0)
                                ? fmt::format("write `{}^0({}.nu; {}.nu)`", law, u, v)
                                : fmt::format("write `{}^0({}; {})`", law, u, v);
  if (at.trial == Degree::none || at.test != Degree::none) {
    const bool swapped = at.test != Degree::none && direction.trial != Degree::none;
    mistakes_.error("E0414", clarke.at->span,
                    fmt::format("the argument of `{}` does not contain `{}`", law, u),
                    swapped ? "the unknown stands first, the test function behind it" : right);
    return false;
  }
  if (direction.test != Degree::linear || direction.trial != Degree::none) {
    mistakes_.error("E0401", clarke.direction->span,
                    fmt::format("the direction of `{}` is linear in `{}`", law, v), right);
    return false;
  }
  const bool same = same_shape(at, direction);
  if (same && at.rank <= 2 && std::ssize(at.components) <= slot::most_arguments) return true;
  if (same)
    mistakes_.error("E0414", clarke.at->span,
                    fmt::format("the argument of `{}` is {}", law, describe(at)),
                    fmt::format("a law sees a number, a vector of up to {}, or a matrix: "
                                "`eps(u).xy`, `[eps(u).xz, eps(u).yz]`, `eps(u)`",
                                slot::most_arguments));
  else
    mistakes_.error(
        "E0414", clarke.direction->span,
        fmt::format("the direction is {}, the argument {}", describe(direction), describe(at)));
  return false;
}

/// What a law sees of which unknown, row by row; nothing (reported) where that is not M of it.
std::optional<LawUse> LawApplications::law_use(const ast::Clarke& clarke, const Field& at,
                                               const Field& direction) {
  LawUse use;
  const auto seen = law_fields(clarke, at);
  if (!seen) return std::nullopt;
  if (!seen->empty()) // of several the rate, or a memory
    use.field = seen->contains(solver::field_of_u(1)) ? solver::field_of_u(1) : *seen->rbegin();
  const auto of = law_unknown(clarke, at, direction);
  if (!of) return std::nullopt;
  use.unknown = *of;
  const bool same = seen->size() > 1 ? law_rows_of_sums(clarke, at, direction, *seen, use)
                                     : law_rows(clarke, at, direction, use);
  return same ? std::optional(std::move(use)) : std::nullopt;
}

/// Can what the law reads, and the time, be had where it stands (else reported)?
bool LawApplications::can_stand_here(const ast::Clarke& clarke, int law, const Scope& scope) {
  const solver::LawSpec& spec = model_.laws[static_cast<std::size_t>(law)].spec;
  if (!spec.readings.empty() && at_hand_.part >= 0 &&
      pairs_.is_pair(at_hand_.part) != laws_.reads_jumps(law)) {
    mistakes_.error(
        "E0441", clarke.law->span,
        fmt::format("`{}` reads {}", spec.name,
                    pairs_.is_pair(at_hand_.part) ? "one side, and acts on a pair"
                                                  : "a jump, and acts on no pair"),
        fmt::format("on a pair a law reads `jump({0}).nu` or `jump(history(q, {0})).nu`, "
                    "elsewhere `{0}.nu`",
                    unknowns_.name_of(0)));
    return false;
  }
  const auto wants_normal = [](const Symbol& reading) {
    return reading.depends_on_any(slot::normal(0), slot::normal(2) + 1);
  };
  if (!scope.normal && std::ranges::any_of(spec.readings, wants_normal)) {
    mistakes_.error(
        "E0309", clarke.law->span,
        fmt::format("`{}` reads a normal or tangential part, which there is on the boundary only",
                    spec.name));
    return false;
  }
  if (find_->time || !spec.expression.depends_on(slot::t)) return true;
  mistakes_.error(
      "E0412", clarke.law->span,
      fmt::format("`{}` depends on the time `t`, and a static problem has none", spec.name),
      "add `for t in [0, T] by N steps from u = 0` to the find statement");
  return false;
}

/// On a pair laws act on jumps (else reported).
bool LawApplications::is_of_no_mean(const ast::Clarke& c, const Field& at, const Field& direction) {
  if (!pairs_.is_pair(at_hand_.part)) return true;
  const bool in_argument = has_means(at.components);
  if (!in_argument && !has_means(direction.components)) return true;
  mistakes_.error(
      "E0441", (in_argument ? c.at : c.direction)->span, "a law acts on the mean of both sides",
      fmt::format("it acts on `jump({})`; its superpotential may read means, and sources bring "
                  "what it does to both sides: `integral(seam, dot(slip.xi, "
                  "jump(u').tau)*mean(eta))`",
                  unknowns_.name_of(0)));
  return false;
}

Value LawApplications::clarke(const ast::Expr& e, const ast::Clarke& c, const Scope& scope) {
  const auto index = superpotential_of(c, scope);
  if (!index) return Poison{};
  const std::string name = names_[*index].name;
  evaluator_.value_of(*index, c.law->span);
  if (!scope.test) {
    mistakes_.error("E0309", e.span, fmt::format("`{}^0` stands in the inequality only", name),
                    scope.report ? fmt::format("the multiplier is `{}.xi`", name) : "");
    return Poison{};
  }
  Scope of_argument = scope;
  of_argument.states = true;
  auto at = evaluator_.field(*c.at, of_argument);
  auto direction = evaluator_.field(*c.direction, scope);
  if (!at || !direction || !is_pair_of_law(c, name, *at, *direction) ||
      !pairs_.take_jumps(c.at->span, at->components, at_hand_.part) ||
      !pairs_.take_jumps(c.direction->span, direction->components, at_hand_.part) ||
      !is_of_no_mean(c, *at, *direction))
    return Poison{};
  auto use = law_use(c, *at, *direction);
  if (use && !find_->time && offset_in_time(use->rows)) {
    mistakes_.error("E0412", c.at->span, "a static problem has no time `t`",
                    "add `for t in [0, T] by N steps from u = 0` to the find statement");
    return Poison{};
  }
  const bool of_norm = at->rank > 0;
  if (of_norm && !laws_.is_law_of_vectors(*index, *c.at, *at)) return Poison{};
  const auto law = laws_.law_for(*index, of_norm, c.law->span);
  if (!use || !law || !can_stand_here(c, *law, scope)) return Poison{};
  Field out = scalar_field(0.0);
  out.test = Degree::linear;
  out.rate = at->rate;
  use->law = *law;
  use->columns = at->rank == 2 ? at->columns : 0;
  use->name = name;
  use->span = e.span;
  out.laws.push_back(std::move(*use));
  return out;
}

} // namespace hvi::lang
