// See dense.hpp.
#include "solver/linear/dense.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace hvi::solver {

Vector symmetric_eigenvalues(const DenseMatrix& a) {
  return Eigen::SelfAdjointEigenSolver<DenseMatrix>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

Spectrum symmetric_spectrum(const DenseMatrix& a) {
  const Eigen::SelfAdjointEigenSolver<DenseMatrix> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Vector generalised_eigenvalues(const DenseMatrix& a, const DenseMatrix& g) {
  return Eigen::GeneralizedSelfAdjointEigenSolver<DenseMatrix>(a, g, Eigen::EigenvaluesOnly)
      .eigenvalues();
}

Eigen::VectorXcd eigenvalues(const DenseMatrix& a) {
  return Eigen::EigenSolver<DenseMatrix>(a, false).eigenvalues();
}

LeftSingular left_singular(const DenseMatrix& a) {
  const Eigen::JacobiSVD<DenseMatrix> svd(a, Eigen::ComputeThinU);
  return {svd.singularValues(), svd.matrixU()};
}

DenseMatrix solve_lower(const DenseMatrix& g, const DenseMatrix& b) {
  return g.llt().matrixL().solve(b);
}

DenseMatrix solve_positive(const DenseMatrix& g, const DenseMatrix& b) { return g.llt().solve(b); }

DenseMatrix solve_square(const DenseMatrix& a, const DenseMatrix& b) {
  if (b.size() == 0) return b; // Eigen 3.4 makes a reference to no number
  return a.partialPivLu().solve(b);
}

Vector shortest_least_squares(const DenseMatrix& a, const Vector& b, double dependent) {
  Eigen::CompleteOrthogonalDecomposition<DenseMatrix> least;
  least.setThreshold(dependent);
  least.compute(a);
  return least.solve(b);
}

Vector least_squares(const DenseMatrix& a, const Vector& b) {
  return a.colPivHouseholderQr().solve(b);
}

DenseMatrix least_squares(const DenseMatrix& a, const DenseMatrix& b) {
  return a.colPivHouseholderQr().solve(b);
}

QrSolution solve_by_qr(const DenseMatrix& a, const Vector& b) {
  const Eigen::HouseholderQR<DenseMatrix> qr(a);
  return {qr.solve(b), qr.matrixQR().topRows(a.cols()).triangularView<Eigen::Upper>()};
}

} // namespace hvi::solver
