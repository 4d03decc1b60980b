// Which forms are multiples of one another.
#pragma once

#include "solver/discrete/state.hpp"
#include "solver/plan/problem.hpp"

#include <optional>

namespace hvi::solver {

/// c with  a = c b  when it can be seen without assembling: the same part and rule, and written
/// with one tensor; else entries whose coefficients are proportional constants, or the same
/// expressions up to constant factors.
std::optional<double> symbolic_ratio(const FormTerm& a, const FormTerm& b);

/// c with  a = c b  to rounding, entry by entry, for matrices of one pattern.
std::optional<double> numeric_ratio(const SparseMatrix& a, const SparseMatrix& b);

/// c with  a = c b  for two columns of weights.
std::optional<double> column_ratio(const Vector& a, const Vector& b);

} // namespace hvi::solver
