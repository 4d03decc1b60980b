// The numeric phase against CHOLMOD's own on the same structure.
#include "matrices.hpp"
#include "solver/linear/cholesky_factor.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

namespace hvi::solver::test {
namespace {

/// The lower triangle of K in an order, with what CHOLMOD's view of it needs.
struct Lower {
  Pattern pattern;
  std::vector<double> value;

  Lower(const SparseMatrix& k, const std::vector<int>& unknown) {
    std::vector<int> position(unknown.size());
    for (std::size_t i = 0; i < unknown.size(); ++i) position[unknown[i]] = static_cast<int>(i);
    for (std::size_t j = 0; j < unknown.size(); ++j) {
      for (SparseMatrix::InnerIterator it(k, unknown[j]); it; ++it)
        if (position[it.col()] >= static_cast<int>(j)) {
          pattern.row.push_back(position[it.col()]);
          value.push_back(it.value());
        }
      pattern.start.push_back(static_cast<Long>(pattern.row.size()));
    }
  }
  cholmod_sparse view() {
    cholmod_sparse a = pattern.view(-1);
    a.x = value.data();
    a.xtype = CHOLMOD_REAL;
    return a;
  }
};

/// f(row, column, place among the values) of the lower triangle from the column `first` on.
template <class F>
void for_columns_from(const cholmod_factor& l, Long first, const F& f) {
  const auto [super, row_start, value_start, row] = arrays_of(l);
  for (std::size_t s = 0; s < l.nsuper; ++s) {
    const Long stride = row_start[s + 1] - row_start[s];
    for (Long j = std::max<Long>(super[s], first); j < super[s + 1]; ++j)
      for (Long i = j - super[s]; i < stride; ++i)
        f(row[row_start[s] + i], j, value_start[s] + (j - super[s]) * stride + i);
  }
}

/// The largest distance between the values of two factors of one structure, on the interior.
double distance(const cholmod_factor& a, const cholmod_factor& b, int interior) {
  const auto *x = static_cast<const double*>(a.x), *y = static_cast<const double*>(b.x);
  double out = 0.0;
  for_columns_from(a, 0, [&](Long, Long column, Long at) {
    if (column < interior) out = std::max(out, std::abs(x[at] - y[at]));
  });
  return out;
}

/// L22 of the contact unknowns.
DenseMatrix trailing(const cholmod_factor& l, int interior) {
  const auto n = static_cast<Eigen::Index>(l.n) - interior;
  DenseMatrix out = DenseMatrix::Zero(n, n);
  for_columns_from(l, interior, [&](Long row, Long column, Long at) {
    out(row - interior, column - interior) = static_cast<const double*>(l.x)[at];
  });
  return out;
}

/// The largest entry of S - L22 L22^T.
double error_of_trailing(const DenseMatrix& s, const DenseMatrix& l22) {
  const DenseMatrix product = l22 * l22.transpose(), whole = s.selfadjointView<Eigen::Lower>();
  return s.size() > 0 ? (whole - product).cwiseAbs().maxCoeff() : 0.0;
}

/// Compares them, and the column where both break down; returns that one.
std::size_t compare(const SparseMatrix& k, const std::vector<int>& contact) {
  FactorStatistics statistics;
  CholeskyFactor ours(k, contact, nullptr, FactorEntries::doubles, statistics);
  const int interior = ours.order().interior;
  const bool whole_interior = ours.compute(k);
  CholmodSession session;
  cholmod_factor* theirs =
      cholmod_l_copy_factor(const_cast<cholmod_factor*>(&ours.structure()), session.common());
  cholmod_l_change_factor(CHOLMOD_PATTERN, 1, 1, 1, 1, theirs, session.common());
  Lower lower(k, ours.order().unknown);
  cholmod_sparse view = lower.view();
  double nothing[2] = {0.0, 0.0};
  cholmod_l_super_numeric(&view, nullptr, nothing, theirs, session.common());
  const std::size_t failed = theirs->minor;
  EXPECT_EQ(ours.structure().minor, std::min(failed, static_cast<std::size_t>(interior)));
  EXPECT_EQ(whole_interior, failed >= static_cast<std::size_t>(interior));
  if (failed == theirs->n) {
    EXPECT_LE(distance(ours.structure(), *theirs, interior), 1e-14);
    const DenseMatrix l22 = trailing(*theirs, interior);
    DenseMatrix s;
    ours.take_trailing_block(s);
    EXPECT_LE(error_of_trailing(s, l22), 1e-14);
  }
  cholmod_l_free_factor(&theirs, session.common());
  return failed;
}

/// Diagonal 1, so that entries of the factor are at most 1.
void scale(SparseMatrix& k) {
  const Vector d = k.diagonal().cwiseSqrt().cwiseInverse();
  k = SparseMatrix(d.asDiagonal() * k * d.asDiagonal());
}

TEST(LeftLooking, HasTheFactorOfCholmod) {
  for (const int n : {1, 3, 8, 24}) {
    Problem problem = slab(n);
    scale(problem.k);
    EXPECT_EQ(compare(problem.k, problem.contact), static_cast<std::size_t>(problem.k.rows()));
  }
  Problem solid = cube(7);
  scale(solid.k);
  compare(solid.k, solid.contact);
  for (unsigned seed = 0; seed < 40; ++seed) {
    std::mt19937 random(seed);
    const int n = 1 + static_cast<int>(random() % 300);
    SparseMatrix k = random_definite(n, 1e-3 * static_cast<double>(1 + random() % 60), seed);
    scale(k);
    std::vector<int> contact(static_cast<std::size_t>(n));
    std::iota(contact.begin(), contact.end(), 0);
    std::ranges::shuffle(contact, random);
    contact.resize(random() % (contact.size() + 1));
    compare(k, contact);
  }
}

TEST(LeftLooking, BreaksDownWhereCholmodDoes) {
  const SparseMatrix k = grid_laplacian(20);
  std::mt19937 random(7);
  for (int scene = 0; scene < 20; ++scene) {
    SparseMatrix broken = k;
    const int bad = static_cast<int>(random() % 400);
    broken.coeffRef(bad, bad) = 0.5 - static_cast<double>(scene % 3);
    EXPECT_LT(compare(broken, {0, 17, 399}), static_cast<std::size_t>(k.rows()));
  }
}

} // namespace
} // namespace hvi::solver::test
