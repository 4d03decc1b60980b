// Matrices for the tests of the direct solvers, assembled here and independent of the engine:
// P1 elasticity on structured meshes, graph Laplacians, random positive definite matrices.
#pragma once

#include "solver/linear/sparse.hpp"

#include <vector>

namespace hvi::solver::test {

/// K with the unknowns of one side set apart.
struct Problem {
  SparseMatrix k;
  std::vector<int> contact;
};

/// Plane-strain P1 elasticity on (0,2)x(0,1), 2n x n squares cut by a diagonal, roof clamped;
/// contact: all unknowns of the ground. Two unknowns per node.
Problem slab(int n, double lambda = 1.3, double mu = 0.9);

/// P1 elasticity on the cube of n^3 cells, each cut in Kuhn's six; roof clamped, ground contact.
Problem cube(int n, double lambda = 1.3, double mu = 0.9);

/// -Laplace on an n x n grid (five points) plus `shift`: positive definite for shift >= 0.
SparseMatrix grid_laplacian(int n, double shift = 0.0);

/// A random symmetric, diagonally dominant matrix of `n` unknowns.
SparseMatrix random_definite(int n, double density, unsigned seed);

/// K plus a skew part on its pattern: unsymmetric, with the same symmetric part.
SparseMatrix with_skew_part(const SparseMatrix& k, double factor, unsigned seed);

/// Block diagonal of two matrices.
SparseMatrix side_by_side(const SparseMatrix& a, const SparseMatrix& b);

/// n numbers in [-1, 1].
Vector random_vector(Eigen::Index n, unsigned seed);

/// max_i |a_i - b_i| / |b_i|
double largest_error(const Vector& a, const Vector& b);

} // namespace hvi::solver::test
