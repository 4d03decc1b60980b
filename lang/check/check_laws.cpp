// Superpotentials: their bodies as functions of one argument, and j^0(at; direction) in a form.
#include "lang/check/checker.hpp"
#include "solver/law/law.hpp"
#include "solver/law/law_failure.hpp"
#include "solver/law/reach.hpp"
#include "solver/law/switches.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace hvi::lang {

namespace slot = solver::slot;

namespace {

/// The Field a superpotential's argument stands for: a scalar r, or a vector known by its norm.
Field law_argument(bool radial) {
  Field f = scalar_field(Symbol::variable(slot::argument(0)));
  f.law_vector = radial;
  if (radial) f.rank = 1;
  return f;
}

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

} // namespace

std::optional<Field> Checker::law_body(int declaration, const Field& argument,
                                       const std::map<std::string, Value>& parameters,
                                       const Span& use) {
  const auto& law = std::get<ast::Superpotential>(*declarations_[declaration].statement);
  if (laws_at_hand_.count(declaration) > 0) {
    // Once for all the laws of the circle.
    if (laws_in_circle_.count(declaration) == 0)
      error("E0313", use, fmt::format("`{}` is defined by itself", law.name.text));
    laws_in_circle_.insert(laws_at_hand_.begin(), laws_at_hand_.end());
    return std::nullopt;
  }
  if (laws_in_circle_.count(declaration) > 0) return std::nullopt;
  if (laws_at_hand_.size() > 60) { // each is a level of this function's own recursion
    if (!std::exchange(too_deep_, true))
      error("E0216", use, "superpotentials are nested more than 60 levels deep");
    return std::nullopt;
  }
  laws_at_hand_.insert(declaration);
  Scope scope;
  scope.what = "a superpotential";
  scope.position = true;
  scope.time = true;
  scope.law = scope.states = true;
  scope.locals = parameters;
  scope.locals[law.argument.text] = argument;
  auto f = field(law.value, scope);
  laws_at_hand_.erase(declaration);
  if (!f) return std::nullopt;
  if (f->rank != 0 || f->law_vector) {
    error("E0306", law.value.span,
          fmt::format("a superpotential is a number, not {}", describe(*f)),
          "a vector argument enters through `norm(xi)`");
    return std::nullopt;
  }
  if (f->by_slope && law.by_slope) {
    error("E0306", law.value.span, "`with slope` of a law that is itself given by its slope",
          "write `=` in place of `with slope`");
    return std::nullopt;
  }
  if (law.by_slope) {
    // Chain rule: the slope in the outer argument.
    if (!argument.law_vector) {
      const Symbol inner = derivative(argument.scalar(), slot::argument(0));
      f->components[0] = f->scalar() * inner;
    }
    f->by_slope = true;
  }
  return f;
}

Value Checker::call_law(const ast::Expr& e, const ast::Call& c, int declaration,
                        const Scope& scope) {
  const auto& law = std::get<ast::Superpotential>(*declarations_[declaration].statement);
  if (!scope.law) {
    error("E0306", e.span,
          fmt::format("the superpotential `{}` stands as `{}^0(at; direction)`", law.name.text,
                      law.name.text),
          "write `" + law.name.text + "^0(u.nu; v.nu)`");
    return Poison{};
  }
  std::vector<std::string> names = {law.argument.text};
  for (const ast::LawParameter& p : law.parameters) names.push_back(p.name.text);
  auto args = match(e, c, law.name.text, names, 1);
  if (!args) return Poison{};
  auto argument = field(*(*args)[0], scope);
  if (!argument) return Poison{};
  std::map<std::string, Value> parameters;
  for (std::size_t i = 1; i < names.size(); ++i) {
    const ast::LawParameter& p = law.parameters[i - 1];
    const ast::Expr* given = (*args)[i] ? (*args)[i] : (p.value ? &*p.value : nullptr);
    if (!given) {
      error("E0305", e.span, fmt::format("`{}` needs its argument `{}`", law.name.text, names[i]));
      return Poison{};
    }
    Scope outer = scope;
    if (!(*args)[i]) outer.locals = parameters; // a default may use the parameters before it
    Value v = expr(*given, outer);
    if (!is_law_parameter(v, *given)) return Poison{};
    parameters[names[i]] = std::move(v);
  }
  calls_.push_back(e.span);
  auto body = law_body(declaration, *argument, parameters, c.callee->span);
  calls_.pop_back();
  return body ? Value(*body) : Value(Poison{});
}

/// A parameter of a law is a number or a vector; false (reported) for anything else.
bool Checker::is_law_parameter(const Value& value, const ast::Expr& given) {
  if (is_poison(value)) return false;
  const auto* f = std::get_if<Field>(&value);
  if (f && f->rank <= 1) return true;
  error("E0306", given.span,
        fmt::format("a parameter of a law is a number, not {}", describe(value)));
  return false;
}

/// The condition or the branch of the law's own cases where it is bad, else `otherwise`.
Span Checker::place_in_law(const solver::Failure& failure, const Span& otherwise) const {
  const auto* bad = dynamic_cast<const solver::LawFailure*>(&failure);
  if (bad == nullptr || law_cases_.empty()) return otherwise;
  if (bad->condition) {
    for (const LawCases& cases : law_cases_)
      for (std::size_t i = 0; i < cases.conditions.size(); ++i)
        if (solver::contains(cases.conditions[i], *bad->condition)) return cases.places[i];
    return otherwise;
  }
  if (!bad->argument) return otherwise;
  const LawCases& outer = law_cases_.back();
  std::size_t i = 0;
  const auto value = [&](solver::Slot s) {
    if (s == slot::argument(0)) return *bad->argument;
    return bad->t.value(s, bad->x);
  };
  while (i < outer.conditions.size() && solver::evaluate(outer.conditions[i], value) != 1.0) ++i;
  return outer.values[i];
}

void Checker::warn_of_unreached_cases(bool radial) {
  for (const LawCases& cases : law_cases_)
    for (const int i : solver::unreached_cases(cases.conditions, radial))
      diagnostics_.add(diagnose("W0107", cases.places[static_cast<std::size_t>(i)],
                                "no argument reaches this case: the ones before it hold first")
                           .with_help("put the narrower condition first"));
}

namespace {

bool is_read(solver::Slot s) {
  return s >= slot::first_field || (s >= slot::normal(0) && s <= slot::normal(2));
}

/// The expression with the largest parts of it that know the solution, but not what the law acts
/// on or its states, as readings.
class ReadingsTaken {
public:
  explicit ReadingsTaken(std::vector<Symbol>& readings) : readings_(readings) {}

  Symbol operator()(const Symbol& e) {
    const auto slots = e.slots();
    if (std::ranges::none_of(slots, is_read)) return e;
    if (const auto known = taken_.find(e.id()); known != taken_.end()) return known->second;
    const bool acts = e.depends_on_any(slot::argument(0), slot::law_state(slot::most_law_states));
    const Symbol out = acts ? with_readings(e) : reading(e);
    taken_.emplace(e.id(), out);
    return out;
  }

private:
  Symbol with_readings(const Symbol& e) {
    std::vector<Symbol> args;
    for (const Symbol& argument : e.args()) args.push_back((*this)(argument));
    if (e.table()) return Symbol::tabulated(e.table(), args[0], e.op() == solver::Op::table_slope);
    return Symbol::make(e.op(), std::move(args));
  }
  Symbol reading(const Symbol& e) {
    const auto found = std::ranges::find(readings_, e);
    const auto i = static_cast<int>(found - readings_.begin());
    if (found == readings_.end()) readings_.push_back(e);
    return Symbol::variable(slot::reading(std::min(i, slot::most_readings - 1)));
  }

  std::vector<Symbol>& readings_;
  std::map<const void*, Symbol> taken_;
};

} // namespace

/// The law as an expression of its argument and of what it reads of the solution. False (reported)
/// when it reads what it cannot.
bool Checker::take_readings(const std::string& name, const Span& span, const Symbol& body,
                            solver::LawSpec& spec) {
  spec.expression = ReadingsTaken(spec.readings)(body);
  for (const Symbol& reading : spec.readings)
    for (const solver::Slot s : reading.slots()) {
      if (slot::is_field(s) && slot::field_of(s) == solver::field_of_u(2)) {
        error("E0432", span, fmt::format("`{}` reads `{}''`", name, name_of(0)),
              "a law reads unknowns, their rates and memories");
        return false;
      }
      if (slot::is_multiplier(s) || (s < slot::first_multiplier && !slot::is_field_gradient(s)))
        continue;
      error("E0432", span,
            fmt::format("`{}` reads more of the solution than its values at the point", name),
            fmt::format("write `{0}.nu`, `norm({0}.tau)`, `{0}.x` or such a part of `{0}'` and "
                        "`history(q, {0})`",
                        name_of(0)));
      return false;
    }
  if (spec.readings.size() <= slot::most_readings) return true;
  error("E0432", span,
        fmt::format("`{}` reads {} quantities of the solution, more than {}", name,
                    spec.readings.size(), slot::most_readings),
        "put what depends on the solution alone into one factor or summand");
  return false;
}

std::optional<int> Checker::law_for(int declaration, bool radial, const Span& use) {
  auto key = std::pair(declaration, radial);
  if (auto found = law_index_.find(key); found != law_index_.end())
    return found->second < 0 ? std::nullopt : std::optional(found->second);
  law_index_[key] = -1;
  const auto& law = std::get<ast::Superpotential>(*declarations_[declaration].statement);
  std::map<std::string, Value> parameters;
  Scope scope;
  scope.what = "a superpotential";
  scope.position = scope.time = scope.law = scope.states = true;
  for (const ast::LawParameter& p : law.parameters) {
    if (!p.value) {
      error("E0305", use,
            fmt::format("`{}` has a parameter `{}` without a value", law.name.text, p.name.text),
            fmt::format("declare `superpotential mine({}) = {}({}, {} = ...)`", law.argument.text,
                        law.name.text, law.argument.text, p.name.text));
      return std::nullopt;
    }
    scope.locals = parameters;
    Value v = expr(*p.value, scope);
    if (!is_law_parameter(v, *p.value)) return std::nullopt;
    parameters[p.name.text] = std::move(v);
  }
  coupled_.clear();
  law_cases_.clear();
  auto body = law_body(declaration, law_argument(radial), parameters, use);
  if (!body) return std::nullopt;
  solver::LawSpec spec;
  spec.coupled = coupled_;
  spec.name = law.name.text;
  spec.origin = model_.origin(law.name.span);
  spec.radial = radial;
  spec.by_slope = body->by_slope;
  Symbol expression = body->scalar();
  const bool of_jumps = has_jumps(expression);
  if (of_jumps) expression = without_jumps(expression);
  const auto states = take_states(expression, law.name.span);
  if (!states) return std::nullopt;
  spec.states = *states;
  if (!take_readings(law.name.text, law.value.span, expression, spec)) return std::nullopt;
  try {
    solver::Law probe(spec);
    if (!probe.depends_on_x() && !probe.depends_on_t()) probe.graph({}, 0.0);
  } catch (const solver::Failure& failure) {
    error("E0501", place_in_law(failure, law.name.span), failure.what(), failure.help);
    return std::nullopt;
  }
  warn_of_unreached_cases(radial);
  model_.laws.push_back({law.name.text, law.name.span, spec});
  const int index = static_cast<int>(model_.laws.size()) - 1;
  if (of_jumps) laws_of_jumps_.insert(index);
  law_index_[key] = index;
  return index;
}

/// False (reported at the argument) when a law that reads well for a scalar is given a vector.
bool Checker::is_law_of_vectors(int declaration, const ast::Expr& argument, const Field& at) {
  if (law_index_.count({declaration, true})) return true;
  // `xi` says that a vector was meant: then the law itself is wrong, and law_for says where.
  const auto& written = std::get<ast::Superpotential>(*declarations_[declaration].statement);
  if (written.argument.text == "xi") return true;
  const auto good = [&](bool radial) {
    Diagnostics trial;
    std::swap(trial, diagnostics_);
    const bool found = law_for(declaration, radial, argument.span).has_value();
    std::swap(trial, diagnostics_);
    if (!found) law_index_.erase({declaration, radial});
    return found;
  };
  if (good(true) || !good(false)) return true;
  law_index_[{declaration, true}] = -1;
  error("E0308", argument.span,
        fmt::format("`{}` is a law of a scalar, its argument is {}",
                    declarations_[declaration].name, describe(at)),
        "take a part of it (`u.nu`, `u.x`), or let the law read its argument through `norm`");
  return false;
}

void Checker::check_law_alone(int declaration) {
  const auto& law = std::get<ast::Superpotential>(*declarations_[declaration].statement);
  for (const ast::LawParameter& p : law.parameters)
    if (!p.value) return; // a family: checked where it is used
  if (law_index_.count({declaration, true}) || law_index_.count({declaration, false})) return;
  if (laws_in_circle_.count(declaration) > 0) return;
  // Nobody applies it: try it as a law of a scalar; a law of a vector complains there.
  Diagnostics trial;
  std::swap(trial, diagnostics_);
  const bool good = law_for(declaration, false, law.name.span).has_value();
  std::swap(trial, diagnostics_);
  if (good) return;
  Diagnostics vector_trial;
  std::swap(vector_trial, diagnostics_);
  const bool good_vector = law_for(declaration, true, law.name.span).has_value();
  std::swap(vector_trial, diagnostics_);
  if (good_vector) return;
  for (const Diagnostic& d : trial.items()) diagnostics_.add(d);
}

/// What the argument of a law is made of: u, u', memories; nothing (reported) when there is
/// anything else than values in it.
std::optional<std::set<int>> Checker::law_fields(const ast::Clarke& clarke, const Field& at) {
  std::set<int> out;
  for (const Symbol& component : at.components)
    for (const solver::Slot s : solver::slots_of(component)) {
      if (!slot::is_field(s)) continue;
      if (slot::is_field_gradient(s)) {
        error("E0414", clarke.at->span,
              "M takes values of the unknown: its trace, a part of it or itself",
              "write `u.nu`, `u.tau`, a component, `u` or `u.nu - gap`");
        return std::nullopt;
      }
      out.insert(slot::field_of(s));
    }
  if (out.contains(solver::field_of_u(2))) {
    error("E0415", clarke.at->span, fmt::format("a law does not act on `{}''`", name_of(0)),
          "laws act on the unknown, its rate or a memory, or on a sum of them");
    return std::nullopt;
  }
  return out;
}

/// The unknown whose values a law sees, in the argument and in the direction.
std::optional<int> Checker::law_unknown(const ast::Clarke& clarke, const Field& at,
                                        const Field& direction) {
  std::set<int> seen, tested;
  for (const Symbol& component : at.components)
    for (const solver::Slot s : solver::slots_of(component))
      if (slot::is_field(s)) seen.insert(slot::unknown_of(slot::derivative_of(s)));
  for (const Symbol& component : direction.components)
    for (const solver::Slot s : solver::slots_of(component))
      if (slot::is_test(s)) tested.insert(slot::unknown_of(s - slot::test(0)));
  if (seen.size() > 1) {
    error("E0444", clarke.at->span, "the argument of a law has two unknowns in it",
          "a law sees one of them; its superpotential may read others");
    return std::nullopt;
  }
  if (seen.empty() || tested == seen) return seen.empty() ? 0 : *seen.begin();
  const auto& mine = find_->unknowns[static_cast<std::size_t>(*seen.begin())];
  error("E0444", clarke.direction->span,
        fmt::format("the argument is of `{}`, the direction not of its test function `{}`",
                    mine.unknown.text, mine.test.text),
        "j^0(Mu; Mv) takes the same M of an unknown and of its own test function");
  return std::nullopt;
}

namespace {

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

} // namespace

namespace {

/// A factor that an earlier row has up to rounding is that one: rows with the same sum are alike.
double as_before(const std::vector<std::vector<solver::SeenField>>& rows, int field, double times) {
  for (const auto& row : rows)
    for (const solver::SeenField& seen : row)
      if (seen.field == field && std::abs(seen.times - times) <= 1e-12 * std::abs(times))
        return seen.times;
  return times;
}

} // namespace

/// Does something stand before a value of the unknown that makes a law's argument not linear in it
/// (reported)?
bool Checker::stands_before(const ast::Clarke& clarke, const Symbol& own, int field, int unknown) {
  for (int j = 0; j < components_of(unknown); ++j)
    if (own.depends_on(slot::field(field, slot::of_unknown(unknown, slot::value(j))))) {
      error("E0403", clarke.at->span,
            fmt::format("the argument of a law is linear in `{}{}`", name_of(unknown),
                        field == solver::field_of_u(1) ? "'" : ""));
      return true;
    }
  if (!own.depends_on_any(slot::first_state, slot::first_probe)) return false;
  error("E0403", clarke.at->span, "a state stands before the unknown in the argument of a law",
        "the superpotential itself may depend on it");
  return true;
}

/// The same where several fields are seen: each row is M of a sum of them, c_0 u + c_1 u' + ...,
/// with constants, and M is that of the direction.
bool Checker::law_rows_of_sums(const ast::Clarke& clarke, const Field& at, const Field& direction,
                               const std::set<int>& fields, LawUse& use) {
  const int d = components_of(use.unknown);
  const auto own_value = [&](int i) { return slot::of_unknown(use.unknown, slot::value(i)); };
  std::vector<std::pair<solver::Slot, Symbol>> at_rest;
  for (const int field : fields)
    for (int k = 0; k < slot::n_derivatives; ++k)
      at_rest.emplace_back(slot::field(field, k), Symbol(0.0));
  for (std::size_t c = 0; c < at.components.size(); ++c) {
    LawRow row;
    for (int i = 0; i < d; ++i)
      row.u.push_back(derivative(direction.components[c], slot::test(own_value(i))));
    std::vector<solver::SeenField> seen;
    for (const int field : fields) {
      std::optional<double> times;
      std::vector<Symbol> own;
      for (int i = 0; i < d; ++i) {
        own.push_back(derivative(at.components[c], slot::field(field, own_value(i))));
        if (stands_before(clarke, own.back(), field, use.unknown)) return false;
        if (!times && !own.back().is(0.0)) times = ratio(own.back(), row.u[i]);
      }
      for (std::size_t i = 0; i < own.size(); ++i)
        if (!agree(own[i], Symbol(times.value_or(0.0)) * row.u[i])) {
          error("E0415", clarke.at->span,
                "the argument is not M of a sum of fields with constants, M that of the direction",
                fmt::format("write `{0}.nu + 0.1*{0}'.nu` with `{1}.nu`, or `[{0}.x, {0}'.y]` with "
                            "`[{1}.x, {1}.y]`",
                            name_of(use.unknown),
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
bool Checker::law_rows(const ast::Clarke& clarke, const Field& at, const Field& direction,
                       LawUse& use) {
  const int d = components_of(use.unknown);
  const std::string& u = name_of(use.unknown);
  const auto own_value = [&](int i) { return slot::of_unknown(use.unknown, slot::value(i)); };
  const std::string seen = use.field == solver::field_of_u(1) ? u + "'" : u;
  std::optional<double> of_memory;
  std::vector<std::pair<solver::Slot, Symbol>> at_rest;
  for (int k = 0; k < slot::n_derivatives; ++k)
    at_rest.emplace_back(slot::field(use.field, k), Symbol(0.0));
  for (std::size_t c = 0; c < at.components.size(); ++c) {
    LawRow row;
    for (int i = 0; i < d; ++i) {
      Symbol own = derivative(at.components[c], slot::field(use.field, own_value(i)));
      if (stands_before(clarke, own, use.field, use.unknown)) return false;
      const Symbol v = derivative(direction.components[c], slot::test(own_value(i)));
      if (solver::is_memory(use.field) && !own.is(0.0)) {
        if (!of_memory) of_memory = ratio(own, v);
        if (of_memory && agree(own, Symbol(*of_memory) * v)) own = v;
      }
      row.u.push_back(own);
      if (!agree(row.u.back(), v)) {
        diagnostics_.add(
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

Value Checker::clarke(const ast::Expr& e, const ast::Clarke& c, const Scope& scope) {
  const auto* r = std::get_if<ast::Reference>(&c.law->node);
  const int index = r ? find_declaration(r->name) : -1;
  if (index < 0 || !std::holds_alternative<ast::Superpotential>(*declarations_[index].statement)) {
    Value v = expr(*c.law, scope);
    if (!is_poison(v))
      error("E0306", c.law->span, fmt::format("`^0` takes a superpotential, not {}", describe(v)),
            "declare it: `superpotential j(r) = ...`");
    return Poison{};
  }
  value_of(index, c.law->span);
  laws_applied_.insert(index);
  if (!scope.test) {
    error("E0309", e.span, fmt::format("`{}^0` stands in the inequality only", r->name),
          scope.report ? fmt::format("the multiplier is `{}.xi`", r->name) : "");
    return Poison{};
  }
  Scope of_argument = scope;
  of_argument.states = true;
  auto at = field(*c.at, of_argument);
  auto direction = field(*c.direction, scope);
  if (!at || !direction) return Poison{};
  const std::string u = name_of(0), v = find_->unknowns.front().test.text;
  if (at->trial == Degree::none || at->test != Degree::none) {
    error("E0414", c.at->span,
          fmt::format("the argument of `{}` does not contain `{}`", r->name, u),
          fmt::format("write `{}^0({}.nu; {}.nu)`", r->name, u, v));
    return Poison{};
  }
  if (direction->test != Degree::linear || direction->trial != Degree::none) {
    error("E0401", c.direction->span,
          fmt::format("the direction of `{}` is linear in `{}`", r->name, v),
          fmt::format("write `{}^0({}.nu; {}.nu)`", r->name, u, v));
    return Poison{};
  }
  if (!same_shape(*at, *direction) || at->rank > 1) {
    error("E0414", c.direction->span,
          fmt::format("the direction is {}, the argument {}", describe(*direction), describe(*at)));
    return Poison{};
  }
  if (!take_jumps(c.at->span, at->components, part_at_hand_) ||
      !take_jumps(c.direction->span, direction->components, part_at_hand_))
    return Poison{};
  LawUse use;
  const auto seen = law_fields(c, *at);
  if (seen && !seen->empty()) // of several the rate, or a memory
    use.field = seen->contains(solver::field_of_u(1)) ? solver::field_of_u(1) : *seen->rbegin();
  const auto of = seen ? law_unknown(c, *at, *direction) : std::nullopt;
  use.unknown = of.value_or(0);
  const bool same = of && (seen->size() > 1 ? law_rows_of_sums(c, *at, *direction, *seen, use)
                                            : law_rows(c, *at, *direction, use));
  if (same && !find_->time && offset_in_time(use.rows)) {
    error("E0412", c.at->span, "a static problem has no time `t`",
          "add `for t in [0, T] by N steps from u = 0` to the find statement");
    return Poison{};
  }
  if (at->rank == 1 && !is_law_of_vectors(index, *c.at, *at)) return Poison{};
  auto law = law_for(index, at->rank == 1, c.law->span);
  if (!same || !law) return Poison{};
  const auto& readings = model_.laws[*law].spec.readings;
  if (!readings.empty() && part_at_hand_ >= 0 &&
      is_pair(part_at_hand_) != laws_of_jumps_.contains(*law)) {
    error("E0441", c.law->span,
          fmt::format("`{}` reads {}", r->name,
                      is_pair(part_at_hand_) ? "one side, and acts on a pair"
                                             : "a jump, and acts on no pair"),
          fmt::format("on a pair a law reads `jump({0}).nu` or `jump(history(q, {0})).nu`, "
                      "elsewhere `{0}.nu`",
                      u));
    return Poison{};
  }
  const auto wants_normal = [](const Symbol& reading) {
    return reading.depends_on_any(slot::normal(0), slot::normal(2) + 1);
  };
  if (!scope.normal && std::ranges::any_of(readings, wants_normal)) {
    error("E0309", c.law->span,
          fmt::format("`{}` reads a normal or tangential part, which there is on the boundary only",
                      r->name));
    return Poison{};
  }
  if (!find_->time && model_.laws[*law].spec.expression.depends_on(slot::t)) {
    error("E0412", c.law->span,
          fmt::format("`{}` depends on the time `t`, and a static problem has none", r->name),
          "add `for t in [0, T] by N steps from u = 0` to the find statement");
    return Poison{};
  }
  Field out = scalar_field(0.0);
  out.test = Degree::linear;
  out.rate = at->rate;
  use.law = *law;
  use.name = r->name;
  use.span = e.span;
  out.laws.push_back(std::move(use));
  return out;
}

} // namespace hvi::lang
