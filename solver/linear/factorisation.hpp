// Direct solvers behind one interface, with the contact unknowns condensed out.
//
// K x = b is split as  [K_II K_Ic; K_cI K_cc] with c the contact unknowns. The interface gives the
// Schur complement S = K_cc - K_cI K_II^-1 K_Ic and two triangular solves, one before and one
// after the reduced problem:
//   reduce(b)      -> r   with  S c = r  equivalent to K x = b on c
//   back(c)        -> x   the full solution whose contact part is c
#pragma once

#include "solver/common/failure.hpp"
#include "solver/linear/sparse.hpp"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace hvi::solver {

/// A pivot below this fraction of the diagonal entry is rounding: a rigid motion is left.
inline constexpr double smallest_pivot = 1e-13;

struct FactorStatistics {
  double nonzeros = 0; ///< of the factor(s)
  double flops = 0;    ///< of one numeric factorisation
  double bytes = 0;    ///< held: the factor and its copies, S; before a factorisation: predicted
  double seconds_analyse = 0, seconds_factor = 0;
  int analyses = 0, factorisations = 0,
      triangular_solves = 0; ///< work counters; each solve, forward or backward, reads the factor
  double bytes_read = 0;     ///< of the factor, by all triangular solves
  std::string ordering;      ///< "METIS", "CAMD", ...
};

/// The matrix has no (safe) factor: a rigid motion is left, or it is not positive definite.
struct NotFactorable : Failure {
  NotFactorable(int unknown_, double pivot_, const std::string& message)
      : Failure(FailureKind::not_coercive, {}, message), unknown(unknown_), pivot(pivot_) {}
  int unknown;  ///< where the elimination broke down, in the numbering of K; -1 if not known
  double pivot; ///< the pivot relative to the diagonal entry of K; NaN if it was not finite
};

class Supernodes;

/// The parts of L, K = L L^T in an order with the contact unknowns last: for those who copy it or
/// need one of the two solves only.
struct LowerFactor {
  const Supernodes& interior; ///< structure of the columns of the interior
  const double* values;
  std::span<const double> inverse_diagonal; ///< of the interior
  std::span<const int> permutation;         ///< position -> unknown
  const DenseMatrix& contact;               ///< L22, S = L22 L22^T
};

class Factorisation {
public:
  virtual ~Factorisation() = default;
  /// Another one for matrices of the same pattern, not factored yet, which shares the analysis.
  virtual std::unique_ptr<Factorisation> another() const = 0;
  /// Numeric factorisation of a matrix with the analysed pattern. Throws Failure(not_coercive)
  /// with the offending unknown in the message when K is not positive definite / singular.
  virtual void factor(const SparseMatrix& k) = 0;
  /// Forward solve. Keeps what `back` needs; r has one entry per contact unknown, in their order.
  virtual void reduce(const Vector& b, Vector& r) = 0;
  /// Backward solve, for the last `reduce`.
  virtual void back(const Vector& c, Vector& x) = 0;
  /// What the last `reduce` keeps, one number for each unknown of the interior; linear in its b. Of
  /// a Cholesky factor L_II^-1 b_I, so that kept_a . kept_b = a_I^T K_II^-1 b_I.
  virtual Vector kept() const = 0;
  /// As if the last `reduce` had kept this.
  virtual void resume(const Vector& kept) = 0;
  /// Forward and backward solves of up to 16 right-hand sides at once, each in one reading of the
  /// factor. `reduce_each` keeps what `back_each` needs for all of them. Afterwards `back` needs a
  /// new `reduce`.
  virtual void reduce_each(std::span<const Vector> b, std::vector<Vector>& r);
  virtual void back_each(std::span<const Vector> c, std::vector<Vector>& x);
  /// Backward solves of up to 16 x_r in one reading of the factor: with the contact part c.col(r),
  /// as if sum_k weights(r, k) kept_k had been kept. x has a row for every c, and rows of zeros up
  /// to a multiple of 8; an unknown's column is place[unknown]. `back` then needs a new `reduce`.
  virtual void back_all(const DenseMatrix& c, std::span<const Vector> kept,
                        const DenseMatrix& weights, DenseMatrix& x, std::vector<int>& place);
  static constexpr int most_at_once = 16;
  /// x = K^-1 b: forward solve, S c = r, backward solve.
  virtual void solve(const Vector& b, Vector& x) = 0;
  /// x = K^-T b.
  virtual void solve_transposed(const Vector& b, Vector& x) { solve(b, x); }
  /// Of the last factorisation, valid until the next one; nothing where K has no such factor.
  virtual std::optional<LowerFactor> lower() const { return std::nullopt; }
  /// The Schur complement S, n_c by n_c. For Cholesky it is L22 L22^T, read off the factor.
  virtual const DenseMatrix& schur() const = 0;
  virtual const FactorStatistics& statistics() const = 0;

private:
  std::vector<Vector> kept_of_each_;
};

/// Fill-reducing orderings that were found before; ordering.hpp.
class OrderStore;

/// Analyses the pattern of K (symmetric pattern; `symmetric`: Cholesky through CHOLMOD, contact
/// unknowns last; else UMFPACK). `contact` lists the contact unknowns, in the order of r and c.
/// Cholesky takes the order of elimination from `known`, if given, or puts it there.
std::unique_ptr<Factorisation> analyse(const SparseMatrix& k, std::span<const int> contact,
                                       bool symmetric, OrderStore* known = nullptr);

} // namespace hvi::solver
