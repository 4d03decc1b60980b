#include "solver/linear/separate.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <optional>

namespace hvi::solver::test {
namespace {

constexpr int n_contact = 3, size = 6;

/// diag(S, D): S = 4 on the diagonal, 1 elsewhere; D = 2, 3, 4.
DenseMatrix plain() {
  DenseMatrix k = DenseMatrix::Zero(size, size);
  k.topLeftCorner(n_contact, n_contact).setOnes();
  for (int i = 0; i < n_contact; ++i) k(i, i) = 4.0;
  for (int i = n_contact; i < size; ++i) k(i, i) = i - 1.0;
  return k;
}

SparseMatrix sparse(const DenseMatrix& k) { return k.sparseView(); }

/// With an entry in the pattern, also where it is zero.
SparseMatrix with_entry(int i, int j, double value) {
  SparseMatrix k = sparse(plain());
  k.coeffRef(i, j) = value;
  return k;
}

std::optional<FailureKind> refusal(const SparseMatrix& k) {
  try {
    separate_factor(n_contact, size)->factor(k);
  } catch (const Failure& failure) {
    return failure.kind;
  }
  return std::nullopt;
}

TEST(Separate, SolvesAsADenseFactorDoes) {
  const auto factor = separate_factor(n_contact, size);
  factor->factor(sparse(plain()));
  EXPECT_EQ(factor->statistics().ordering, "none");
  EXPECT_TRUE(factor->schur().isApprox(plain().topLeftCorner(n_contact, n_contact)));
  const Vector b = Vector::LinSpaced(size, 1.0, 6.0);
  Vector x;
  solve(*factor, b, x);
  EXPECT_TRUE(x.isApprox(plain().ldlt().solve(b), 1e-14)) << x.transpose();
}

TEST(Separate, RefusesEveryMatrixThatCouplesMore) {
  EXPECT_FALSE(refusal(with_entry(0, 4, 0.0))); // a zero couples nothing
  for (const int i : {0, 3, 5}) {
    SparseMatrix k = with_entry(i, 4, 1e-3);
    EXPECT_EQ(refusal(k), FailureKind::bad_value) << i;
    k.coeffRef(5, 3) = 0.0; // what comes after it does not matter
    EXPECT_EQ(refusal(k), FailureKind::bad_value) << i;
  }
  EXPECT_EQ(refusal(SparseMatrix(size + 1, size + 1)), FailureKind::bad_value);
}

/// Every unknown in turn has no stiffness.
TEST(Separate, SaysWhichUnknownHasNoStiffness) {
  for (int i = 0; i < size; ++i) {
    DenseMatrix k = plain();
    k.row(i).setZero();
    k.col(i).setZero();
    SparseMatrix matrix = sparse(k);
    matrix.coeffRef(i, i) = 0.0;
    try {
      separate_factor(n_contact, size)->factor(matrix);
      FAIL() << "it has no factor";
    } catch (const NotFactorable& failure) {
      EXPECT_EQ(failure.unknown, i);
    }
  }
}

} // namespace
} // namespace hvi::solver::test
