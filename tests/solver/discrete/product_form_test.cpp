// Which problems with several unknowns have one solution, by weights that cancel their couplings.
#include "solver/discrete/product_form.hpp"
#include "solver/linear/dense.hpp"

#include <gtest/gtest.h>

namespace hvi::solver {
namespace {

/// Two unknowns with two entries each: [2, a; b, c] times the unit matrix, in blocks.
SparseMatrix blocks(double a, double b, double c) {
  DenseMatrix k = DenseMatrix::Zero(4, 4);
  k.topLeftCorner(2, 2) = 2.0 * DenseMatrix::Identity(2, 2);
  k.topRightCorner(2, 2) = a * DenseMatrix::Identity(2, 2);
  k.bottomLeftCorner(2, 2) = b * DenseMatrix::Identity(2, 2);
  k.bottomRightCorner(2, 2) = c * DenseMatrix::Identity(2, 2);
  return k.sparseView();
}

const std::vector<std::uint8_t> of_unknown{0, 0, 1, 1};
const std::vector<char> laws_on_first{1, 0}, laws_on_both{1, 1};
constexpr Couplings both_ways{{{true, true}, {true, true}}}, one_way{{{true, true}, {false, true}}};

double least(const SparseMatrix& k, const std::vector<char>& laws,
             const Couplings& couplings = both_ways) {
  const DenseMatrix part = ProductForm(k, of_unknown, laws, couplings).symmetric_part(k);
  return symmetric_eigenvalues(part)[0];
}

TEST(ProductForm, WeightsCancelCouplingsOfOppositeSign) {
  // u coupled by -30 p, p by +0.01 u: the weight 3000 leaves the diagonal.
  EXPECT_DOUBLE_EQ(
      ProductForm(blocks(-30.0, 0.01, 5.0), of_unknown, laws_on_both, both_ways).weight(1), 3000.0);
  EXPECT_NEAR(least(blocks(-30.0, 0.01, 5.0), laws_on_both), 2.0, 1e-12);
}

TEST(ProductForm, TheSignOfAnEquationWithoutLawsIsFree) {
  EXPECT_NEAR(least(blocks(3.0, 3.0, -1.0), laws_on_first), 1.0, 1e-12); // a potential
  EXPECT_LT(least(blocks(3.0, 3.0, -1.0), laws_on_both), 0.0);
  EXPECT_LT(least(blocks(3.0, 3.0, 1.0), laws_on_both), 0.0); // 2 < 3 3: really indefinite
}

TEST(ProductForm, MultipliersAreNotSeen) {
  const SparseMatrix k = blocks(-1.0, 4.0, 0.0);
  EXPECT_TRUE(ProductForm(k, of_unknown, laws_on_first, both_ways).is_multiplier(1));
  EXPECT_FALSE(ProductForm(k, of_unknown, laws_on_both, both_ways).is_multiplier(1));
  EXPECT_NEAR(least(k, laws_on_first), 2.0, 1e-12);
}

/// An unknown that drives another one, however strongly: [2, a; 0, c]. Not where a third one acts
/// back, as the whole problem says.
TEST(ProductForm, WhatDoesNotActBackDoesNotCount) {
  EXPECT_NEAR(least(blocks(1e6, 0.0, 5.0), laws_on_both, one_way), 2.0, 1e-12);
  EXPECT_LT(least(blocks(1e6, 0.0, 5.0), laws_on_both), 0.0);
  constexpr Couplings by_a_third{{{true, true, false}, {false, true, true}, {true, false, true}}};
  EXPECT_LT(least(blocks(1e6, 0.0, 5.0), laws_on_both, by_a_third), 0.0);
}

/// [2, a; b, 0] in other units of the second unknown: its couplings cancel, or do not, all the
/// same.
TEST(ProductForm, MultipliersHaveAnyUnits) {
  for (const double unit : {0x1p-50, 1.0, 0x1p50}) {
    EXPECT_NEAR(least(blocks(-unit, unit, 0.0), laws_on_first), 2.0, 1e-12) << unit;
    SparseMatrix seen = blocks(-unit, unit, 0.0);
    seen.coeffRef(0, 3) = 0.5 * unit;
    EXPECT_LE(least(seen, laws_on_first), 0.0) << unit;
  }
}

} // namespace
} // namespace hvi::solver
