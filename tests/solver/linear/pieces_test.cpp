// Pieces of matrices on random graphs, against powers of the graph (a second algorithm).
#include "solver/linear/dense.hpp"
#include "solver/linear/pieces.hpp"

#include <gtest/gtest.h>

#include <random>

namespace hvi::solver {
namespace {

SparseMatrix random_symmetric(int n, int entries, std::mt19937& random) {
  std::uniform_int_distribution<int> any(0, n - 1);
  std::vector<Eigen::Triplet<double>> out;
  for (int k = 0; k < entries; ++k) {
    const int i = any(random), j = any(random);
    // Some entries are stored and 0: they join nothing in H.
    const double value = k % 3 == 0 ? 0.0 : 1.0;
    out.emplace_back(i, j, value), out.emplace_back(j, i, value);
  }
  SparseMatrix a(n, n);
  a.setFromTriplets(out.begin(), out.end(), [](double x, double y) { return std::max(x, y); });
  return a;
}

/// Is there a way from i to j? By squaring.
DenseMatrix ways(DenseMatrix graph) {
  graph.diagonal().setOnes();
  for (int length = 1; length < graph.rows(); length *= 2)
    graph = (graph * graph).cwiseMin(1.0).eval();
  return graph;
}

TEST(Pieces, LeavesAtRestWhatNoForceReaches) {
  std::mt19937 random(17);
  int at_rest = 0, moved = 0;
  for (int scene = 0; scene < 200; ++scene) {
    const int n = 1 + scene % 23;
    const SparseMatrix k = random_symmetric(n, scene % 11 + n / 2, random);
    DenseMatrix stored = DenseMatrix::Zero(n, n);
    for (int i = 0; i < n; ++i)
      for (SparseMatrix::InnerIterator it(k, i); it; ++it) stored(i, it.col()) = 1.0;
    Pieces pieces(k);
    const Pieces by_columns(n, [&](int j, Vector& column) { column = stored.col(j); });
    EXPECT_EQ(by_columns.count(), pieces.count());
    for (const int more : {0, 2, 5}) {
      const SparseMatrix h = random_symmetric(n, more, random);
      pieces.join(h);
      const DenseMatrix reached = ways((stored + DenseMatrix(h)).cwiseMin(1.0));
      Vector b = Vector::Zero(n), x = Vector::Ones(n);
      b[scene % n] = -2.0;
      pieces.leave_at_rest(b, x);
      for (int i = 0; i < n; ++i) {
        EXPECT_EQ(x[i], reached(i, scene % n)) << "scene " << scene << ", unknown " << i;
        at_rest += x[i] == 0.0, moved += x[i] != 0.0;
      }
    }
  }
  EXPECT_GT(at_rest, 500);
  EXPECT_GT(moved, 500);
}

TEST(Pieces, OneOfThemIsLeftAsItIs) {
  SparseMatrix k(2, 2);
  k.insert(0, 1) = 1.0, k.insert(1, 0) = 1.0;
  const Pieces pieces(k);
  EXPECT_EQ(pieces.count(), 1);
  Vector x = Vector::Ones(2);
  pieces.leave_at_rest(Vector::Zero(2), x);
  EXPECT_EQ(x, Vector::Ones(2));
}

} // namespace
} // namespace hvi::solver
