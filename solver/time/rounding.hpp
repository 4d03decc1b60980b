// What rounding does to a result: random changes of the data by a unit in the last place.
#pragma once

#include "solver/linear/factorisation.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace hvi::solver {

/// One sample of the error of a state.
struct ErrorSample {
  Vector u;                   ///< on all dofs
  Vector xi;                  ///< a row for each multiplier
  double rate = 0.0;          ///< the error of u' is so much times u
  std::vector<double> memory; ///< that of w_m so much times u
};

/// A number in [-1, 1] that depends on the two only.
double random_unit(std::uint64_t of, std::uint64_t sample);

/// For two samples at once: force_i += sum_j e_ij A_ij v_j, where e_ij in [-unit, unit] is random,
/// but the same for entries of equal size: elements of equal shape are assembled with equal
/// rounding, and their errors add up. size_i += sum_j |A_ij v_j|.
void add_rounding(const SparseMatrix& a, const Vector& v, double unit,
                  std::array<Vector, 2>& forces, Vector& size);

/// About eps times the condition number of K in the 2-norm, for one or two sweeps: with b_i = +-
/// sum_j |K_ij| of random signs, eps b^T K^-1 b / rms(b), or max_i |eps K^-1 b|_i times the square
/// root of the size where K has no Cholesky factor.
double rounding_growth(const SparseMatrix& k, Factorisation& factor);

/// From this growth on a run refines every step with residuals in extended precision.
inline constexpr double growth_to_refine = 1e-6;

} // namespace hvi::solver
