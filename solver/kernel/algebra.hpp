// Taking expressions apart: sums into addends, products into factors, affine parts, separation of
// variables. What history and the lowering need to find tensors times kernels in a script's
// formula.
#pragma once

#include "solver/kernel/expr.hpp"

#include <functional>
#include <optional>
#include <utility>
#include <vector>

namespace hvi::solver {

/// e = sum of the addends, signs pushed in: a - (b - c) gives a, -b, c. 0 has none.
std::vector<Expr> addends(const Expr& e);
Expr sum_of(const std::vector<Expr>& terms);

/// e = product of the factors: a sign is the factor -1, a quotient a/b gives the factors of a and
/// the reciprocals of those of b, a whole power of a product the powers of its factors. 1 has none.
std::vector<Expr> factors(const Expr& e);

/// Products distributed over sums, whole powers of sums multiplied out, quotients split at the
/// numerator, like terms collected, equal factors cancelled. Arguments of functions stay. Parts
/// that would have too many terms stay as they are.
Expr expand(const Expr& e);

/// (a, b) with e = a + b * slot and a, b free of the slot; nothing when e is not affine in it.
std::optional<std::pair<Expr, Expr>> affine_in(const Expr& e, Slot slot);

/// The tables that e reads, and their slopes: nodes whose argument may be outside their range.
std::vector<Expr> table_readings(const Expr& e);

/// Is e >= 0 wherever it is defined, as far as its form shows? (The lag is never negative.)
bool is_nonnegative(const Expr& e);

using Separated = std::vector<std::pair<Expr, Expr>>;
/// e = sum of first_m * second_m where `second` depends only on slots that satisfy `in_second`
/// and `first` only on the others. Equal parts (up to a constant factor) are merged, constant
/// factors stand in `first`; 0 gives no terms. Nothing when e is not found to be separable.
/// Cases whose condition depends on one group become cases with 0 elsewhere.
std::optional<Separated> split_separable(const Expr& e, const std::function<bool(Slot)>& in_second);

} // namespace hvi::solver
