// Products that read half of a symmetric matrix, against products with all of it.
#include "matrices.hpp"
#include "solver/linear/symmetric_blocks.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace hvi::solver::test {
namespace {

void expect_same_product(const SparseMatrix& k, double most_of_all_bytes) {
  const SymmetricBlocks half(k);
  ASSERT_FALSE(half.empty());
  const Vector x = Vector::LinSpaced(k.rows(), -1.0, 2.0).array().sin();
  Vector y = Vector::LinSpaced(k.rows(), 3.0, 4.0);
  const Vector expected = y + k * x;
  half.add_product(x, y);
  EXPECT_LT((y - expected).norm(), 1e-14 * (expected.norm() + k.norm() * x.norm()));
  EXPECT_EQ((half.diagonal() - Vector(k.diagonal())).norm(), 0.0);
  const double all = static_cast<double>(k.nonZeros()) * (sizeof(double) + sizeof(int));
  EXPECT_LT(half.bytes(), most_of_all_bytes * all);
}

TEST(SymmetricBlocks, MultiplyInBlocksOfOneTwoAndThree) {
  expect_same_product(grid_laplacian(9), 0.75);
  expect_same_product(random_definite(61, 0.1, 5), 0.75);
  for (const int n : {2, 5, 12}) expect_same_product(slab(n).k, 0.6);
  for (const int n : {2, 3, 6}) expect_same_product(cube(n).k, 0.6);
}

TEST(SymmetricBlocks, MultiplyWithAMatrixMostlyFilled) {
  const SparseMatrix full = random_definite(37, 0.9, 2);
  ASSERT_GT(2 * full.nonZeros(), 37 * 37);
  expect_same_product(full, 1.1);
}

// An unknown that was eliminated breaks the pairs of a node: single entries serve.
TEST(SymmetricBlocks, FallBackToEntriesWhereBlocksAreCut) {
  const SparseMatrix k = slab(6).k;
  std::vector<Eigen::Triplet<double>> kept;
  for (int i = 1; i < k.rows(); ++i)
    for (SparseMatrix::InnerIterator it(k, i); it; ++it)
      if (it.col() > 0) kept.emplace_back(i - 1, static_cast<int>(it.col()) - 1, it.value());
  SparseMatrix cut(k.rows() - 1, k.rows() - 1);
  cut.setFromTriplets(kept.begin(), kept.end());
  expect_same_product(cut, 0.75);
}

void expect_same_energy(const SparseMatrix& k) {
  const Vector x = Vector::LinSpaced(k.rows(), -1.0, 2.0).array().sin();
  const double scale = k.norm() * x.squaredNorm();
  EXPECT_NEAR(SymmetricBlocks(k).energy(x), x.dot(k * x), 1e-14 * scale);
}

TEST(SymmetricBlocks, HaveTheEnergyOfTheWhole) {
  expect_same_energy(grid_laplacian(9));
  expect_same_energy(random_definite(37, 0.9, 2));
  for (const int n : {2, 5, 12}) expect_same_energy(slab(n).k);
  for (const int n : {2, 3}) expect_same_energy(cube(n).k);
}

TEST(SymmetricBlocks, AddUpToTheBlocksOfASum) {
  for (const SparseMatrix& k : {slab(5).k, cube(3).k, random_definite(37, 0.9, 2)}) {
    SparseMatrix other = k;
    other.coeffs() = k.coeffs().cube();
    const SparseMatrix mirrored = other.transpose();
    other = 0.5 * (other + mirrored);
    const SymmetricBlocks parts[] = {SymmetricBlocks(k), SymmetricBlocks(other)};
    SparseMatrix sum = k;
    sum.coeffs() *= 0.3;
    sum.coeffs() += -1.7 * other.coeffs();
    const SymmetricBlocks whole(sum), added = SymmetricBlocks::sum(parts, Vector{{0.3, -1.7}});
    const Vector x = Vector::LinSpaced(k.rows(), -1.0, 2.0).array().sin();
    Vector y = Vector::Zero(k.rows()), z = y;
    whole.add_product(x, y), added.add_product(x, z);
    EXPECT_EQ((y - z).norm(), 0.0);
    EXPECT_EQ((whole.diagonal() - added.diagonal()).norm(), 0.0);
  }
  const SymmetricBlocks strangers[] = {SymmetricBlocks(slab(5).k), SymmetricBlocks(slab(4).k)};
  EXPECT_TRUE(SymmetricBlocks::sum(strangers, Vector{{1.0, 1.0}}).empty());
}

/// Entry by entry what was halved; zeros in blocks are no others.
TEST(SymmetricBlocks, GiveTheMatrixBackByRows) {
  for (const SparseMatrix& k : {grid_laplacian(9), random_definite(61, 0.1, 5), slab(5).k,
                                cube(3).k, random_definite(37, 0.9, 2)}) {
    const SparseMatrix back = SymmetricBlocks(k).by_rows();
    EXPECT_TRUE(back.isCompressed());
    const DenseMatrix given(k), found(back);
    EXPECT_TRUE(((found.array() == given.array()) || (found.array() == given.transpose().array()))
                    .all()); // k is symmetric to rounding
    for (int i = 0; i < back.rows(); ++i)
      EXPECT_TRUE(std::is_sorted(back.innerIndexPtr() + back.outerIndexPtr()[i],
                                 back.innerIndexPtr() + back.outerIndexPtr()[i + 1]));
  }
}

TEST(SymmetricBlocks, AreEmptyWhereHalfWouldNotDo) {
  const SparseMatrix k = slab(4).k;
  EXPECT_TRUE(SymmetricBlocks(with_skew_part(k, 1e-6, 3)).empty());
  EXPECT_TRUE(SymmetricBlocks(SparseMatrix(k.topRows(4))).empty());
  EXPECT_TRUE(SymmetricBlocks().empty());
  std::vector<Eigen::Triplet<double>> entries{{0, 0, 1.0}, {1, 1, 1.0}, {0, 1, 0.5}};
  SparseMatrix lopsided(2, 2);
  lopsided.setFromTriplets(entries.begin(), entries.end());
  EXPECT_TRUE(SymmetricBlocks(lopsided).empty());
  entries.back() = {1, 0, 0.5};
  lopsided.setFromTriplets(entries.begin(), entries.end());
  EXPECT_TRUE(SymmetricBlocks(lopsided).empty());
}

} // namespace
} // namespace hvi::solver::test
