// What no force reaches is at rest: by the entries of a matrix, and by its pieces, against the
// matrix's powers.
#include "solver/discrete/contact.hpp"
#include "solver/linear/pieces.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace hvi::solver {
namespace {

SparseMatrix random_symmetric(int n, int entries, std::mt19937& random) {
  std::uniform_int_distribution<int> any(0, n - 1);
  std::vector<Eigen::Triplet<double>> out;
  for (int i = 0; i < n; ++i) out.emplace_back(i, i, 1.0);
  for (int k = 0; k < entries; ++k) {
    const int i = any(random), j = any(random);
    out.emplace_back(i, j, 1.0), out.emplace_back(j, i, 1.0);
  }
  SparseMatrix a(n, n);
  a.setFromTriplets(out.begin(), out.end());
  return a;
}

TEST(PutAtRest, WhatNeitherLoadsNorMultipliersReach) {
  std::mt19937 random(4);
  std::uniform_int_distribution<int> any(0, 19);
  int at_rest = 0, by_multipliers = 0;
  for (int scene = 0; scene < 300; ++scene) {
    constexpr int n = 20, rows = 4;
    const SparseMatrix k = random_symmetric(n, 6 + scene % 7, random);
    Contact contact;
    contact.force.resize(n, rows);
    std::set<int> loaded;
    std::vector<Eigen::Triplet<double>> entries;
    for (int row = 0; row < rows; ++row)
      for (const double weight : {1.0, -0.5})
        entries.emplace_back(*loaded.insert(any(random)).first, row, weight);
    contact.force.setFromTriplets(entries.begin(), entries.end());
    contact.loaded.assign(loaded.begin(), loaded.end());
    Vector rhs = Vector::Zero(n), xi = Vector::Zero(rows);
    if (scene % 3 != 0) rhs[any(random)] = 1.0;
    if (scene % 2 != 0) xi[scene % rows] = -2.0;
    DenseMatrix way = DenseMatrix(k).cwiseMin(1.0);
    for (int length = 1; length < n; length *= 2) way = (way * way).cwiseMin(1.0).eval();
    // One by one: forces that cancel each other reach all the same.
    const Vector acting = rhs.cwiseAbs() + DenseMatrix(contact.force).cwiseAbs() * xi.cwiseAbs();
    const Vector reached = way * acting;
    by_multipliers +=
        static_cast<int>(((way * rhs).array() == 0.0 && reached.array() > 0.0).count());
    Vector by_matrix = Vector::Ones(n), by_pieces = Vector::Ones(n);
    put_at_rest(k, contact, rhs, xi, by_matrix);
    put_at_rest(Pieces(k), contact, rhs, xi, by_pieces);
    for (int i = 0; i < n; ++i) {
      EXPECT_EQ(by_matrix[i], reached[i] > 0.0 ? 1.0 : 0.0) << scene << " " << i;
      EXPECT_EQ(by_pieces[i], by_matrix[i]) << scene << " " << i;
      at_rest += by_matrix[i] == 0.0;
    }
  }
  EXPECT_GT(at_rest, 1000);
  EXPECT_GT(by_multipliers, 500);
}

} // namespace
} // namespace hvi::solver
