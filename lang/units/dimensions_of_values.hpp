// Dimensions of expressions.
#pragma once

#include "lang/units/dimensions_of_calls.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace hvi::lang::units {

class DimensionsOfValues {
public:
  explicit DimensionsOfValues(const DimensionContext& context)
      : units_(context.units), model_(context.model), inference_(context.inference),
        names_(context.names), mistakes_(context.mistakes), calls_(context, *this) {}

  Measured value(const ast::Expr& e, const Locals& locals);
  void condition(const ast::Condition& c, const Locals& locals);
  /// Of a parameter, tensor or state.
  Measured declared(MeasuredDeclaration& declaration);
  /// Of a law's potential: its body, or its slope times its argument.
  Dimension potential(const ast::Superpotential& law, const Measured& argument,
                      const Locals& parameters) {
    return calls_.potential(law, argument, parameters);
  }

  /// From now on no body is read for a call: an exponent may become any number.
  void be_general() { general_ = true; }
  /// Whatever an exponent is, a number has numbers for powers, and only a number does for each of
  /// them.
  void settle_powers();

private:
  Measured value_of_node(const ast::Expr& e, const Locals& locals);
  Measured literal(double number);
  Measured quantity(const ast::Quantity& q, const Locals& locals);
  Measured reference(const std::string& name, const Locals& locals);
  Measured built_in_name(const std::string& name);
  Measured list(const ast::List& l, const Locals& locals);
  Measured binary(const ast::Binary& b, const Locals& locals);
  Measured power(const ast::Binary& b, const Measured& base, const Measured& exponent);
  Measured member(const ast::Member& m, const Locals& locals);
  Measured cases(const ast::Cases& c, const Locals& locals);

  const ScriptUnits& units_;
  const Model& model_;
  Inference& inference_;
  NamedDimensions& names_;
  DimensionMistakes& mistakes_;
  DimensionsOfCalls calls_;
  long evaluations_ = 0;
  bool general_ = false;
  std::vector<std::pair<Dimension, Dimension>> powers_; ///< then: bases and what they give
};

} // namespace hvi::lang::units
