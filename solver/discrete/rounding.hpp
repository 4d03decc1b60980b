// What rounding does to a result: random changes of the data by a unit in the last place.
#pragma once

#include "solver/linear/factorisation.hpp"
#include "solver/linear/matrix_rows.hpp"
#include "solver/linear/own_rows.hpp"
#include "solver/linear/own_stiffness.hpp"
#include "solver/linear/symmetric_blocks.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace hvi::solver {

/// What helps where a result is mostly rounding.
inline constexpr const char* better_conditioned =
    "fewer, better shaped cells, or units and stiffnesses closer to each other, make the matrix "
    "better conditioned";

/// One sample of the error of a state.
struct ErrorSample {
  Vector u;                   ///< on all dofs
  Vector xi;                  ///< a row for each multiplier
  std::vector<double> rates;  ///< the error of u', u'' is so much times u
  std::vector<double> memory; ///< that of w_m so much times u
  double share = 1.0;         ///< its share in the mean square of the samples
};

/// Samples of random rounding. A column is seldom far below its usual size in all of them: that
/// three times their root mean square is below a tenth of the true error has a probability of
/// about 1e-5 (normal errors); with two samples it would be 1e-3.
inline constexpr std::size_t n_samples = 4;
using RoundingForces = std::array<Vector, n_samples>;

/// A number in [-1, 1] that depends on the two only.
double random_unit(std::uint64_t of, std::uint64_t sample);

/// For all samples at once: force_i += sum_j e_ij s_ij v_j, where e_ij in [-unit, unit] is random,
/// but the same for entries of exactly equal size: elements of equal shape are assembled with equal
/// rounding, and their errors add up. Entries that differ in their last digits show that they were
/// rounded differently. s_ij = A_ij, but where terms of an entry cancel it knows no more than they
/// did: |s_ij| is sqrt(|A_ii A_jj|) there, and |e_ij s_ij| at most |A_ij|. size_i += sum_j
/// |A_ij v_j|.
void add_rounding(const SparseMatrix& a, const Vector& v, double unit, RoundingForces& forces,
                  Vector& size);
void add_rounding(const SymmetricBlocks& a, const Vector& v, double unit, RoundingForces& forces,
                  Vector& size);

/// The same of rows of one process (own_rows.hpp): the forces of each sample and the sizes, rows()
/// each, in `out`. v and `sizes`, the roots of |A_jj|, by column; 0: the column has no row.
void rounding_of_rows(const OwnRows& rows, int matrix, std::span<const double> v,
                      std::span<const double> sizes, double unit, std::span<double> out);

/// About eps times the condition number of D K D in the 2-norm, D_i = 1/unit[i], by one or two
/// triangular solves: with b_i = +- sum_j |K_ij| D_j of random signs, eps b^T K^-1 b / rms(D b), or
/// max_i |eps D^-1 K^-1 b|_i times the square root of the size where K has no Cholesky factor.
double rounding_growth(const SparseMatrix& k, const RowUnits& unit, Factorisation& factor);
double rounding_growth(const MatrixRows& k, const RowUnits& unit,
                       Factorisation& factor); ///< not Cholesky's
/// The b of it, and what it finds from what `forward` (factorisation.hpp) makes of b, among other
/// right-hand sides: y of the interior and r. For Cholesky factors.
Vector growth_probe(const SparseMatrix& k, const RowUnits& unit);
double rounding_growth(const Vector& b, const RowUnits& unit, const Vector& y, const Vector& r,
                       Factorisation& factor);

/// From this growth on a run refines every step with residuals in extended precision.
inline constexpr double growth_to_refine = 1e-6;

} // namespace hvi::solver
