// Sparse matrices and dense vectors of the engine. Eigen's types under the engine's names.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace hvi::solver {

using Vector = Eigen::VectorXd;
using DenseMatrix = Eigen::MatrixXd;
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor, int>;

} // namespace hvi::solver
