// A front of slip that runs over many points: solves with an old factor against fresh ones.
#include "problems.hpp"

#include <gtest/gtest.h>

namespace hvi::solver::test {
namespace {

/// Points on a line with two tangential unknowns each, coupled as a body couples them. Friction
/// weakens from .5 to .4 over a slip of about 1 / rate.
Bench line(int points, double rate) {
  Bench setup;
  const DenseMatrix one = chain(points, 0.05);
  setup.s = DenseMatrix::Zero(2 * points, 2 * points);
  for (int i = 0; i < points; ++i)
    for (int j = 0; j < points; ++j) {
      setup.s(2 * i, 2 * j) = one(i, j);
      setup.s(2 * i + 1, 2 * j + 1) = 1.5 * one(i, j);
    }
  const int law = setup.slope(Expr(0.4) + Expr(0.1) * exp(Expr(-rate) * arg()), true);
  for (int i = 0; i < points; ++i) setup.point(law, 0.1, {{{2 * i, 1.0}}, {{2 * i + 1, 1.0}}});
  setup.finish();
  return setup;
}

/// The load grows, stops, and comes back; it pulls one end harder, and turns.
Vector load(int points, double t) {
  Vector r(2 * points);
  const double size = t < 0.6 ? t : 1.2 - t;
  for (int i = 0; i < points; ++i) {
    const double here = 0.3 * size * std::exp(-2.0 * i / points);
    r[2 * i] = here * std::cos(t), r[2 * i + 1] = here * std::sin(t);
  }
  return r;
}

TEST(Front, StepsWithAnOldFactorEqualColdStarts) {
  constexpr int points = 120, steps = 40;
  const Bench setup = line(points, 2.0);
  const auto op = dense_operator(setup.s, true);
  InequalitySolver solver(setup.problem, *op, {});
  InequalityState state;
  int factorisations = 0, iterations = 0, most_slip = 0, least_slip = points;
  for (int k = 1; k <= steps; ++k) {
    const Vector r = load(points, static_cast<double>(k) / steps);
    const auto report = solver.solve(r, state);
    ASSERT_TRUE(report.converged) << k << ": " << report.verdict;
    EXPECT_FALSE(report.used_fallback) << k;
    factorisations += report.factorisations, iterations += report.iterations;
    const auto fresh = dense_operator(setup.s, true);
    InequalityState cold;
    ASSERT_TRUE(InequalitySolver(setup.problem, *fresh, {}).solve(r, cold).converged) << k;
    EXPECT_LE((state.c - cold.c).lpNorm<Eigen::Infinity>(),
              1e-9 * (1e-3 + cold.c.lpNorm<Eigen::Infinity>()))
        << k;
    int slip = 0;
    for (const int s : state.state) slip += s >= 0 ? 1 : 0;
    most_slip = std::max(most_slip, slip), least_slip = std::min(least_slip, slip);
  }
  EXPECT_EQ(least_slip, 0);                  // all of them stick at first,
  EXPECT_GE(most_slip, points / 2);          // most slip later,
  EXPECT_LE(2 * factorisations, iterations); // and most solves went without a new factor
}

/// Branches of vector laws are not followed: looking for them must not cost the factor.
TEST(Front, StepsThatMayHaveSeveralSolutionsKeepTheirFactor) {
  constexpr int points = 120, steps = 40;
  const Bench setup = line(points, 12.0);
  const auto op = dense_operator(setup.s, true);
  InequalitySolver solver(setup.problem, *op, {});
  EXPECT_FALSE(solver.convex());
  InequalityState state;
  int factorisations = 0, unfollowed = 0;
  state.c = Vector::Zero(setup.s.rows()), state.xi = Vector::Zero(setup.problem.g.rows());
  for (int k = 1; k <= steps; ++k) {
    state.z_before = setup.problem.g * state.c, state.xi_before = state.xi;
    const auto report = solver.solve(load(points, static_cast<double>(k) / steps), state);
    ASSERT_TRUE(report.converged) << k << ": " << report.verdict;
    factorisations += report.factorisations;
    unfollowed += report.not_followed ? 1 : 0;
  }
  EXPECT_EQ(unfollowed, steps);
  EXPECT_LE(factorisations, 3 * steps / 2); // about one a step; two where the factor is lost
}

} // namespace
} // namespace hvi::solver::test
