#include "lang/units/dimensions_of_calls.hpp"

#include "lang/check/builtins.hpp"
#include "lang/units/dimensions_of_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace hvi::lang::units {

namespace {

using Arguments = std::vector<const ast::Expr*>;

/// The arguments in the order of `names`, by position or by name; null where one is left out.
Arguments matched(const ast::Call& c, const std::vector<std::string>& names) {
  Arguments out(names.size(), nullptr);
  std::size_t next = 0;
  for (const ast::Argument& a : c.arguments) {
    std::size_t at = next;
    if (a.name)
      at = static_cast<std::size_t>(std::ranges::find(names, a.name->text) - names.begin());
    else
      ++next;
    if (at < out.size()) out[at] = &a.value;
  }
  return out;
}

} // namespace

Measured DimensionsOfCalls::value(const ast::Expr& e, const Locals& locals) {
  return values_.value(e, locals);
}

Measured DimensionsOfCalls::call(const ast::Expr& e, const ast::Call& c, const Locals& locals) {
  const auto* r = std::get_if<ast::Reference>(&c.callee->node);
  if (r == nullptr) return {};
  const BuiltIn* built_in = find_built_in(r->name);
  if (const MeasuredDeclaration* found = names_.declaration(r->name)) {
    const bool law = std::holds_alternative<ast::Superpotential>(*found->statement);
    if (!law || reads_law_ || built_in == nullptr)
      return call_declared(e, c, *found->statement, locals);
  }
  return built_in ? call_built_in(c, r->name, locals) : Measured{};
}

Measured DimensionsOfCalls::call_declared(const ast::Expr& e, const ast::Call& c,
                                          const ast::Statement& statement, const Locals& locals) {
  Measured out;
  if (const auto* law = std::get_if<ast::Superpotential>(&statement)) {
    mistakes_.enter_call(e.span);
    out = call_law(c, *law, locals);
    mistakes_.leave_call();
  } else if (const auto* fn = std::get_if<ast::Fn>(&statement)) {
    std::vector<std::string> names;
    for (const ast::Name& p : fn->parameters) names.push_back(p.text);
    const Arguments given = matched(c, names);
    Locals inner;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (given[i] == nullptr) return {};
      inner[names[i]] = value(*given[i], locals);
    }
    mistakes_.enter_call(e.span);
    out = value(fn->value, inner);
    mistakes_.leave_call();
  }
  return out;
}

/// Inside the body of another law: its potential, whichever way it is written.
Measured DimensionsOfCalls::call_law(const ast::Call& c, const ast::Superpotential& law,
                                     const Locals& locals) {
  std::vector<std::string> names{law.argument.text};
  for (const ast::LawParameter& p : law.parameters) names.push_back(p.name.text);
  const Arguments given = matched(c, names);
  if (given[0] == nullptr) return {};
  const Measured argument = value(*given[0], locals);
  if (!argument.dimension) return {};
  Locals parameters;
  for (std::size_t i = 1; i < names.size(); ++i) {
    const auto& otherwise = law.parameters[i - 1].value;
    if (given[i] != nullptr)
      parameters[names[i]] = value(*given[i], locals);
    else if (otherwise)
      parameters[names[i]] = value(*otherwise, Locals(parameters));
  }
  return {potential(law, argument, std::move(parameters)), {}};
}

/// Arguments that all have one dimension: it.
Measured DimensionsOfCalls::all_same(const ast::Call& c, const Locals& locals) {
  Measured first;
  const ast::Expr* place = nullptr;
  const std::string name = std::get<ast::Reference>(c.callee->node).name;
  for (const ast::Argument& a : c.arguments) {
    const Measured now = value(a.value, locals);
    if (!now.dimension) return {};
    if (place == nullptr)
      first = now, place = &a.value;
    else if (!mistakes_.same({&first, place}, {&now, &a.value},
                             fmt::format("the arguments of `{}`", name)))
      return {};
  }
  return {first.dimension, {}};
}

Measured DimensionsOfCalls::call_built_in(const ast::Call& c, const std::string& name,
                                          const Locals& locals) {
  const auto argument = [&](std::size_t i) {
    return i < c.arguments.size() ? value(c.arguments[i].value, locals) : Measured{};
  };
  switch (find_built_in(name)->kind) {
  case BuiltInKind::pointwise:
    return pointwise(c, name, locals);
  case BuiltInKind::differential: {
    const Measured of = argument(0);
    return of.dimension ? Measured{*of.dimension / length(), {}} : Measured{};
  }
  case BuiltInKind::algebraic: {
    if (name == "identity") return {Dimension{}, {}};
    if (name != "dot") return {argument(0).dimension, {}};
    const Measured left = argument(0), right = argument(1);
    if (!left.dimension || !right.dimension) return {};
    return {*left.dimension * *right.dimension, {}};
  }
  case BuiltInKind::tensor:
    return name == "isotropic" || name == "orthotropic" || name == "transverse" || name == "voigt"
               ? material(c, locals)
               : series(c, name, locals);
  case BuiltInKind::memory:
    return history(c, locals);
  case BuiltInKind::interface:
    return name == "gap" ? Measured{length(), {}} : Measured{argument(0).dimension, {}};
  case BuiltInKind::region:
    return over_region(c, name, locals);
  case BuiltInKind::mesh:
    return {};
  }
  return {};
}

Measured DimensionsOfCalls::pointwise(const ast::Call& c, const std::string& name,
                                      const Locals& locals) {
  if (name == "max" || name == "min") return all_same(c, locals);
  if (name == "atan2") {
    const Measured of = all_same(c, locals);
    return of.dimension ? Measured{Dimension{}, {}} : Measured{};
  }
  std::vector<Measured> given;
  for (const ast::Argument& a : c.arguments) given.push_back(value(a.value, locals));
  if (given.empty() || !given[0].dimension) return {};
  const auto& number = given[0].number;
  if (name == "abs" || name == "pos") {
    if (!number) return given[0];
    return {given[0].dimension, name == "abs" ? std::abs(*number) : std::max(*number, 0.0)};
  }
  if (name == "sqrt")
    return {given[0].dimension->to(Rational(1, 2)),
            number ? std::optional(std::sqrt(*number)) : std::nullopt};
  if (name == "sign") return {Dimension{}, {}};
  for (std::size_t i = 0; i < given.size(); ++i)
    if (!mistakes_.wants_number(c.arguments[i].value, given[i],
                                fmt::format("the argument of `{}`", name)))
      return {};
  return {Dimension{}, {}};
}

/// Moduli, ratios and axes: their names say which.
Measured DimensionsOfCalls::material(const ast::Call& c, const Locals& locals) {
  Measured modulus;
  const ast::Expr* place = nullptr;
  for (const ast::Argument& a : c.arguments) {
    const std::string name = a.name ? a.name->text : "";
    const Measured now = value(a.value, locals);
    if (name == "axis" || name == "axes") continue;
    if (name.starts_with("poisson") || name.starts_with("nu")) {
      if (!mistakes_.wants_number(a.value, now, "a Poisson's ratio")) return {};
      continue;
    }
    if (!now.dimension) return {};
    if (place == nullptr)
      modulus = now, place = &a.value;
    else if (!mistakes_.same({&modulus, place}, {&now, &a.value}, "the moduli of a material"))
      return {};
  }
  return {modulus.dimension, {}};
}

/// prony, prony_relaxation, derivative, table.
Measured DimensionsOfCalls::series(const ast::Call& c, const std::string& name,
                                   const Locals& locals) {
  if (name == "table") { // the file has numbers in the units of the script
    for (const ast::Argument& a : c.arguments) value(a.value, locals);
    return {Dimension{}, {}};
  }
  if (name == "derivative") {
    const Measured of = c.arguments.empty() ? Measured{} : value(c.arguments[0].value, locals);
    return of.dimension ? Measured{*of.dimension / duration(), {}} : Measured{};
  }
  const Arguments given = matched(c, {"weights", "times"});
  if (given[0] == nullptr || given[1] == nullptr) return {};
  const Measured weights = value(*given[0], locals), times = value(*given[1], locals);
  if (!times.dimension || !weights.dimension ||
      !mistakes_.wants({&times, given[1]}, duration(), "the times of a Prony series"))
    return {};
  return {name == "prony" ? *weights.dimension : *weights.dimension / duration(), {}};
}

/// int_0^t C(t - s) w(s) ds
Measured DimensionsOfCalls::history(const ast::Call& c, const Locals& locals) {
  const Arguments given = matched(c, {"kernel", "of"});
  if (given[0] == nullptr || given[1] == nullptr) return {};
  const auto* r = std::get_if<ast::Reference>(&given[0]->node);
  const Measured of = value(*given[1], locals);
  const auto* kernel = r ? names_.declared_as<ast::Kernel>(r->name) : nullptr;
  if (kernel == nullptr || !of.dimension) return {};
  Locals times;
  for (const ast::Name& p : kernel->parameters) times[p.text] = {duration(), {}};
  mistakes_.enter_call(given[0]->span);
  const Measured body = value(kernel->value, times);
  mistakes_.leave_call();
  if (!body.dimension) return {};
  names_.of_kernel.insert_or_assign(r->name, *body.dimension);
  return {*body.dimension * duration() * *of.dimension, {}};
}

Measured DimensionsOfCalls::over_region(const ast::Call& c, const std::string& name,
                                        const Locals& locals) {
  const Arguments given = matched(c, {"part", "of"});
  const auto word = [](const ast::Expr* e) {
    return e == nullptr ? nullptr : std::get_if<ast::Reference>(&e->node);
  };
  if (name == "reaction") {
    std::size_t of = names_.vector_unknown();
    if (const auto* r = word(given[1])) of = names_.unknown(r->name).value_or(of);
    return of < names_.of_unknown.size() ? Measured{names_.force(of), {}} : Measured{};
  }
  if (given[1] == nullptr) return {};
  const Measured of = value(*given[1], locals);
  if (!of.dimension) return {};
  if (name != "integral") return {*of.dimension, {}};
  const auto* part = word(given[0]);
  return {*of.dimension * names_.measure_of(part ? part->name : ""), {}};
}

/// j^0(r; s) is the potential's change along s: of the dimension j s/r.
Measured DimensionsOfCalls::clarke(const ast::Clarke& c, const Locals& locals) {
  const Measured at = value(*c.at, locals), direction = value(*c.direction, locals);
  const auto* r = std::get_if<ast::Reference>(&c.law->node);
  const auto* law = r ? names_.declared_as<ast::Superpotential>(r->name) : nullptr;
  if (law == nullptr || !at.dimension || !direction.dimension) return {};
  mistakes_.enter_call(c.law->span);
  Locals parameters;
  for (const ast::LawParameter& p : law->parameters)
    if (p.value) parameters[p.name.text] = value(*p.value, parameters);
  const Dimension slope = potential(*law, at, std::move(parameters)) / *at.dimension;
  mistakes_.leave_call();
  inference_.unify(names_.multiplier(r->name), slope);
  names_.of_argument[r->name] = *at.dimension;
  return {slope * *direction.dimension, {}};
}

/// Of a law's potential: its body, or its slope times its argument.
Dimension DimensionsOfCalls::potential(const ast::Superpotential& law, const Measured& argument,
                                       Locals parameters) {
  parameters[law.argument.text] = {argument.dimension, {}};
  const bool outer = reads_law_;
  reads_law_ = true;
  const Measured body = value(law.value, parameters);
  reads_law_ = outer;
  if (!body.dimension) return inference_.fresh();
  return law.by_slope ? *body.dimension * *argument.dimension : *body.dimension;
}

} // namespace hvi::lang::units
