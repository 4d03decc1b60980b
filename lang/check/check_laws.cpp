// Superpotentials: their bodies as functions of one argument, and the laws of the plan they become.
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
                            bool on_pair, solver::LawSpec& spec) {
  const auto is_value = [&](solver::Slot s) { // or, on a pair, a mean
    return !slot::is_field_gradient(s) || (on_pair && slot::may_be_mean(slot::derivative_of(s)));
  };
  spec.expression = ReadingsTaken(spec.readings)(body);
  for (const Symbol& reading : spec.readings)
    for (const solver::Slot s : reading.slots()) {
      if (slot::is_field(s) && slot::field_of(s) == solver::field_of_u(2)) {
        error("E0432", span, fmt::format("`{}` reads `{}''`", name, name_of(0)),
              "a law reads unknowns, their rates and memories");
        return false;
      }
      if (slot::is_multiplier(s) || (s < slot::first_multiplier && is_value(s))) continue;
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
  if (has_jumps_and_values(expression)) {
    error("E0441", law.value.span,
          fmt::format("`{}` reads a jump or a mean and a value of one side", law.name.text),
          fmt::format("on a pair it reads `jump({0})` and `mean({0})`; the first side's value is "
                      "`mean({0}) + 0.5*jump({0})`",
                      name_of(0)));
    return std::nullopt;
  }
  if (of_jumps) expression = without_jumps(expression);
  const auto states = take_states(expression, law.name.span);
  if (!states) return std::nullopt;
  spec.states = *states;
  if (!take_readings(law.name.text, law.value.span, expression, of_jumps, spec))
    return std::nullopt;
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

} // namespace hvi::lang
