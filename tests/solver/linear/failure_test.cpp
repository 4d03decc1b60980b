// What the direct solvers refuse, and what they count.
#include "matrices.hpp"
#include "solver/linear/factorisation.hpp"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <cmath>

namespace hvi::solver::test {
namespace {

/// The failing unknown, or -2 if the factorisation went through.
int failing_unknown(const SparseMatrix& k, const std::vector<int>& contact, bool symmetric) {
  const auto factorisation = analyse(k, contact, symmetric);
  try {
    factorisation->factor(k);
  } catch (const NotFactorable& failure) {
    EXPECT_EQ(failure.kind, FailureKind::not_coercive);
    return failure.unknown;
  }
  return -2;
}

TEST(NotFactorableMatrix, NamesANegativePivot) {
  SparseMatrix k = random_definite(50, 0.1, 3);
  for (const int bad : {0, 23, 49}) {
    SparseMatrix broken = k;
    for (SparseMatrix::InnerIterator entry(broken, bad); entry; ++entry)
      if (entry.col() == bad) entry.valueRef() = -1000.0;
    EXPECT_EQ(failing_unknown(broken, {}, true), bad);
    EXPECT_EQ(failing_unknown(broken, {5, bad}, true), bad);
  }
}

/// The slab without its clamped roof has three rigid motions.
SparseMatrix free_body(int n) {
  const SparseMatrix neumann = grid_laplacian(n);
  SparseMatrix k = neumann;
  for (int row = 0; row < k.rows(); ++row) {
    double sum = 0.0;
    for (SparseMatrix::InnerIterator entry(k, row); entry; ++entry)
      if (entry.col() != row) sum -= entry.value();
    k.coeffRef(row, row) = sum;
  }
  return k;
}

TEST(NotFactorableMatrix, FindsAFreeBody) {
  for (const int n : {2, 5, 20, 60, 150}) {
    const SparseMatrix loose = free_body(n);
    EXPECT_GE(failing_unknown(loose, {}, true), 0) << n;
    EXPECT_GE(failing_unknown(loose, {0, 1}, true), 0) << n;
    EXPECT_GE(failing_unknown(loose, {}, false), 0) << n;
    // A free body beside a held one: the unknown belongs to the free one.
    const SparseMatrix held = grid_laplacian(7);
    EXPECT_GE(failing_unknown(side_by_side(held, loose), {3}, true), 49) << n;
    EXPECT_LT(failing_unknown(side_by_side(loose, held), {}, true), n * n) << n;
    EXPECT_LT(failing_unknown(side_by_side(loose, held), {}, false), n * n) << n;
  }
}

// A badly scaled but definite matrix is no rigid motion: scaling of the unknowns is harmless, and
// so is a condition number of 1e10.
TEST(NotFactorableMatrix, AcceptsBadScaling) {
  SparseMatrix k = grid_laplacian(30);
  Vector scale(k.rows());
  for (int i = 0; i < scale.size(); ++i) scale[i] = std::pow(10.0, i % 9 - 4);
  k = scale.asDiagonal() * k * scale.asDiagonal();
  EXPECT_EQ(failing_unknown(k, {1, 2}, true), -2);
  SparseMatrix loose = free_body(20);
  loose.coeffRef(7, 7) += 1e-8;
  EXPECT_EQ(failing_unknown(loose, {}, true), -2);
}

// [1 1; 1 1 + e] leaves e of its last diagonal entry: below 1e-13 that is rounding.
TEST(NotFactorableMatrix, RefusesPivotsThatAreRounding) {
  for (const bool symmetric : {true, false})
    for (const double e : {1e-12, 1e-14}) {
      SparseMatrix k(2, 2);
      k.insert(0, 0) = k.insert(0, 1) = k.insert(1, 0) = 1.0;
      k.insert(1, 1) = 1.0 + e;
      k.makeCompressed();
      EXPECT_EQ(failing_unknown(k, {}, symmetric) == -2, e > 1e-13) << e << symmetric;
    }
}

TEST(NotFactorableMatrix, RefusesValuesThatAreNotFinite) {
  for (const bool symmetric : {true, false}) {
    SparseMatrix k = grid_laplacian(6);
    k.coeffRef(20, 20) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NE(failing_unknown(k, {}, symmetric), -2);
    k = grid_laplacian(6);
    k.coeffRef(3, 3) = std::numeric_limits<double>::infinity();
    EXPECT_NE(failing_unknown(k, {}, symmetric), -2);
  }
}

TEST(Analyse, RefusesWrongInput) {
  const SparseMatrix k = grid_laplacian(3);
  const auto kind_of = [](auto&& act) {
    try {
      act();
    } catch (const Failure& failure) {
      return failure.kind;
    }
    return FailureKind::interrupted;
  };
  for (const bool symmetric : {true, false}) {
    EXPECT_EQ(kind_of([&] { analyse(k, std::vector{9}, symmetric); }), FailureKind::bad_value);
    EXPECT_EQ(kind_of([&] { analyse(k, std::vector{-1}, symmetric); }), FailureKind::bad_value);
    EXPECT_EQ(kind_of([&] { analyse(k, std::vector{2, 2}, symmetric); }), FailureKind::bad_value);
    EXPECT_EQ(kind_of([&] { analyse(SparseMatrix(0, 0), {}, symmetric); }), FailureKind::bad_value);
    EXPECT_EQ(kind_of([&] { analyse(SparseMatrix(3, 4), {}, symmetric); }), FailureKind::bad_value);
    const auto factorisation = analyse(k, {}, symmetric);
    EXPECT_EQ(kind_of([&] { factorisation->factor(grid_laplacian(4)); }), FailureKind::bad_value);
    SparseMatrix other = k;
    other.coeffRef(0, 8) = other.coeffRef(8, 0) = 1.0;
    other.makeCompressed();
    EXPECT_EQ(kind_of([&] { factorisation->factor(other); }), FailureKind::bad_value);
  }
}

TEST(Factorisation, RefactorsWithOneAnalysisAndCountsWork) {
  for (const bool symmetric : {true, false}) {
    const Problem plane = slab(10);
    const auto factorisation = analyse(plane.k, plane.contact, symmetric);
    Vector b = Vector::Ones(plane.k.rows()), x, r;
    for (int round = 1; round <= 4; ++round) {
      const Problem stiffer = slab(10, 1.0 + round, 0.5 * round);
      factorisation->factor(stiffer.k);
      solve(*factorisation, b, x);
      EXPECT_LT((stiffer.k * x - b).norm(), 1e-12 * b.norm());
      const auto fresh = analyse(stiffer.k, stiffer.contact, symmetric);
      fresh->factor(stiffer.k);
      EXPECT_EQ((fresh->schur() - factorisation->schur()).cwiseAbs().sum(), 0.0);
      EXPECT_EQ(factorisation->statistics().analyses, 1);
      EXPECT_EQ(factorisation->statistics().factorisations, round);
      EXPECT_EQ(factorisation->statistics().triangular_solves, 2 * round);
    }
    EXPECT_GT(factorisation->statistics().nonzeros, 0.5 * static_cast<double>(plane.k.nonZeros()));
    EXPECT_GT(factorisation->statistics().flops, factorisation->statistics().nonzeros);
  }
}

TEST(Factorisation, RecoversAfterAFailure) {
  for (const bool symmetric : {true, false}) {
    const SparseMatrix good = grid_laplacian(8), loose = free_body(8);
    const auto factorisation = analyse(good, std::vector{3}, symmetric);
    EXPECT_THROW(factorisation->factor(loose), NotFactorable);
    Vector x, b = Vector::Ones(64);
    EXPECT_THROW(solve(*factorisation, b, x), std::logic_error);
    factorisation->factor(good);
    solve(*factorisation, b, x);
    EXPECT_LT((good * x - b).norm(), 1e-12);
  }
}

} // namespace
} // namespace hvi::solver::test
