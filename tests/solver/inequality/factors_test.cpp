// Laws that see the unknowns times a factor: the same as rows times the factor and weights over it.
#include "problems.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace hvi::solver::test {
namespace {

constexpr int unknowns = 8;

/// Points of one law each, about half of them of a second application, whose rows are shared.
Bench random_bench(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Bench out;
  out.s = random_spd(unknowns, 100.0, random);
  std::vector<int> laws;
  for (const KnownLaw& law : known_laws())
    if (std::isfinite(law.m)) laws.push_back(out.law(law.spec));
  const auto pick = [&](std::size_t count) { return static_cast<int>(random() % count); };
  for (int p = 0; p < 2 * unknowns; ++p)
    out.point(laws[static_cast<std::size_t>(pick(laws.size()))],
              0.1 + 0.2 * std::abs(uniform(random)),
              {{{pick(unknowns), uniform(random)}, {pick(unknowns), uniform(random)}}},
              {0.3 * uniform(random)});
  out.finish();
  out.set_margin(0.5);
  for (auto& point : out.problem.points) point.application = pick(2);
  out.r = Vector::NullaryExpr(unknowns, [&] { return uniform(random); }) * out.s.diagonal().mean();
  return out;
}

/// The problem whose rows and weights have the factors in them.
ReducedProblem with_factors(const ReducedProblem& problem, const std::array<double, 2>& factors) {
  ReducedProblem out = problem;
  for (auto& point : out.points) {
    const double factor = factors[static_cast<std::size_t>(point.application)];
    point.weight /= factor;
    for (int row = point.first_row; row < point.first_row + point.rows; ++row)
      for (SparseMatrix::InnerIterator it(out.g, row); it; ++it) it.valueRef() *= factor;
  }
  return out;
}

TEST(Factors, AreRowsAndWeightsWithThem) {
  int solved = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> decades(-3.0, 3.0);
    const Bench bench = random_bench(random);
    const std::array<double, 2> factors{1.0, std::pow(10.0, decades(random))};
    const ReducedProblem scaled = with_factors(bench.problem, factors);
    DenseMatrix s = bench.s; // the laws on the second argument soften as much faster
    s.diagonal() *= std::max(1.0, factors[1]);
    const auto op = dense_operator(s, true), other = dense_operator(s, true);
    std::vector<double> by_row(2 * slot::most_arguments, 1.0);
    std::fill(by_row.begin() + slot::most_arguments, by_row.end(), factors[1]);
    InequalitySolver solver(bench.problem, *op, {}, by_row), reference(scaled, *other, {});
    InequalityState state, expected;
    const bool found = reference.solve(bench.r, expected).converged;
    ASSERT_EQ(solver.solve(bench.r, state).converged, found) << seed;
    if (!found) continue;
    ++solved;
    EXPECT_LE((state.c - expected.c).lpNorm<Eigen::Infinity>(),
              1e-12 * expected.c.lpNorm<Eigen::Infinity>())
        << seed;
    EXPECT_LE((state.xi - expected.xi).lpNorm<Eigen::Infinity>(),
              1e-12 * (1.0 + expected.xi.lpNorm<Eigen::Infinity>()))
        << seed;
    EXPECT_EQ(solver.convex(), reference.convex()) << seed;
  }
  EXPECT_GT(solved, 190);
}

} // namespace
} // namespace hvi::solver::test
