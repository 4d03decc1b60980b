// What all parts of the pass share, and what is given to each of them when it is made.
#pragma once

#include "lang/units/dimension_mistakes.hpp"

namespace hvi::lang::units {

struct DimensionContext {
  const std::vector<ast::Program>& programs;
  const ScriptUnits& units;
  Model& model;
  Inference& inference;
  NamedDimensions& names;
  DimensionMistakes& mistakes;
};

} // namespace hvi::lang::units
