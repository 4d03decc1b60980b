// Of functions and laws, the most general dimensions of their arguments and of what they give: each
// argument starts as an unknown, and what the body asks of it is all that becomes known.
#pragma once

#include "lang/units/dimensions_of_values.hpp"

#include <string>
#include <utility>
#include <vector>

namespace hvi::lang::units {

class Signatures {
public:
  Signatures(const DimensionContext& context, DimensionsOfValues& values)
      : programs_(context.programs), units_(context.units), inference_(context.inference),
        mistakes_(context.mistakes), values_(values) {}
  /// Of every function and law, also of those that nobody calls.
  std::vector<std::string> all();

private:
  /// An argument, or what a law gives.
  using Names = std::vector<std::pair<std::string, Dimension>>;
  std::string signature(const ast::Fn& fn);
  std::string signature(const ast::Superpotential& law);
  std::string shown_by(const Names& names, const Dimension& dimension) const;

  const std::vector<ast::Program>& programs_;
  const ScriptUnits& units_;
  Inference& inference_;
  DimensionMistakes& mistakes_;
  DimensionsOfValues& values_;
};

} // namespace hvi::lang::units
