// Cholesky factors in single precision against those in double precision, and where they have to
// become such.
#include "matrices.hpp"
#include "solver/linear/cholesky.hpp"
#include "solver/linear/factorisation.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace hvi::solver::test {
namespace {

constexpr double few_digits = 1e-4; ///< of singles, with the growth of the matrices here

std::unique_ptr<Factorisation> factored_of(const SparseMatrix& k, const std::vector<int>& contact,
                                           FactorEntries entries) {
  auto out = analyse(k, contact, true, nullptr, entries);
  out->factor(k);
  return out;
}

/// All that a factorisation gives, to some digits.
void expect_alike(const SparseMatrix& k, const std::vector<int>& contact) {
  SCOPED_TRACE("unknowns " + std::to_string(k.rows()) + ", contact " +
               std::to_string(contact.size()));
  const auto exact = factored_of(k, contact, FactorEntries::doubles);
  const auto rough = factored_of(k, contact, FactorEntries::singles);
  ASSERT_EQ(rough->statistics().entries, FactorEntries::singles);
  EXPECT_EQ(exact->statistics().entries, FactorEntries::doubles);
  EXPECT_LT(rough->statistics().bytes, exact->statistics().bytes);
  EXPECT_EQ(lower_factor(*rough), nullptr);
  EXPECT_EQ(rough->order().unknown, exact->order().unknown);
  EXPECT_LE((rough->schur() - exact->schur()).norm(), few_digits * exact->schur().norm());
  EXPECT_EQ(rough->schur(), rough->schur().transpose());

  const Vector b = random_vector(k.rows(), 1);
  Vector y, r, x, other_y, other_r, other_x;
  forward(*exact, b, y, r);
  forward(*rough, b, other_y, other_r);
  EXPECT_LE((other_r - r).norm(), few_digits * (r.norm() + b.norm()));
  back(*exact, r, y, x);
  back(*rough, r, other_y, other_x);
  EXPECT_LE((other_x - x).norm(), few_digits * x.norm());

  for (const unsigned count : {1U, 3U, 8U, 13U}) { // at once as one by one
    std::vector<Vector> many, first, second;
    for (unsigned j = 0; j < count; ++j) many.push_back(random_vector(k.rows(), 20 + j));
    DenseMatrix all;
    forward(*rough, many, all, first);
    back(*rough, first, all, second);
    for (unsigned j = 0; j < count; ++j) {
      forward(*rough, many[j], y, r);
      EXPECT_LE((first[j] - r).norm(), 1e-11 * (1.0 + r.norm()));
      back(*rough, r, y, x);
      EXPECT_LE((second[j] - x).norm(), 1e-9 * x.norm());
    }
  }
}

/// Corrections of the solution end at that of doubles.
void expect_corrected(const SparseMatrix& k, const std::vector<int>& contact) {
  const auto rough = factored_of(k, contact, FactorEntries::singles);
  const Vector exact = random_vector(k.rows(), 3), b = k * exact;
  Vector x = Vector::Zero(k.rows()), more;
  for (int pass = 0; pass < 12; ++pass) {
    solve(*rough, b - k * x, more);
    x += more;
  }
  EXPECT_LE((x - exact).norm(), 1e-9 * exact.norm());
}

std::vector<int> every(int step, Eigen::Index n) {
  std::vector<int> out;
  for (int i = 0; i < n; i += step) out.push_back(i);
  return out;
}

void check_singles(const SparseMatrix& k, const std::vector<int>& contact) {
  expect_alike(k, contact);
  expect_corrected(k, contact);
}

TEST(Singles, AreDoublesToSomeDigits) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    const SparseMatrix k =
        random_definite(20 + 17 * static_cast<int>(seed), 0.02 + 0.01 * seed, seed);
    for (const int step : {1, 5, 7}) check_singles(k, every(step, k.rows()));
    check_singles(k, {});
  }
  for (const int n : {1, 2, 3, 9, 28}) check_singles(grid_laplacian(n, 0.01), every(6, n * n));
}

TEST(Singles, AreDoublesToSomeDigitsOfElasticBodies) {
  const Problem plane = slab(9), space = cube(6), dissected = cube(12);
  check_singles(plane.k, plane.contact);
  check_singles(space.k, space.contact);
  check_singles(dissected.k,
                dissected.contact); // by METIS, and supernodes with both kinds of unknowns
  check_singles(side_by_side(plane.k, space.k), plane.contact);
}

TEST(Singles, HaveAnyUnit) {
  const Problem space = cube(5);
  for (const double unit : {1e-10, 1e-4, 1e6, 1e12}) {
    const SparseMatrix k = unit * space.k;
    EXPECT_EQ(factored_of(k, space.contact, FactorEntries::singles)->statistics().entries,
              FactorEntries::singles);
    expect_corrected(k, space.contact);
  }
}

TEST(Singles, BecomeDoublesBeyondTheirRange) {
  const Problem space = cube(4);
  for (const double unit : {1e-30, 1e30}) {
    const SparseMatrix k = unit * space.k;
    const auto factor = factored_of(k, space.contact, FactorEntries::singles);
    EXPECT_EQ(factor->statistics().entries, FactorEntries::doubles);
    Vector x;
    const Vector exact = random_vector(k.rows(), 4);
    solve(*factor, k * exact, x);
    EXPECT_LE((x - exact).norm(), 1e-10 * exact.norm());
  }
}

/// Of an error that 30 corrections have left: what one more leaves.
double left_by_one_more(Factorisation& factor, const SparseMatrix& k) {
  Vector error = random_vector(k.rows(), 2), x;
  double out = 0.0;
  for (int pass = 0; pass < 30; ++pass) {
    error.normalize();
    solve(factor, k * error, x);
    error -= x;
    out = error.norm();
  }
  return out;
}

// From stiffnesses that singles know well to some of which they know nothing, with all between.
TEST(Singles, LeaveLittleOfAnErrorOrAreDoubles) {
  int singles = 0, doubles = 0;
  for (double lambda = 1e2; lambda < 1e8; lambda *= 1.6) {
    const Problem plane = slab(8, lambda, 0.9);
    const auto factor = factored_of(plane.k, plane.contact, FactorEntries::singles);
    const bool in_singles = factor->statistics().entries == FactorEntries::singles;
    ++(in_singles ? singles : doubles);
    EXPECT_LE(left_by_one_more(*factor, plane.k), in_singles ? 0.02 : 1e-6) << lambda;
  }
  EXPECT_GE(singles, 5);
  EXPECT_GE(doubles, 5);
}

// Nearly incompressible, so that singles know nothing of the shear.
TEST(Singles, BecomeDoublesWhereTheySayTooLittle) {
  const Problem plane = slab(8, 1e8, 0.9);
  const auto factor = factored_of(plane.k, plane.contact, FactorEntries::singles);
  EXPECT_EQ(factor->statistics().entries, FactorEntries::doubles);
  EXPECT_NE(lower_factor(*factor), nullptr);
  Vector x;
  const Vector exact = random_vector(plane.k.rows(), 5);
  solve(*factor, plane.k * exact, x);
  EXPECT_LE((x - exact).norm(), 1e-6 * exact.norm());
  // What shares the analysis knows it, and so does the next matrix.
  EXPECT_EQ(factor->another()->statistics().entries, FactorEntries::doubles);
  factor->factor(SparseMatrix(2.0 * plane.k));
  EXPECT_EQ(factor->statistics().entries, FactorEntries::doubles);
}

// Large enough for the columns of the contact unknowns to have pages of their own.
TEST(Singles, AndDoublesGiveBackTheContactColumnsAlone) {
  const Problem space = cube(18);
  for (const auto entries : {FactorEntries::singles, FactorEntries::doubles}) {
    const auto factor = factored_of(space.k, space.contact, entries);
    for (const double unit : {1.0, 2.0}) {
      const SparseMatrix k = unit * space.k;
      factor->factor(k);
      const Vector exact = random_vector(k.rows(), 6), b = k * exact;
      Vector x, y, r;
      solve(*factor, b, x);
      EXPECT_LE((x - exact).norm(), few_digits * exact.norm());
      forward(*factor, b, y, r); // S c = r
      const Vector c = exact(space.contact);
      EXPECT_LE((factor->schur() * c - r).norm(), few_digits * r.norm());
      DenseMatrix columns = factor->schur() * c / r.norm();
      ASSERT_TRUE(factor->solve_schur(columns));
      EXPECT_LE((columns - c / r.norm()).norm(), few_digits * c.norm() / r.norm());
      back(*factor, c, y, x);
      EXPECT_LE((x - exact).norm(), few_digits * exact.norm());
    }
  }
}

TEST(Singles, RefuseWhatDoublesRefuse) {
  SparseMatrix k = slab(5).k;
  k.coeffRef(7, 7) = -1.0;
  const auto factor = analyse(k, every(4, k.rows()), true, nullptr, FactorEntries::singles);
  EXPECT_THROW(factor->factor(k), NotFactorable);
  Vector y = Vector::Zero(k.rows());
  EXPECT_THROW(factor->forward(y, Columns::interior), std::logic_error);
}

TEST(Singles, AreFactoredAgainAndShareTheAnalysis) {
  const Problem space = cube(6);
  const auto factor = factored_of(space.k, space.contact, FactorEntries::singles);
  const DenseMatrix before = factor->schur();
  factor->factor(SparseMatrix(3.0 * space.k));
  EXPECT_LE((factor->schur() - 3.0 * before).norm(), few_digits * before.norm());
  const auto other = factor->another();
  other->factor(space.k);
  EXPECT_EQ(other->statistics().entries, FactorEntries::singles);
  EXPECT_EQ(other->schur(), before); // bit for bit
}

} // namespace
} // namespace hvi::solver::test
