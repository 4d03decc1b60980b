// Decompositions of dense matrices, by LAPACK. What has no answer (a matrix that is not finite, not
// positive definite where it has to be; an iteration that did not end) gives NaN, and what is
// singular what is not finite.
#pragma once

#include "solver/linear/sparse.hpp"

#include <vector>

namespace hvi::solver {

/// Of a symmetric matrix, ascending.
Vector symmetric_eigenvalues(const DenseMatrix& a);

struct Spectrum {
  Vector values;       ///< ascending
  DenseMatrix vectors; ///< column i belongs to values[i], of length one
};
Spectrum symmetric_spectrum(const DenseMatrix& a);

/// Of a x = lambda g x, ascending; a symmetric, g symmetric and positive definite.
Vector generalised_eigenvalues(const DenseMatrix& a, const DenseMatrix& g);

/// Of any square matrix, in no order.
Eigen::VectorXcd eigenvalues(const DenseMatrix& a);

struct LeftSingular {
  Vector values;       ///< descending
  DenseMatrix vectors; ///< column i belongs to values[i]
};
LeftSingular left_singular(const DenseMatrix& a);

/// g = L L^T, g symmetric.
class DenseCholesky {
public:
  DenseCholesky() = default;
  explicit DenseCholesky(const DenseMatrix& g);
  bool positive() const { return positive_; } ///< definite; else there is no L
  DenseMatrix lower() const;                  ///< L
  Vector solve(const Vector& b) const;        ///< g^-1 b
  DenseMatrix solve(const DenseMatrix& b) const;
  DenseMatrix solve_lower(const DenseMatrix& b) const; ///< L^-1 b

private:
  DenseMatrix lower_; ///< and what was above its diagonal
  bool positive_ = true;
};

/// Is it symmetric, to this part of the roots of its diagonal's products, and positive definite?
bool is_positive_definite(const DenseMatrix& a, double rounding);

/// a = P L U with row pivoting, a square.
class DenseLu {
public:
  DenseLu() = default;
  explicit DenseLu(const DenseMatrix& a);
  Vector solve(const Vector& b, bool transposed = false) const; ///< a^-1 b, or a^-T b
  DenseMatrix solve(const DenseMatrix& b) const;
  Vector pivots() const { return factor_.diagonal().cwiseAbs(); }
  /// An estimate of 1 / (|a| |a^-1|) with the norm of the largest column.
  double inverse_condition() const;

private:
  void solve_in_place(double* b, Eigen::Index columns, char transposed) const;

  DenseMatrix factor_;
  std::vector<int> rows_; ///< swapped, counted from 1
  double norm_ = 0.0;     ///< of a
};

/// g^-1 b, g symmetric and positive definite.
DenseMatrix solve_positive(const DenseMatrix& g, const DenseMatrix& b);

/// a^-1 b, a square and regular.
DenseMatrix solve_square(const DenseMatrix& a, const DenseMatrix& b);

/// The shortest x of least |a x - b|: singular values below `dependent` of the largest count as
/// zero (a complete orthogonal decomposition, whose leading triangles stand for them). Without
/// `dependent`: those that are rounding.
DenseMatrix least_squares(const DenseMatrix& a, const DenseMatrix& b, double dependent);
DenseMatrix least_squares(const DenseMatrix& a, const DenseMatrix& b);

struct QrSolution {
  Vector x;
  DenseMatrix r; ///< upper triangle, a = Q R; as many rows as columns
};
/// min |a x - b| by Householder QR without pivoting: a has independent columns.
QrSolution solve_by_qr(const DenseMatrix& a, const Vector& b);

} // namespace hvi::solver
