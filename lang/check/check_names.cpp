// Names: declarations of the script and its imports, parameters, and what a name stands for.
#include "lang/check/builtins.hpp"
#include "lang/check/checker.hpp"
#include "lang/diag/suggest.hpp"
#include "lang/syntax/parser.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace hvi::lang {

namespace {

/// The declared name of a statement; find, report, expect, study and import declare none.
const ast::Name* declared_name(const ast::Statement& statement) {
  return std::visit(
      [](const auto& s) -> const ast::Name* {
        using T = std::decay_t<decltype(s)>;
        if constexpr (std::is_same_v<T, ast::Param> || std::is_same_v<T, ast::Mesh> ||
                      std::is_same_v<T, ast::Part> || std::is_same_v<T, ast::Tensor> ||
                      std::is_same_v<T, ast::Kernel> || std::is_same_v<T, ast::Superpotential> ||
                      std::is_same_v<T, ast::State> || std::is_same_v<T, ast::Fn> ||
                      std::is_same_v<T, ast::Space>)
          return &s.name;
        else
          return nullptr;
      },
      statement);
}

/// The names in parentheses behind the declared one.
std::vector<const ast::Name*> argument_names(const ast::Statement& statement) {
  std::vector<const ast::Name*> names;
  if (const auto* fn = std::get_if<ast::Fn>(&statement))
    for (const ast::Name& name : fn->parameters) names.push_back(&name);
  if (const auto* kernel = std::get_if<ast::Kernel>(&statement))
    for (const ast::Name& name : kernel->parameters) names.push_back(&name);
  if (const auto* law = std::get_if<ast::Superpotential>(&statement)) {
    names.push_back(&law->argument);
    for (const ast::LawParameter& parameter : law->parameters) names.push_back(&parameter.name);
  }
  return names;
}

std::string visible_note(const Scope& scope) {
  return scope.what.empty() ? std::string() : fmt::format(" in {}", scope.what);
}

} // namespace

void Checker::declare(const ast::Name& name, int program, const ast::Statement& statement) {
  if (is_reserved_builtin(name.text)) {
    error("E0311", name.span, fmt::format("`{}` is built in and cannot be declared", name.text),
          "choose another name");
    silenced_.insert(name.text);
    return;
  }
  auto found = by_name_.find(name.text);
  if (found != by_name_.end()) {
    const Declaration& first = declarations_[found->second];
    if (programs_[static_cast<std::size_t>(program)].library && first.program == 0) return;
    diagnostics_.add(diagnose("E0302", name.span, fmt::format("`{}` is declared twice", name.text))
                         .with_secondary(first.span, "first declared here")
                         .with_help("every name is declared once; reading order does not matter"));
    return;
  }
  by_name_[name.text] = static_cast<int>(declarations_.size());
  Declaration declaration;
  declaration.name = name.text;
  declaration.span = name.span;
  declaration.program = program;
  declaration.statement = &statement;
  declarations_.push_back(std::move(declaration));
}

/// False (reported) when two arguments of a function, kernel or superpotential share a name.
bool Checker::arguments_differ(const ast::Statement& statement) {
  const auto names = argument_names(statement);
  for (std::size_t i = 0; i < names.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      if (names[i]->text != names[k]->text) continue;
      diagnostics_.add(diagnose("E0302", names[i]->span,
                                fmt::format("the argument `{}` is declared twice", names[i]->text))
                           .with_secondary(names[k]->span, "first declared here"));
      return false;
    }
  return true;
}

void Checker::collect_declarations() {
  for (std::size_t p = 0; p < programs_.size(); ++p) {
    for (const ast::Name& broken : programs_[p].broken) silenced_.insert(broken.text);
    for (const ast::Statement& statement : programs_[p].statements)
      if (const ast::Name* name = declared_name(statement))
        arguments_differ(statement) ? declare(*name, static_cast<int>(p), statement)
                                    : void(silenced_.insert(name->text));
  }
}

void Checker::check_defines() {
  std::vector<std::string> known;
  for (const Declaration& d : declarations_)
    if (std::holds_alternative<ast::Param>(*d.statement)) known.push_back(d.name);
  for (const auto& [name, text] : options_.defines) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    const std::string near = did_you_mean(name, known);
    error("E0320", Span{},
          fmt::format("{}{}={}: the script has no parameter `{}`", options_.words.define, name,
                      text, name),
          known.empty()  ? "the script declares no `param`"
          : near.empty() ? fmt::format("its parameters: {}", fmt::join(known, ", "))
                         : near);
  }
}

int Checker::find_declaration(const std::string& name) const {
  auto found = by_name_.find(name);
  return found == by_name_.end() ? -1 : found->second;
}

Value& Checker::value_of(int index, const Span& use) {
  Declaration& declaration = declarations_[index];
  declaration.used = true;
  if (declaration.state == Declaration::State::busy) {
    error("E0313", use, fmt::format("`{}` is defined by itself", declaration.name),
          "break the circle: a value cannot depend on itself");
    declaration.value = Poison{};
    return declaration.value;
  }
  if (part_at_hand_ >= 0) parts_of_[index].insert(part_at_hand_);
  if (evaluated_ >= 0) used_by_[index].insert(evaluated_);
  if (declaration.state == Declaration::State::untouched && may_go_deeper(use, depth_)) {
    declaration.state = Declaration::State::busy;
    const int outer = std::exchange(evaluated_, index);
    ++depth_;
    Value value = evaluate(declaration);
    --depth_;
    evaluated_ = outer;
    declarations_[index].value = std::move(value);
    declarations_[index].state = Declaration::State::done;
  }
  return declarations_[index].value;
}

Value Checker::evaluate(Declaration& declaration) {
  const int index = static_cast<int>(&declaration - declarations_.data());
  const ast::Statement& statement = *declaration.statement;
  if (const auto* param = std::get_if<ast::Param>(&statement)) return evaluate_param(*param);
  if (const auto* m = std::get_if<ast::Mesh>(&statement)) return mesh(*m);
  if (const auto* part = std::get_if<ast::Part>(&statement)) {
    auto spec = region(part->region);
    if (!spec) return Poison{};
    model_.parts.push_back({part->name.text, part->name.span, *spec, kind_of(*spec)});
    part_of_[part->name.text] = static_cast<int>(model_.parts.size()) - 1;
    return PartValue{static_cast<int>(model_.parts.size()) - 1};
  }
  if (const auto* tensor = std::get_if<ast::Tensor>(&statement)) {
    Scope scope;
    scope.what = "a tensor";
    scope.position = true;
    auto f = field(tensor->value, scope);
    if (!f) return Poison{};
    if (f->rank == 0 || f->rank == 1)
      error("E0306", tensor->value.span,
            fmt::format("a tensor is expected here, not {}", describe(*f)),
            f->rank == 0 ? "a scalar coefficient is declared with `fn k() = ...` or `param`" : "");
    if (f->rank < 2) return Poison{};
    if (!is_constant(*f)) note_material(tensor->value.span, *f, false);
    if (f->rank == 4) name_tensor(*f, tensor->name);
    return *f;
  }
  if (std::holds_alternative<ast::Kernel>(statement)) return KernelValue{index};
  if (std::holds_alternative<ast::Superpotential>(statement)) return LawValue{index};
  if (std::holds_alternative<ast::State>(statement)) return state(index);
  if (std::holds_alternative<ast::Fn>(statement)) return FunctionValue{index};
  if (const auto* s = std::get_if<ast::Space>(&statement)) {
    auto made = space(*s);
    return made ? Value(SpaceValue{*made}) : Value(Poison{});
  }
  return Poison{};
}

Value Checker::evaluate_param(const ast::Param& param) {
  Scope scope;
  scope.what = "a parameter";
  ModelParam entry;
  entry.name = param.name.text;
  entry.span = param.name.span;
  if (param.doc) entry.doc = param.doc->text;
  Value value = expr(param.value, scope);
  if (options_.defines.contains(param.name.text)) {
    entry.overridden = true;
    value = defined_value(param);
    if (is_poison(value)) return value;
  }
  if (const auto* w = std::get_if<Word>(&value)) {
    entry.value = w->text;
    model_.params.push_back(entry);
    return value;
  }
  const auto* number = std::get_if<Field>(&value);
  if (!number) {
    if (!is_poison(value))
      error("E0306", param.value.span,
            fmt::format("a parameter is a number or a word, not {}", describe(value)));
    return Poison{};
  }
  if (number->rank != 0 || !is_constant(*number)) {
    if (number->rank != 0)
      error("E0306", param.value.span,
            fmt::format("a parameter is a number, not {}", describe(*number)));
    else
      check_finite(param.value.span, *number);
    return Poison{};
  }
  entry.value = number->scalar().value();
  if (!is_in_range(param, number->scalar().value(), entry)) return Poison{};
  model_.params.push_back(entry);
  return value;
}

/// What a parameter is set to from outside.
Value Checker::defined_value(const ast::Param& param) {
  const std::string& text = options_.defines.at(param.name.text);
  if (is_word(text)) return Word{text};
  if (const auto number = parse_number(text)) return scalar_field(*number);
  error(
      "E0321", Span{},
      fmt::format("{}{}={}: `{}` is no number", options_.words.define, param.name.text, text, text),
      "write a number or one of the words P1, P2, ...");
  return Poison{};
}

/// Does the value lie where the script says (else reported)? A wrong range is reported, and none.
bool Checker::is_in_range(const ast::Param& param, double v, ModelParam& entry) {
  if (!param.range) return true;
  const auto bounds = constant_list(*param.range, "the range of a parameter");
  if (!bounds || diagnostics_.has_error_in(param.range->span)) return true;
  if (bounds->size() != 2 || (*bounds)[0] > (*bounds)[1]) {
    error("E0408", param.range->span, "the range of a parameter is `[least, greatest]`");
    return true;
  }
  const double least = (*bounds)[0], greatest = (*bounds)[1];
  entry.range = fmt::format("[{}, {}]", least, greatest);
  if (v >= least && v <= greatest) return true;
  // As they stand in the script: in the parameter's unit.
  const auto* own = std::get_if<ast::Quantity>(&param.value.node);
  const auto known = own ? options_.units.find(own->unit.text) : options_.units.end();
  const UnitFactor factor = known == options_.units.end() ? UnitFactor{} : known->second;
  const auto shown = [&](double x) { return x * factor.over / factor.times; };
  error("E0408", entry.overridden ? param.name.span : param.value.span,
        fmt::format("`{}` = {} is outside its range [{}, {}]{}", param.name.text, shown(v),
                    shown(least), shown(greatest), own ? " [" + own->unit.text + "]" : ""),
        "",
        entry.overridden
            ? fmt::format("set by {}{}={}", options_.words.define, param.name.text,
                          own ? fmt::to_string(shown(v)) : options_.defines.at(param.name.text))
            : "");
  return false;
}

std::optional<Value> Checker::built_in_name(const ast::Expr& e, const std::string& name,
                                            const Scope& scope) {
  auto hidden = [&](const std::string& why, const std::string& help) -> Value {
    error("E0309", e.span, fmt::format("`{}` cannot be used{}: {}", name, visible_note(scope), why),
          help);
    return Poison{};
  };
  if (name == "pi") return scalar_field(std::numbers::pi);
  if (name == "x" || name == "y" || name == "z") {
    const int axis = name[0] - 'x';
    if (!scope.position) return hidden("it must be the same everywhere", "");
    if (axis >= model_.dim) {
      error("E0315", e.span, fmt::format("there is no `{}` in {}D", name, model_.dim));
      return Poison{};
    }
    return scalar_field(Symbol::variable(solver::slot::x(axis)));
  }
  if (name == "t") {
    if (!scope.time)
      return hidden("it does not change in time",
                    scope.lag ? "a kernel of time and past time is written `kernel q(t, s) = ...`"
                              : "");
    return scalar_field(Symbol::variable(solver::slot::t));
  }
  if (name == "lag") {
    if (!scope.lag) return hidden("only kernels have a lag", "");
    return scalar_field(Symbol::variable(solver::slot::lag));
  }
  if (name == "normal") {
    if (!scope.normal) return hidden("only integrals over the boundary have a normal", "");
    std::vector<Symbol> n;
    for (int i = 0; i < model_.dim; ++i) n.push_back(Symbol::variable(solver::slot::normal(i)));
    return vector_field(std::move(n));
  }
  if (name == "sigma") {
    if (!scope.report) return hidden("it is a result", "it may stand in `report`");
    return stress();
  }
  return std::nullopt;
}

/// Names whose mistake was reported before: they stand in a statement with an error, or have
/// letters that no name has.
bool Checker::is_silent(const std::string& name) const {
  const bool foreign = std::any_of(name.begin(), name.end(),
                                   [](char c) { return static_cast<unsigned char>(c) >= 0x80; });
  return foreign || silenced_.count(name) > 0;
}

Value Checker::unknown_name(const Span& span, const std::string& name, const Scope& scope) {
  if (is_silent(name)) return Poison{};
  const std::string near = nearest(name, scope);
  const bool may_be_imported =
      std::any_of(programs_.begin(), programs_.end(), [](const auto& p) { return p.names_lost; });
  if (near.empty() && may_be_imported) return Poison{};
  diagnostics_.add_once(
      name, diagnose("E0301", span, fmt::format("unknown name `{}`", name)).with_help(near));
  return Poison{};
}

/// Which name may be meant; looked for once, and for so many names only: each is held against all
/// that there are.
std::string Checker::nearest(const std::string& name, const Scope& scope) {
  constexpr std::size_t most_names = 100;
  const auto [known, fresh] = nearest_.try_emplace(name);
  if (!fresh || nearest_.size() > most_names) return known->second;
  Suggestion suggestion(name);
  for (const auto& [local, value] : scope.locals) suggestion.consider(local);
  for (const Declaration& d : declarations_) suggestion.consider(d.name);
  for (const std::string_view built_in : visible_built_ins()) suggestion.consider(built_in);
  if (scope.unknown && find_)
    for (const ast::Unknown& u : find_->unknowns) suggestion.consider(u.unknown.text);
  if (scope.test && find_)
    for (const ast::Unknown& u : find_->unknowns) suggestion.consider(u.test.text);
  return known->second = suggestion.help();
}

Value Checker::hidden_state(const Span& span, int declaration, const Scope& scope) {
  declarations_[declaration].used = true;
  error(
      "E0309", span,
      fmt::format("the state `{}` cannot be used{}", declarations_[declaration].name,
                  visible_note(scope)),
      "it stands in superpotentials, beside the unknown in the argument of a law, in coefficients "
      "of forms over cells, in rates and in `report`");
  return Poison{};
}

/// A derivative in time of the b-th unknown, or its test function. A law knows what it reads: there
/// it is a number like any other.
Value Checker::value_of_unknown(int unknown, int order, bool is_test, const Scope& scope) const {
  namespace slot = solver::slot;
  std::vector<Symbol> components;
  for (int i = 0; i < components_of(unknown); ++i) {
    const int of = slot::of_unknown(unknown, slot::value(i));
    components.push_back(
        Symbol::variable(is_test ? slot::test(of) : slot::field(solver::field_of_u(order), of)));
  }
  const bool vector = unknowns_of(model_.space)[static_cast<std::size_t>(unknown)].vector;
  Field f = vector ? vector_field(components) : scalar_field(components[0]);
  if (is_test || scope.unknown)
    (is_test ? f.test : f.trial) = Degree::linear;
  else
    f.read = true;
  f.rate = order > 0;
  f.acceleration = order == 2;
  if (vector && is_test)
    f.materials = {{.tested = true, .unknown = unknown}};
  else if (vector && scope.unknown)
    f.materials = {{.of = solver::field_of_u(order), .unknown = unknown}};
  return f;
}

Value Checker::reference(const ast::Expr& e, const std::string& name, const Scope& scope) {
  if (auto local = scope.locals.find(name); local != scope.locals.end()) return local->second;
  const int unknown = unknown_named(name), tested = unknown_tested_by(name);
  if ((unknown >= 0 || tested >= 0) && find_declaration(name) < 0) {
    const bool is_test = unknown < 0;
    if (is_test ? !scope.test : !(scope.unknown || scope.law)) {
      const bool one = find_->unknowns.size() == 1;
      error("E0309", e.span,
            fmt::format("`{}` is {} {} of the inequality: it cannot be used{}", name,
                        one       ? "the"
                        : is_test ? "a"
                                  : "an",
                        is_test ? "test function" : "unknown", visible_note(scope)));
      return Poison{};
    }
    if (!spaces_known_) return Poison{};
    return value_of_unknown(is_test ? tested : unknown, 0, is_test, scope);
  }
  if (auto built_in = built_in_name(e, name, scope)) return *built_in;
  const int index = find_declaration(name);
  if (index >= 0) {
    if (std::holds_alternative<ast::State>(*declarations_[index].statement) && !scope.states)
      return hidden_state(e.span, index, scope);
    return value_of(index, e.span);
  }
  if (is_word(name)) return Word{name};
  if (is_function_name(name)) {
    error("E0306", e.span, fmt::format("`{}` is a function: it is called with arguments", name),
          fmt::format("write `{}(...)`", name));
    return Poison{};
  }
  return unknown_name(e.span, name, scope);
}

void Checker::check_unused() {
  for (const Declaration& d : declarations_) {
    if (d.used || d.program != 0) continue;
    if (std::holds_alternative<ast::Mesh>(*d.statement) && !mesh_name_.empty()) {
      second_mesh(d.span);
      continue;
    }
    diagnostics_.add(diagnose("W0101", d.span, fmt::format("`{}` is never used", d.name))
                         .with_help(std::holds_alternative<ast::Fn>(*d.statement)
                                        ? "remove it, or use it in the inequality; its body is "
                                          "checked where it is called"
                                        : "remove it, or use it in the inequality"));
  }
}

void Checker::tell_facts() const {
  for (const Declaration& d : declarations_) {
    if (d.state != Declaration::State::done || is_poison(d.value)) continue;
    const auto* mesh = std::get_if<MeshValue>(&d.value);
    const auto* field = std::get_if<Field>(&d.value);
    const bool number = field && field->rank == 0 && is_constant(*field);
    options_.on_name(
        {d.span, number ? fmt::format("the number {}", field->scalar().value()) : describe(d.value),
         mesh ? groups_of(*mesh) : std::vector<std::string>{}});
  }
}

} // namespace hvi::lang
