#include "solver/assembly/range.hpp"

namespace hvi::solver {

DenseMatrix basis_of_range(const DenseMatrix& rows, int& rank) {
  const Eigen::Index n = rows.rows();
  DenseMatrix candidates(n, rows.cols() + n);
  candidates << rows, DenseMatrix::Identity(n, n);
  DenseMatrix basis(n, 0);
  rank = 0;
  constexpr double rank_tolerance = 1e-10;
  const double scale = rows.cwiseAbs().maxCoeff();
  // Columns of `rows` while they are independent, unit vectors afterwards.
  for (Eigen::Index from = 0, count = rows.cols(); basis.cols() < n;) {
    Eigen::Index longest = 0;
    const auto norms = candidates.middleCols(from, count).colwise().norm();
    const double length = norms.maxCoeff();
    // The first of (nearly) equal columns: rounding must not choose.
    while (norms(longest) < length * (1.0 - 1e-6)) {
      ++longest;
    }
    if (from == 0 && length <= rank_tolerance * scale) {
      from = rows.cols();
      count = n;
      continue;
    }
    rank += from == 0 ? 1 : 0;
    basis.conservativeResize(n, basis.cols() + 1);
    Eigen::VectorXd q = candidates.col(from + longest).normalized();
    q -= basis.leftCols(basis.cols() - 1) * (basis.leftCols(basis.cols() - 1).transpose() * q);
    q.normalize();
    basis.col(basis.cols() - 1) = q;
    candidates -= q * (q.transpose() * candidates);
  }
  return basis;
}

} // namespace hvi::solver
