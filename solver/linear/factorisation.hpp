// Direct solvers behind one interface, with the contact unknowns condensed out.
//
// K x = b is split as  [K_II K_Ic; K_cI K_cc] with c the contact unknowns, which are eliminated
// last. The interface gives the Schur complement S = K_cc - K_cI K_II^-1 K_Ic and two triangular
// solves, one before and one after the reduced problem; both work in place on a vector y in the
// order of elimination, [y_I; y_c], and keep nothing between them:
//   forward    y = b       ->  y_c = r  with  S c = r  equivalent to K x = b on c
//   back       y, y_c = c  ->  y = x, the full solution whose contact part is c
#pragma once

#include "solver/common/factor_entries.hpp"
#include "solver/common/failure.hpp"
#include "solver/linear/elimination_order.hpp"
#include "solver/linear/iteration_work.hpp"

#include <memory>
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
  IterationWork iterative;   ///< where iterations stand in for a factor
  std::string ordering;      ///< "METIS", "CAMD", ...
  FactorEntries entries = FactorEntries::doubles;
  double left = 0.0; ///< of an error, by a correction with a factor of singles
};

/// The matrix has no (safe) factor: a rigid motion is left, or it is not positive definite.
struct NotFactorable : Failure {
  NotFactorable(int unknown_, double pivot_, const std::string& message)
      : Failure(FailureKind::not_coercive, {}, message), unknown(unknown_), pivot(pivot_) {}
  int unknown;  ///< where the elimination broke down, in the numbering of K; -1 if not known
  double pivot; ///< the pivot relative to the diagonal entry of K; NaN if it was not finite
};

/// With which columns of the factor a triangular solve is made.
enum class Columns {
  interior,  ///< those of the interior: the contact unknowns are condensed
  all,       ///< y = K^-1 b after both solves; of one right-hand side
  transposed ///< y = K^-T b, the same
};

class Factorisation {
public:
  virtual ~Factorisation() = default;
  /// Another one for matrices of the same pattern, not factored yet, which shares the analysis.
  virtual std::unique_ptr<Factorisation> another() const = 0;
  /// Numeric factorisation of a matrix with the analysed pattern. Throws NotFactorable, which knows
  /// the unknown, where K is not positive definite or singular.
  virtual void factor(const SparseMatrix& k) = 0;
  /// Forward solve, in place. What it leaves in y_I is linear in b; of a Cholesky factor it is
  /// L_II^-1 b_I, so that y_I(a) . y_I(b) = a_I^T K_II^-1 b_I.
  virtual void forward(RightHandSides y, Columns columns) = 0;
  /// Backward solve, in place, of what a forward solve left in y_I and the y_c given since.
  virtual void back(RightHandSides y, Columns columns) = 0;
  /// The Schur complement S, n_c by n_c. For Cholesky it is what the elimination leaves of K.
  virtual const DenseMatrix& schur() const = 0;
  /// In place, S^-1 columns of size 1 to six digits, by a factor of S; false where there is none.
  virtual bool solve_schur(DenseMatrix& /*columns*/) const { return false; }
  virtual const EliminationOrder& order() const = 0;
  virtual const FactorStatistics& statistics() const = 0;
};

/// y = the forward solve of b, and r = y_c.
void forward(Factorisation& factor, const Vector& b, Vector& y, Vector& r);
/// x with the contact part c, from the y of `forward`, which is used up.
void back(Factorisation& factor, const Vector& c, Vector& y, Vector& x);
/// The same for several right-hand sides in one reading of the factor.
void forward(Factorisation& factor, std::span<const Vector> b, DenseMatrix& y,
             std::vector<Vector>& r);
void back(Factorisation& factor, std::span<const Vector> c, DenseMatrix& y, std::vector<Vector>& x);
/// x = K^-1 b, or K^-T b.
void solve(Factorisation& factor, const Vector& b, Vector& x, Columns columns = Columns::all);

/// Fill-reducing orderings that were found before; ordering.hpp.
class OrderStore;

/// Analyses the pattern of K (symmetric pattern; `symmetric`: Cholesky through CHOLMOD, contact
/// unknowns last; else UMFPACK). `contact` lists the contact unknowns, in the order of r and c.
/// Cholesky takes the order of elimination from `known`, if given, or puts it there. `entries`: of
/// a Cholesky factor; where those of singles would leave much of an error they become doubles.
std::unique_ptr<Factorisation> analyse(const SparseMatrix& k, std::span<const int> contact,
                                       bool symmetric, OrderStore* known = nullptr,
                                       FactorEntries entries = FactorEntries::doubles);

} // namespace hvi::solver
