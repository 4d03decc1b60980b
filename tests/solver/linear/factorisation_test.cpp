// The direct solvers against dense linear algebra: S, the two triangular solves, all kinds of
// contact sets.
#include "matrices.hpp"
#include "solver/linear/factorisation.hpp"
#include "solver/linear/separate.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace hvi::solver::test {
namespace {

/// K_cc - K_cI K_II^-1 K_Ic by dense LU, and what reduce must return for b.
struct DenseReduction {
  DenseMatrix s;
  Vector r;
};

DenseReduction reduce_densely(const SparseMatrix& k, const std::vector<int>& contact,
                              const Vector& b) {
  const DenseMatrix full(k);
  std::vector<int> interior;
  for (int i = 0; i < k.rows(); ++i)
    if (std::ranges::find(contact, i) == contact.end()) interior.push_back(i);
  DenseReduction result{full(contact, contact), b(contact)};
  if (interior.empty() || contact.empty()) return result;
  const Eigen::PartialPivLU<DenseMatrix> lu(full(interior, interior));
  result.s -= full(contact, interior) * lu.solve(DenseMatrix(full(interior, contact)));
  result.r -= full(contact, interior) * lu.solve(Vector(b(interior)));
  return result;
}

/// The solution of K x = b but for the contact part, which is c.
void expect_interior_rows(const SparseMatrix& k, const std::vector<int>& contact, const Vector& b,
                          const Vector& c, const Vector& x) {
  const double scale = DenseMatrix(k).cwiseAbs().maxCoeff();
  Vector residual = b - k * x;
  EXPECT_EQ((x(contact) - c).cwiseAbs().sum(), 0.0);
  residual(contact).setZero();
  EXPECT_LT(residual.cwiseAbs().maxCoeff(), 1e-11 * (1.0 + scale * x.cwiseAbs().maxCoeff()));
}

void check_order(const EliminationOrder& order, const std::vector<int>& contact) {
  ASSERT_EQ(order.contacts(), static_cast<int>(contact.size()));
  EXPECT_TRUE(std::ranges::equal(std::span(order.unknown).last(contact.size()), contact));
  std::vector<int> sorted = order.unknown, all(order.unknown.size());
  std::ranges::sort(sorted);
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(sorted, all);
}

/// What forward solves leave may be added up, and is handed over whenever it is wanted.
void check_sums(Factorisation& factor, const SparseMatrix& k, const std::vector<int>& contact,
                bool symmetric) {
  const Vector b = random_vector(k.rows(), 7), other_b = random_vector(k.rows(), 9);
  const Vector c = random_vector(static_cast<Eigen::Index>(contact.size()), 8);
  Vector y, other_y, r, x;
  forward(factor, b, y, r);
  forward(factor, other_b, other_y, r);
  Vector sum = 2.0 * y - 0.5 * other_y;
  back(factor, c, sum, x);
  expect_interior_rows(k, contact, 2.0 * b - 0.5 * other_b, c, x);
  sum.setZero();
  back(factor, c, sum, x);
  expect_interior_rows(k, contact, Vector::Zero(b.size()), c, x);
  if (!symmetric) return;
  const int interior = factor.order().interior; // a_I^T K_II^-1 b_I
  const double product = y.head(interior).dot(other_y.head(interior));
  back(factor, Vector::Zero(c.size()), other_y, x);
  Vector inside = b;
  inside(contact).setZero();
  EXPECT_NEAR(product, inside.dot(x), 1e-11 * inside.norm() * x.norm());
  Vector whole; // with all columns: b^T K^-1 b
  factor.order().gather(b, whole);
  factor.forward(whole, Columns::all);
  solve(factor, b, x);
  EXPECT_NEAR(whole.squaredNorm(), b.dot(x), 1e-11 * b.norm() * x.norm());
}

/// Several at once: what each of them gives, to rounding of the solve.
void check_several(Factorisation& factor, Eigen::Index size) {
  Vector y, r, x;
  for (const unsigned count : {1u, 5u, 8u, 13u, 16u}) {
    std::vector<Vector> many, first, second;
    for (unsigned j = 0; j < count; ++j) many.push_back(random_vector(size, 20 + j));
    DenseMatrix all;
    forward(factor, many, all, first);
    back(factor, first, all, second); // any contact part will do
    for (unsigned j = 0; j < count; ++j) {
      forward(factor, many[j], y, r);
      EXPECT_LE((first[j] - r).lpNorm<1>(), 1e-12 * (1.0 + r.lpNorm<1>()));
      back(factor, first[j], y, x);
      EXPECT_LE((second[j] - x).norm(), 1e-10 * x.norm());
    }
  }
  // In place, with rows of zeros beside them that stay zeros.
  for (const int count : {1, 7, 11, 16}) {
    DenseMatrix all = DenseMatrix::Zero(RightHandSides::stride_of(count), size);
    for (int j = 0; j < count; ++j) all.row(j) = random_vector(size, 40 + j).transpose();
    const DenseMatrix given = all;
    factor.back({all, count}, Columns::interior);
    for (int j = 0; j < count; ++j) {
      y = given.row(j);
      factor.back(y, Columns::interior);
      EXPECT_LE((all.row(j).transpose() - y).lpNorm<Eigen::Infinity>(),
                1e-10 * y.lpNorm<Eigen::Infinity>());
    }
    EXPECT_TRUE(all.bottomRows(all.rows() - count).isZero(0.0));
  }
}

/// Everything a factorisation promises, for one matrix and contact set.
void check_against_dense(const SparseMatrix& k, const std::vector<int>& contact, bool symmetric) {
  SCOPED_TRACE("unknowns " + std::to_string(k.rows()) + ", contact " +
               std::to_string(contact.size()));
  const auto factorisation = analyse(k, contact, symmetric);
  check_order(factorisation->order(), contact);
  factorisation->factor(k);
  const Vector b = random_vector(k.rows(), 7);
  const DenseReduction dense = reduce_densely(k, contact, b);
  const double scale = DenseMatrix(k).cwiseAbs().maxCoeff();
  const DenseMatrix& s = factorisation->schur();
  ASSERT_EQ(s.rows(), static_cast<Eigen::Index>(contact.size()));
  EXPECT_LT((s - dense.s).cwiseAbs().sum(), 1e-11 * scale * static_cast<double>(s.size() + 1));

  Vector y, r, x;
  forward(*factorisation, b, y, r);
  EXPECT_LT((r - dense.r).cwiseAbs().sum(), 1e-10 * (1.0 + dense.r.cwiseAbs().sum()));
  // A contact part that is not the solution: the interior rows hold all the same.
  const Vector c = random_vector(s.rows(), 8);
  back(*factorisation, c, y, x);
  expect_interior_rows(k, contact, b, c, x);

  const Eigen::PartialPivLU<DenseMatrix> lu{DenseMatrix(k)};
  const Vector exact = lu.solve(b), exact_transposed = lu.transpose().solve(b);
  solve(*factorisation, b, x);
  EXPECT_LT((x - exact).norm(), 1e-9 * exact.norm());
  solve(*factorisation, b, x, Columns::transposed);
  EXPECT_LT((x - exact_transposed).norm(), 1e-9 * exact_transposed.norm());
  EXPECT_EQ(factorisation->statistics().triangular_solves, 6);

  check_sums(*factorisation, k, contact, symmetric);
  check_several(*factorisation, k.rows());

  // One more with the same analysis: its values are its own.
  const auto other = factorisation->another();
  other->factor(SparseMatrix(3.0 * k));
  solve(*other, b, x);
  EXPECT_LT((3.0 * x - exact).norm(), 1e-9 * exact.norm());
  solve(*factorisation, b, x);
  EXPECT_LT((x - exact).norm(), 1e-9 * exact.norm());
  EXPECT_EQ(other->statistics().analyses, 0);
  EXPECT_EQ(other->statistics().factorisations, 1);
}

std::vector<int> every(int step, int n) {
  std::vector<int> result;
  for (int i = 0; i < n; i += step) result.push_back(i);
  return result;
}

std::vector<int> shuffled(std::vector<int> list, unsigned seed) {
  std::mt19937 random(seed);
  std::ranges::shuffle(list, random);
  return list;
}

void check_all_contact_sets(const SparseMatrix& k, bool symmetric) {
  const int n = static_cast<int>(k.rows());
  check_against_dense(k, {}, symmetric);
  check_against_dense(k, {n / 2}, symmetric);
  check_against_dense(k, every(7, n), symmetric);
  check_against_dense(k, shuffled(every(5, n), 3), symmetric);
  check_against_dense(k, shuffled(every(1, n), 4), symmetric);
  if (n > 2) check_against_dense(k, {n - 1, 0, 1}, symmetric);
}

TEST(Factorisation, AgreesWithDenseAlgebraOnRandomMatrices) {
  for (unsigned seed = 0; seed < 12; ++seed)
    check_all_contact_sets(
        random_definite(20 + 17 * static_cast<int>(seed), 0.02 + 0.01 * seed, seed), true);
}

TEST(Factorisation, AgreesWithDenseAlgebraOnGrids) {
  for (const int n : {1, 2, 3, 9, 17, 28}) check_all_contact_sets(grid_laplacian(n, 0.01), true);
}

TEST(Factorisation, AgreesWithDenseAlgebraOnElasticity) {
  const Problem plane = slab(9), space = cube(5);
  check_against_dense(plane.k, plane.contact, true);
  check_against_dense(plane.k, shuffled(plane.contact, 5), true);
  check_against_dense(space.k, space.contact, true);
  check_against_dense(space.k, shuffled(space.contact, 6), true);
}

// Bodies that do not touch: S is block diagonal and the elimination tree a forest.
TEST(Factorisation, KeepsContactLastForSeparateBodies) {
  const Problem a = slab(6), b = slab(4, 7.0, 2.0);
  const int shift = static_cast<int>(a.k.rows());
  const SparseMatrix both = side_by_side(a.k, b.k);
  std::vector<int> contact = a.contact;
  for (const int c : b.contact) contact.push_back(shift + c);
  check_against_dense(both, contact, true);
  check_against_dense(both, shuffled(contact, 9), true);
  check_against_dense(both, a.contact, true); // the second body has no contact
  check_against_dense(side_by_side(b.k, a.k), b.contact, true);
  const SparseMatrix three = side_by_side(grid_laplacian(5, 1.0), both);
  check_against_dense(three, {30, 31, shift + 60}, true);
}

TEST(Factorisation, AgreesWithDenseAlgebraOnUnsymmetricMatrices) {
  for (unsigned seed = 0; seed < 6; ++seed)
    check_all_contact_sets(
        with_skew_part(random_definite(30 + 25 * static_cast<int>(seed), 0.05, seed), 0.8, seed),
        false);
  const Problem plane = slab(8);
  check_against_dense(with_skew_part(plane.k, 0.3, 1), plane.contact, false);
}

// Large enough for nested dissection. S is the reaction to a contact displacement without loads.
TEST(Factorisation, CondensesUnderNestedDissection) {
  const Problem space = cube(12);
  const auto factorisation = analyse(space.k, space.contact, true);
  factorisation->factor(space.k);
  EXPECT_EQ(factorisation->statistics().ordering, "METIS");
  Vector y, r, x;
  forward(*factorisation, Vector::Zero(space.k.rows()), y, r);
  EXPECT_EQ(r.cwiseAbs().sum(), 0.0);
  const Vector c = random_vector(r.size(), 12);
  back(*factorisation, c, y, x);
  Vector reaction = space.k * x;
  const Vector expected = factorisation->schur() * c;
  EXPECT_LT((reaction(space.contact) - expected).norm(), 1e-12 * expected.norm());
  reaction(space.contact).setZero();
  EXPECT_LT(reaction.norm(), 1e-12 * expected.norm());
}

// That time passes is all that is asked: of the last one alone it would be less now and then.
TEST(Factorisation, AddsUpTheTimeOfAllItsFactors) {
  const Problem plane = slab(12);
  SparseMatrix diagonal(plane.k.rows(), plane.k.cols());
  diagonal.setIdentity();
  const int contacts = 5, all = static_cast<int>(plane.k.rows());
  const std::pair<std::unique_ptr<Factorisation>, const SparseMatrix*> made[] = {
      {analyse(plane.k, plane.contact, true), &plane.k},
      {analyse(plane.k, plane.contact, false), &plane.k},
      {separate_factor(contacts, all), &diagonal}};
  for (const auto& [factor, matrix] : made) {
    double before = 0.0;
    for (int pass = 0; pass < 20; ++pass) {
      factor->factor(*matrix);
      const double now = factor->statistics().seconds_factor;
      EXPECT_GE(now, before);
      before = now;
    }
  }
}

/// A solve reads what is stored of the columns of the interior, none where all are in contact.
TEST(Factorisation, CountsWhatItsSolvesRead) {
  const SparseMatrix k = grid_laplacian(20, 1.0);
  const int n = static_cast<int>(k.rows());
  double read = 0.0;
  for (const int contacts : {0, 20, 200, 390, n}) {
    std::vector<int> contact(static_cast<std::size_t>(contacts));
    std::iota(contact.begin(), contact.end(), 0);
    const auto factor = analyse(k, contact, true);
    factor->factor(k);
    Vector y, r;
    forward(*factor, random_vector(n, 3), y, r);
    read = factor->statistics().bytes_read;
    EXPECT_EQ(read > 0.0, contacts < n) << contacts << ": " << read;
  }
  EXPECT_EQ(read, 0.0);
}

TEST(Factorisation, CholeskyAndLuAgree) {
  const Problem plane = slab(12);
  const auto cholesky = analyse(plane.k, plane.contact, true);
  const auto lu = analyse(plane.k, plane.contact, false);
  cholesky->factor(plane.k);
  lu->factor(plane.k);
  EXPECT_LT((cholesky->schur() - lu->schur()).norm(), 1e-12 * lu->schur().norm());
}

} // namespace
} // namespace hvi::solver::test
