// Of functions and laws, the most general dimensions of their arguments and of what they give: each
// argument starts as an unknown, and what the body asks of it is all that becomes known.
#include "lang/units/dimension_checker.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace hvi::lang::units {

namespace {

/// What a law gives, in the dimensions of its parameters: `stiffness [p/r]`.
constexpr const char* multiplier = "p";

} // namespace

/// By the names of the arguments whose own it is: "[stiffness*r]"; nothing where it depends on the
/// number that an exponent will be.
std::string DimensionChecker::shown_by(const Signature& names, const Dimension& dimension) const {
  const Dimension known = resolved(dimension);
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

/// Whatever an exponent is, a number has numbers for powers, and only a number does for each of
/// them.
void DimensionChecker::settle_powers() {
  for (std::size_t round = 0; round < powers_.size(); ++round)
    for (const auto& [base, power] : powers_)
      if (resolved(base).is_one() || resolved(power).is_one())
        inference_.unify(base, {}), inference_.unify(power, {});
  powers_.clear();
}

/// Empty where the body is wrong for any arguments.
std::string DimensionChecker::signature(const ast::Fn& fn) {
  Signature names;
  Locals inner;
  for (const ast::Name& p : fn.parameters)
    inner[p.text] = {names.emplace_back(p.text, inference_.fresh()).second, {}};
  const Measured out = value(fn.value, inner);
  settle_powers();
  if (!out.dimension) return {};
  std::vector<std::string> shown;
  for (const auto& [name, dimension] : names) shown.push_back(name + shown_by(names, dimension));
  return fmt::format("{}({}){}", fn.name.text, fmt::join(shown, ", "),
                     shown_by(names, *out.dimension));
}

/// With the values that its parameters have where none are given: exponents among them count.
std::string DimensionChecker::signature(const ast::Superpotential& law) {
  Signature names;
  // Unknowns made first are kept: parameters are told by the argument and the multiplier.
  const Dimension argument = names.emplace_back(law.argument.text, inference_.fresh()).second;
  const Dimension slope = names.emplace_back(multiplier, inference_.fresh()).second;
  Locals parameters;
  for (const ast::LawParameter& p : law.parameters) {
    Measured of{names.emplace_back(p.name.text, inference_.fresh()).second, {}};
    if (p.value) of.number = value(*p.value, {}).number;
    parameters[p.name.text] = of;
  }
  if (!inference_.unify(potential(law, {argument, {}}, std::move(parameters)) / argument, slope))
    return {};
  settle_powers();
  std::vector<std::string> shown;
  for (const auto& [name, dimension] : names)
    if (name != multiplier) shown.push_back(name + shown_by(names, dimension));
  return fmt::format("{}({}){}", law.name.text, fmt::join(shown, ", "), shown_by(names, slope));
}

std::vector<std::string> DimensionChecker::signatures() {
  run();
  general_ = true;
  std::vector<std::string> out;
  for (const ast::Program& program : programs_)
    for (const ast::Statement& statement : program.statements) {
      const Inference before = inference_;
      const std::size_t mistakes = diagnostics_.size();
      std::string one;
      if (const auto* fn = std::get_if<ast::Fn>(&statement)) one = signature(*fn);
      if (const auto* law = std::get_if<ast::Superpotential>(&statement)) one = signature(*law);
      if (!one.empty() && diagnostics_.size() == mistakes) out.push_back(std::move(one));
      inference_.forget_since(before); // what one body asks of a name is nothing to the next
    }
  return out;
}

std::vector<std::string> signatures(const std::vector<ast::Program>& programs, const Model& model) {
  CheckOptions options;
  Diagnostics none;
  Model unchanged = model;
  const ScriptUnits units = read_units(programs, options, none);
  return DimensionChecker(programs, units, unchanged, none).signatures();
}

} // namespace hvi::lang::units
