// Unknowns of points whose stiffness moved far from the factored one, and what a preconditioner
// needs for them (preconditioner.hpp has the formulas).
#pragma once

#include "solver/inequality/last_factor.hpp"
#include "solver/linear/dense.hpp"

#include <unordered_map>

namespace hvi::solver {

/// Points whose stiffness moved far from the factored one.
struct FarPoints {
  /// An entry of Delta on the changed unknowns.
  struct Change {
    int row, column;
    double value;
    bool held; ///< the diagonal entry of a row that is held now
  };
  std::vector<int> freed, changed; ///< R and Q
  std::vector<Change> delta;
  int most_rows = 1;        ///< of one of them
  std::vector<char> is_far; ///< by point
  std::size_t unknowns() const { return freed.size() + changed.size(); }
};

/// False when one of them shares its unknowns, or when they have more than `most` of them.
bool find_far_points(const ContactPoints& points, const PointMatrices& d,
                     const PointMatrices& d_factored, std::size_t most, FarPoints& out);

/// By unknown: M^-1 S e_i of freed ones, M^-1 e_i of changed ones.
using FarColumns = std::unordered_map<int, Vector>;
/// Adds those that are missing, in one go.
void solve_far_columns(const FarPoints& far, const ReducedOperator& s, FarColumns& columns);

/// R: Y and C.
class FreedUnknowns {
public:
  void forget(); ///< the factor is another one
  /// False: C has no factor.
  bool prepare(const FarPoints& far, const FarColumns& columns, const ReducedOperator& s,
               const SparseMatrix& h, double unit);
  const DenseMatrix& y() const { return y_; }
  Vector displaced(const Vector& t) const;                 ///< C^-1 t
  DenseMatrix compliance(const DenseMatrix& y_rows) const; ///< Y_Q C^-1 Y_Q^T

private:
  void make_block(const FarColumns& columns, const ReducedOperator& s);

  std::vector<int> unknowns_; ///< of y and block
  DenseMatrix y_, block_;     ///< Y with its rows R set to 0, S_RR - S_RF Y over `unit_`
  DenseCholesky factor_;      ///< of C over `unit_`
  double unit_ = 1.0;         ///< the body's own stiffness: over it no unit system overflows
};

/// Q: Z and 1 + Delta G.
class ChangedUnknowns {
public:
  void prepare(const FarPoints& far, const FarColumns& columns, const FreedUnknowns& freed);
  const DenseMatrix& z() const { return z_; }
  /// For x = M^-1 b; takes what the forces do at R from t = b_R - Y^T b.
  Vector forces(const FarPoints& far, const FreedUnknowns& freed, const Vector& x, Vector& t) const;

private:
  DenseMatrix z_, y_rows_; ///< Z, Y_Q
  DenseLu factor_;
};

} // namespace hvi::solver
