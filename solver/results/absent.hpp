// Fields of unknowns that live on a part of the body only: pictures are grey elsewhere.
#pragma once

#include "solver/fem/space.hpp"
#include "solver/plan/report.hpp"

#include <span>

namespace hvi::solver {

/// NaN where an unknown that the field reads does not live: of its values by node or by cell, all
/// components of one behind the other. Fields that tell parts apart have said what they are
/// elsewhere.
void forget_where_absent(const Space& space, const FieldSpec& field, bool on_cells,
                         std::span<double> values);

} // namespace hvi::solver
