// Patterns of matrices, and how fast memory is read.
#include "matrices.hpp"
#include "solver/linear/bandwidth.hpp"
#include "solver/linear/same_pattern.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace hvi::solver::test {
namespace {

TEST(SamePattern, TellsPatternsApart) {
  const SparseMatrix a = grid_laplacian(4), b = grid_laplacian(5);
  SparseMatrix c = a;
  c.coeffRef(0, 15) = 1.0;
  EXPECT_FALSE(same_pattern(a, b));
  EXPECT_FALSE(same_pattern(a, c)); // not compressed
  c.makeCompressed();
  EXPECT_FALSE(same_pattern(a, c));
  EXPECT_TRUE(same_pattern(a, grid_laplacian(4, 3.0)));
}

TEST(ReadBandwidth, IsPlausible) {
  const double speed = read_bandwidth(8);
  EXPECT_GT(speed, 0.0);
  EXPECT_TRUE(std::isfinite(speed));
}

} // namespace
} // namespace hvi::solver::test
