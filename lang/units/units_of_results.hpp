// The units of what a script computes, for whoever shows it.
#pragma once

#include "lang/units/dimensions_of_values.hpp"

#include <optional>
#include <string>

namespace hvi::lang::units {

class UnitsOfResults {
public:
  UnitsOfResults(const DimensionContext& context, DimensionsOfValues& values)
      : units_(context.units), model_(context.model), inference_(context.inference),
        names_(context.names), values_(values) {}
  void tell_model();

private:
  std::string unit_of(const Dimension& dimension) const;
  std::optional<Dimension> energy_of_form() const;
  void tell_report();
  void tell_params();
  void tell_range(ModelParam& p, const ast::Expr& range);
  void tell_ladders();

  const ScriptUnits& units_;
  Model& model_;
  Inference& inference_;
  NamedDimensions& names_;
  DimensionsOfValues& values_;
};

} // namespace hvi::lang::units
