#include "lang/check/laws.hpp"

#include "lang/check/bounds.hpp"
#include "solver/law/law.hpp"
#include "solver/law/law_failure.hpp"
#include "solver/law/reach.hpp"
#include "solver/law/switches.hpp"

#include <fmt/format.h>

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

/// The slope in the outer argument, of a law that is applied to a number: by the chain rule, and of
/// a friction bound with the sign of the number, as the slope of `bound*norm(xi)` has it.
Symbol slope_of_number(const ast::Superpotential& law, const Symbol& slope, const Field& argument) {
  const Symbol along = slope * derivative(argument.scalar(), slot::argument(0));
  return is_bound(law) ? select(less(argument.scalar(), 0.0), -along, along) : along;
}

/// Of the shape of the law's argument.
Field multiplier_of(const LawUse& use, bool radial, int application) {
  const auto n = radial ? static_cast<int>(use.rows.size()) : 1;
  std::vector<Symbol> xi;
  for (int c = 0; c < n; ++c) xi.push_back(Symbol::variable(slot::multiplier(application, c)));
  Field out = !radial            ? scalar_field(xi[0])
              : use.columns == 0 ? vector_field(xi)
                                 : matrix_field(n / use.columns, use.columns, xi);
  // A law of a matrix in the plane sees no strain across it, so that it has no stress there either.
  if (out.rank == 2 && out.rows == 2 && out.columns == 2) out.across = {Symbol(0.0)};
  out.trial = Degree::nonlinear;
  return out;
}

} // namespace

std::optional<Field> Laws::body_of(int declaration, const Field& argument,
                                   const std::map<std::string, Value>& parameters,
                                   const Span& use) {
  const auto& law = std::get<ast::Superpotential>(*names_[declaration].statement);
  if (laws_at_hand_.count(declaration) > 0) {
    // Once for all the laws of the circle.
    if (laws_in_circle_.count(declaration) == 0)
      mistakes_.error("E0313", use, fmt::format("`{}` is defined by itself", law.name.text));
    laws_in_circle_.insert(laws_at_hand_.begin(), laws_at_hand_.end());
    return std::nullopt;
  }
  if (laws_in_circle_.count(declaration) > 0) return std::nullopt;
  if (laws_at_hand_.size() > 60) { // each is a level of this function's own recursion
    if (!limits_.complained())
      mistakes_.error("E0216", use, "superpotentials are nested more than 60 levels deep");
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
  auto f = evaluator_.field(law.value, scope);
  laws_at_hand_.erase(declaration);
  if (!f) return std::nullopt;
  if (f->rank != 0 || f->law_vector) {
    mistakes_.error("E0306", law.value.span,
                    fmt::format("a superpotential is a number, not {}", describe(*f)),
                    "a vector argument enters through `norm(xi)`");
    return std::nullopt;
  }
  if (f->by_slope && law.by_slope) {
    mistakes_.error("E0306", law.value.span,
                    "`with slope` of a law that is itself given by its slope",
                    "write `=` in place of `with slope`");
    return std::nullopt;
  }
  if (law.by_slope) {
    if (!argument.law_vector) f->components[0] = slope_of_number(law, f->scalar(), argument);
    f->by_slope = true;
  }
  return f;
}

Value Laws::call(const ast::Expr& e, const ast::Call& c, int declaration, const Scope& scope) {
  const auto& law = std::get<ast::Superpotential>(*names_[declaration].statement);
  if (!scope.law) {
    mistakes_.error("E0306", e.span,
                    fmt::format("the superpotential `{}` stands as `{}^0(at; direction)`",
                                law.name.text, law.name.text),
                    "write `" + law.name.text + "^0(u.nu; v.nu)`");
    return Poison{};
  }
  std::vector<std::string> names = {law.argument.text};
  for (const ast::LawParameter& p : law.parameters) names.push_back(p.name.text);
  auto args = evaluator_.match(e, c, law.name.text, names, 1);
  if (!args) return Poison{};
  auto argument = evaluator_.field(*(*args)[0], scope);
  if (!argument) return Poison{};
  std::map<std::string, Value> parameters;
  for (std::size_t i = 1; i < names.size(); ++i) {
    const ast::LawParameter& p = law.parameters[i - 1];
    const ast::Expr* given = (*args)[i] ? (*args)[i] : (p.value ? &*p.value : nullptr);
    if (!given) {
      mistakes_.error("E0305", e.span,
                      fmt::format("`{}` needs its argument `{}`", law.name.text, names[i]));
      return Poison{};
    }
    Scope outer = scope;
    if (!(*args)[i]) outer.locals = parameters; // a default may use the parameters before it
    Value v = evaluator_.expr(*given, outer);
    if (!is_law_parameter(v, *given)) return Poison{};
    parameters[names[i]] = std::move(v);
  }
  mistakes_.enter_call(e.span, law.value.span);
  auto body = body_of(declaration, *argument, parameters, c.callee->span);
  mistakes_.leave_call();
  return body ? Value(*body) : Value(Poison{});
}

/// A parameter of a law is a number or a vector; false (reported) for anything else.
bool Laws::is_law_parameter(const Value& value, const ast::Expr& given) {
  if (is_poison(value)) return false;
  const auto* f = std::get_if<Field>(&value);
  if (f && f->rank <= 1) return true;
  mistakes_.error("E0306", given.span,
                  fmt::format("a parameter of a law is a number, not {}", describe(value)));
  return false;
}

/// The condition or the branch of the law's own cases where it is bad, else `otherwise`.
Span Laws::place_in_law(const solver::Failure& failure, const Span& otherwise) const {
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

void Laws::warn_of_unreached_cases(bool radial) {
  for (const LawCases& cases : law_cases_)
    for (const int i : solver::unreached_cases(cases.conditions, radial))
      mistakes_.add(diagnose("W0107", cases.places[static_cast<std::size_t>(i)],
                             "no argument reaches this case: the ones before it hold first")
                        .with_help("put the narrower condition first"));
}

std::optional<int> Laws::law_for(int declaration, bool radial, const Span& use) {
  auto key = std::pair(declaration, radial);
  if (auto found = law_index_.find(key); found != law_index_.end())
    return found->second < 0 ? std::nullopt : std::optional(found->second);
  law_index_[key] = -1;
  const auto& law = std::get<ast::Superpotential>(*names_[declaration].statement);
  std::map<std::string, Value> parameters;
  Scope scope;
  scope.what = "a superpotential";
  scope.position = scope.time = scope.law = scope.states = true;
  for (const ast::LawParameter& p : law.parameters) {
    if (!p.value) {
      mistakes_.error(
          "E0305", use,
          fmt::format("`{}` has a parameter `{}` without a value", law.name.text, p.name.text),
          fmt::format("declare `superpotential mine({}) = {}({}, {} = ...)`", law.argument.text,
                      law.name.text, law.argument.text, p.name.text));
      return std::nullopt;
    }
    scope.locals = parameters;
    Value v = evaluator_.expr(*p.value, scope);
    if (!is_law_parameter(v, *p.value)) return std::nullopt;
    parameters[p.name.text] = std::move(v);
  }
  coupled_.clear();
  law_cases_.clear();
  auto body = body_of(declaration, law_argument(radial), parameters, use);
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
    mistakes_.error(
        "E0441", law.value.span,
        fmt::format("`{}` reads a jump or a mean and a value of one side", law.name.text),
        fmt::format("on a pair it reads `jump({0})` and `mean({0})`; the first side's value is "
                    "`mean({0}) + 0.5*jump({0})`",
                    unknowns_.name_of(0)));
    return std::nullopt;
  }
  if (of_jumps) expression = without_jumps(expression);
  const auto states = states_.take_states(expression, law.name.span);
  if (!states) return std::nullopt;
  spec.states = *states;
  if (!take_readings(law.name.text, law.value.span, expression, of_jumps, spec))
    return std::nullopt;
  try {
    solver::Law probe(spec);
    if (!probe.depends_on_x() && !probe.depends_on_t()) probe.graph({}, 0.0);
  } catch (const solver::Failure& failure) {
    mistakes_.error("E0501", place_in_law(failure, law.name.span), failure.what(), failure.help);
    return std::nullopt;
  }
  warn_of_unreached_cases(radial);
  return law_index_[key] = add({law.name.text, law.name.span, spec, coupled_place_}, of_jumps);
}

int Laws::add(ModelLaw law, bool reads_jumps) {
  model_.laws.push_back(std::move(law));
  const int index = static_cast<int>(model_.laws.size()) - 1;
  if (reads_jumps) laws_of_jumps_.insert(index);
  return index;
}

std::optional<int> Laws::made(int declaration, bool of_vector) const {
  const auto found = law_index_.find({declaration, of_vector});
  return found == law_index_.end() || found->second < 0 ? std::nullopt
                                                        : std::optional(found->second);
}

void Laws::note_cases(LawCases cases) {
  if (laws_at_hand_.size() == 1) law_cases_.push_back(std::move(cases));
}

bool Laws::is_law_of_vectors(int declaration, const ast::Expr& argument, const Field& at) {
  if (law_index_.count({declaration, true})) return true;
  // `xi` says that a vector was meant: then the law itself is wrong, and law_for says where.
  const auto& written = std::get<ast::Superpotential>(*names_[declaration].statement);
  if (written.argument.text == "xi") return true;
  const auto good = [&](bool radial) {
    bool found = false;
    mistakes_.said_by([&] { found = law_for(declaration, radial, argument.span).has_value(); });
    if (!found) law_index_.erase({declaration, radial});
    return found;
  };
  if (good(true) || !good(false)) return true;
  law_index_[{declaration, true}] = -1;
  mistakes_.error(
      "E0308", argument.span,
      fmt::format("`{}` is a law of a scalar, its argument is {}", names_[declaration].name,
                  describe(at)),
      "take a part of it (`u.nu`, `u.x`), or let the law read its argument through `norm`");
  return false;
}

void Laws::check_alone(int declaration) {
  const auto& law = std::get<ast::Superpotential>(*names_[declaration].statement);
  for (const ast::LawParameter& p : law.parameters)
    if (!p.value) return; // a family: checked where it is used
  if (law_index_.count({declaration, true}) || law_index_.count({declaration, false})) return;
  if (laws_in_circle_.count(declaration) > 0) return;
  // Nobody applies it: try it as a law of a scalar; a law of a vector complains there.
  bool good = false;
  const auto attempt = [&](bool radial) {
    return mistakes_.said_by(
        [&] { good = law_for(declaration, radial, law.name.span).has_value(); });
  };
  const Diagnostics of_scalar = attempt(false);
  if (!good) attempt(true);
  if (good) return;
  for (const Diagnostic& d : of_scalar.items()) mistakes_.add(d);
}

/// `other.xi` in a superpotential: the multiplier of a scalar law at the same point.
Value Laws::coupled_multiplier(const ast::Member& m, int declaration) {
  const std::string& law = names_[declaration].name;
  if (laws_at_hand_.contains(declaration)) {
    mistakes_.error("E0313", m.object->span,
                    fmt::format("`{}` is defined by its own multiplier", law),
                    "a law reads the multiplier of another one");
    return Poison{};
  }
  if (coupled_.empty()) coupled_ = law, coupled_place_ = m.object->span;
  if (coupled_ == law) return scalar_field(Symbol::variable(slot::coupled));
  mistakes_.error("E0309", m.member.span,
                  fmt::format("a law reads one other law's multiplier, not those of `{}` and `{}`",
                              coupled_, law));
  return Poison{};
}

Value Laws::member(const ast::Member& m, int declaration, const Scope& scope) {
  const std::string& law = names_[declaration].name;
  if (m.member.text != "xi") {
    mistakes_.error("E0303", m.member.span,
                    fmt::format("a superpotential has no member `{}`", m.member.text),
                    fmt::format("its multiplier is `{}.xi`", law));
    return Poison{};
  }
  if (scope.law) return coupled_multiplier(m, declaration);
  if (scope.test && !scope.source) { // to be read again when all laws are known
    at_hand_.source = true;
    return Poison{};
  }
  if (!scope.report && !scope.source) {
    mistakes_.error(
        "E0309", m.member.span, fmt::format("`{}.xi` is a result", law),
        "it may stand in `report`, in sources on the part of the law and in superpotentials");
    return Poison{};
  }
  // That on the part where it is asked, else the first one.
  const LawUse* found = nullptr;
  int application = 0, of_found = 0;
  bool here = false;
  for (const ModelTerm& term : model_.terms)
    for (const LawUse& use : term.integrand.laws) {
      const bool better = !found || (!here && term.part == scope.part);
      if (use.name == law && better)
        found = &use, of_found = application, here = term.part == scope.part;
      ++application;
    }
  if (found) return multiplier_of(*found, model_.laws[found->law].spec.radial, of_found);
  if (model_.lacks_terms) return Poison{};
  if (scope.source)
    mistakes_.error("E0447", m.object->span,
                    fmt::format("no other integral of the inequality has the law `{}` in it", law),
                    "a source that reads a multiplier stands in an integral of its own");
  else
    mistakes_.error("E0301", m.object->span,
                    fmt::format("the law `{}` does not stand in the inequality", law),
                    "its multiplier exists only where it acts");
  return Poison{};
}

} // namespace hvi::lang
