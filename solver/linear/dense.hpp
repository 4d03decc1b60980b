// Decompositions of small dense matrices, by Eigen. They take seconds to compile: once here, not in
// each file that needs one.
#pragma once

#include "solver/linear/sparse.hpp"

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

/// L^-1 b and (L L^T)^-1 b with g = L L^T, g symmetric and positive definite.
DenseMatrix solve_lower(const DenseMatrix& g, const DenseMatrix& b);
DenseMatrix solve_positive(const DenseMatrix& g, const DenseMatrix& b);

/// a^-1 b, a square and regular, by LU with row pivoting.
DenseMatrix solve_square(const DenseMatrix& a, const DenseMatrix& b);

/// The shortest x of least |a x - b|: singular values below `dependent` of the largest count as
/// zero (a complete orthogonal decomposition, whose pivots stand for them).
Vector shortest_least_squares(const DenseMatrix& a, const Vector& b, double dependent);

/// The shortest-residual x of a x = b, by Householder QR with column pivoting: a may have dependent
/// columns.
Vector least_squares(const DenseMatrix& a, const Vector& b);
DenseMatrix least_squares(const DenseMatrix& a, const DenseMatrix& b);

struct QrSolution {
  Vector x;
  DenseMatrix r; ///< upper triangle, a = Q R; as many rows as columns
};
/// min |a x - b| by Householder QR without pivoting: a has independent columns.
QrSolution solve_by_qr(const DenseMatrix& a, const Vector& b);

} // namespace hvi::solver
