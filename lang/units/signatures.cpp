#include "lang/units/signatures.hpp"

#include "solver/common/joined.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace hvi::lang::units {

namespace {

/// What a law gives, in the dimensions of its parameters: `stiffness [p/r]`.
constexpr const char* multiplier = "p";

} // namespace

/// By the names of the arguments whose own it is: "[stiffness*r]"; nothing where it depends on the
/// number that an exponent will be.
std::string Signatures::shown_by(const Names& names, const Dimension& dimension) const {
  const Dimension known = inference_.resolved(dimension);
  Product factors;
  for (const auto& [which, power] : known.unknowns()) {
    const auto name =
        std::ranges::find_if(names, [unknown = Dimension::unknown(which)](const auto& one) {
          return one.second == unknown;
        });
    if (name == names.end()) return "";
    factors.emplace_back(name->first, power);
  }
  for (const auto& factor : units_.system.product(Dimension(known.powers())))
    factors.push_back(factor);
  return fmt::format(" [{}]", product_text(factors));
}

/// Empty where the body is wrong for any arguments.
std::string Signatures::signature(const ast::Fn& fn) {
  Names names;
  Locals inner;
  for (const ast::Name& p : fn.parameters)
    inner[p.text] = {names.emplace_back(p.text, inference_.fresh()).second, {}};
  const Measured out = values_.value(fn.value, inner);
  values_.settle_powers();
  if (!out.dimension) return {};
  std::vector<std::string> shown;
  for (const auto& [name, dimension] : names) shown.push_back(name + shown_by(names, dimension));
  return fmt::format("{}({}){}", fn.name.text, solver::joined(shown),
                     shown_by(names, *out.dimension));
}

/// With the values that its parameters have where none are given: exponents among them count.
std::string Signatures::signature(const ast::Superpotential& law) {
  Names names;
  // Unknowns made first are kept: parameters are told by the argument and the multiplier.
  const Dimension argument = names.emplace_back(law.argument.text, inference_.fresh()).second;
  const Dimension slope = names.emplace_back(multiplier, inference_.fresh()).second;
  Locals parameters;
  for (const ast::LawParameter& p : law.parameters) {
    Measured of{names.emplace_back(p.name.text, inference_.fresh()).second, {}};
    if (p.value) of.number = values_.value(*p.value, {}).number;
    parameters[p.name.text] = of;
  }
  if (!inference_.unify(values_.potential(law, {argument, {}}, std::move(parameters)) / argument,
                        slope))
    return {};
  values_.settle_powers();
  std::vector<std::string> shown;
  for (const auto& [name, dimension] : names)
    if (name != multiplier) shown.push_back(name + shown_by(names, dimension));
  return fmt::format("{}({}){}", law.name.text, solver::joined(shown), shown_by(names, slope));
}

std::vector<std::string> Signatures::all() {
  values_.be_general();
  std::vector<std::string> out;
  for (const ast::Program& program : programs_)
    for (const ast::Statement& statement : program.statements) {
      const Inference before = inference_;
      const std::size_t mistakes = mistakes_.count();
      std::string one;
      if (const auto* fn = std::get_if<ast::Fn>(&statement)) one = signature(*fn);
      if (const auto* law = std::get_if<ast::Superpotential>(&statement)) one = signature(*law);
      if (!one.empty() && mistakes_.count() == mistakes) out.push_back(std::move(one));
      inference_.forget_since(before); // what one body asks of a name is nothing to the next
    }
  return out;
}

} // namespace hvi::lang::units
