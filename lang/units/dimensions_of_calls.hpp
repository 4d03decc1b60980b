// Dimensions of calls: of functions, laws and what is built in.
#pragma once

#include "lang/units/dimension_context.hpp"

#include <string>
#include <vector>

namespace hvi::lang::units {

class DimensionsOfValues;

class DimensionsOfCalls {
public:
  DimensionsOfCalls(const DimensionContext& context, DimensionsOfValues& values)
      : inference_(context.inference), names_(context.names), mistakes_(context.mistakes),
        values_(values) {}

  Measured call(const ast::Expr& e, const ast::Call& c, const Locals& locals);
  Measured clarke(const ast::Clarke& c, const Locals& locals);
  Dimension potential(const ast::Superpotential& law, const Measured& argument, Locals parameters);

private:
  Measured value(const ast::Expr& e, const Locals& locals);
  Measured call_declared(const ast::Expr& e, const ast::Call& c, const ast::Statement& statement,
                         const Locals& locals);
  Measured call_law(const ast::Call& c, const ast::Superpotential& law, const Locals& locals);
  Measured call_built_in(const ast::Call& c, const std::string& name, const Locals& locals);
  Measured pointwise(const ast::Call& c, const std::string& name, const Locals& locals);
  Measured material(const ast::Call& c, const Locals& locals);
  Measured series(const ast::Call& c, const std::string& name, const Locals& locals);
  Measured history(const ast::Call& c, const Locals& locals);
  Measured over_region(const ast::Call& c, const std::string& name, const Locals& locals);
  Measured all_same(const ast::Call& c, const Locals& locals);

  Inference& inference_;
  NamedDimensions& names_;
  DimensionMistakes& mistakes_;
  DimensionsOfValues& values_;
  bool reads_law_ = false; ///< the body of a law
};

} // namespace hvi::lang::units
