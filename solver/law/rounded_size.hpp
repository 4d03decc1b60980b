// What the value of a slope was made of, whose rounding it has.
#pragma once

#include "solver/law/law.hpp"

namespace hvi::solver {

/// The size of what the value of e at the argument r was added up from: its rounding is that size
/// times a few units in the last place. Functions without a rule of their own count by their value.
double size_of_rounded(const Expr& e, double r, const Point& x, const LawTime& t);

} // namespace hvi::solver
