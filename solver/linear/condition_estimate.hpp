// How much a linear system amplifies errors: the condition number in the 1-norm, from a few solves
// with a factor that is there already.
#pragma once

#include "solver/linear/factorisation.hpp"

#include <functional>

namespace hvi::solver {

/// ||A||_1: the largest sum of the absolute values of a column.
double norm_1(const SparseMatrix& a);

/// x -> A x of an operator that is known by its products only. `out` is none of the arguments.
using Operator = std::function<void(const Vector& x, Vector& out)>;

/// A lower bound of ||A||_1, nearly always within a factor 3 of it, from about ten products with A
/// and A^T of order n.
/// N. J. Higham, F. Tisseur, A block algorithm for matrix 1-norm estimation, with an application to
/// 1-norm pseudospectra, SIAM J. Matrix Anal. Appl. 21 (2000) 1185-1201, Algorithm 2.4, with two
/// columns; its random signs come from a fixed seed, so equal matrices have equal estimates.
double estimate_norm_1(int n, const Operator& product, const Operator& transposed_product);

/// ||K||_1 ||K^-1||_1, estimated from below with the last factor of K. Infinite where a solve is
/// not finite.
double estimate_condition(const SparseMatrix& k, Factorisation& factor);

} // namespace hvi::solver
