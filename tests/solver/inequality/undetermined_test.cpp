// Friction at more points than the side has unknowns, beside a node that is moved: the slip falls
// from facet to facet by powers of ten, most points stick, and the equations leave some of their
// multipliers undetermined.
#include "problems.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace hvi::solver::test {
namespace {

constexpr double gauss_points[] = {-0.7745966692414834, 0.0, 0.7745966692414834};
constexpr double gauss_weights[] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};

struct Side {
  Bench bench;
  std::vector<KnownLaw> laws;
};

/// A row of quadratic facets with three points each; the first node is moved by `moved`, the others
/// are unknowns, one each, or two where the law is of vectors.
Side side_of(unsigned seed, bool radial) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const int facets = 2 + static_cast<int>(random() % 6), nodes = 2 * facets;
  const int rows = radial && random() % 2 == 0 ? 2 : 1;
  const double bound = std::pow(10.0, 10.0 * uniform(random) - 2.0), moved = uniform(random) - 0.5;
  Side out;
  if (radial)
    out.bench.slope(Expr(bound), true);
  else
    out.bench.potential(Expr(bound) * abs(arg()));
  const auto slope = [bound](double v) { return v < 0.0 ? -bound : bound; };
  out.laws.push_back({"friction",
                      out.bench.owned.front()->spec(),
                      slope,
                      {},
                      radial ? std::vector<double>{} : std::vector<double>{0.0},
                      0.0,
                      bound,
                      0.0});
  out.bench.s = random_spd(rows * nodes, std::pow(10.0, 4.0 * uniform(random)), random);
  for (int facet = 0; facet < facets; ++facet) {
    const double size = 0.2 + uniform(random);
    for (int q = 0; q < 3; ++q) {
      const double x = gauss_points[q];
      const double shape[] = {x * (x - 1.0) / 2.0, 1.0 - x * x, x * (x + 1.0) / 2.0};
      std::vector<std::vector<std::pair<int, double>>> point(rows);
      std::vector<double> offset(rows, 0.0);
      for (int row = 0; row < rows; ++row)
        for (int k = 0; k < 3; ++k) {
          const int node = 2 * facet + k - 1;
          if (node < 0)
            offset[row] = shape[k] * moved * (row == 0 ? 1.0 : 0.3);
          else
            point[row].emplace_back(rows * node + row, shape[k]);
        }
      out.bench.point(0, gauss_weights[q] * size, point, offset);
    }
  }
  out.bench.finish();
  out.bench.r = 0.1 * Vector::Random(rows * nodes);
  return out;
}

class StickBesideAMovedNode : public testing::TestWithParam<bool> {};

TEST_P(StickBesideAMovedNode, IsSolvedForEveryBound) {
  const bool radial = GetParam();
  int refused = 0, by_fallback = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    const Side side = side_of(seed, radial);
    const auto op = dense_operator(side.bench.s, true);
    InequalitySolver solver(side.bench.problem, *op, {});
    InequalityState state;
    const auto report = solver.solve(side.bench.r, state);
    by_fallback += report.used_fallback ? 1 : 0;
    refused += report.converged ? 0 : 1;
    if (!report.converged) continue;
    const Certificate own = recompute(side.bench, {&side.laws.front()}, state, 1e-10);
    EXPECT_LE(own.residual, 1e-10) << seed;
    EXPECT_LE(own.inclusion, 1e-10) << seed;
  }
  RecordProperty("by_fallback", by_fallback);
  EXPECT_EQ(refused, 0) << "of 200, " << by_fallback << " by the globally convergent method";
}

INSTANTIATE_TEST_SUITE_P(Laws, StickBesideAMovedNode, testing::Bool());

} // namespace
} // namespace hvi::solver::test
