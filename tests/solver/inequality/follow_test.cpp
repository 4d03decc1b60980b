// Branches followed from the last state: limit points by hand, and answers that do not depend on
// the number of steps.
#include "problems.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace hvi::solver::test {
namespace {

/// Solves for `load` times the unit force from the state, on the branch that continues it.
InequalityReport go_on(InequalitySolver& solver, const Bench& setup, double load,
                       InequalityState& state) {
  state.z_before = setup.problem.offset;
  if (state.c.size() > 0) state.z_before += setup.problem.g * state.c;
  return solver.solve(load * setup.r, state);
}

Bench one_spring(Expr slope) {
  Bench setup;
  setup.s = DenseMatrix::Constant(1, 1, 1.0);
  setup.r = Vector::Constant(1, 1.0);
  setup.point(setup.slope(slope), 1.0, {{{0, 1.0}}});
  setup.finish();
  return setup;
}

/// 100 r up to .01, then 20 a unit down to .96 at .012, then nothing: the load r + xi has its
/// largest value 1.01 at r = .01, and beyond it the state that follows has xi = 0.
TEST(Follow, SofteningThenADropInOneStep) {
  Bench setup = one_spring(select(
      less(arg(), Expr(0.01)), Expr(100.0) * arg(),
      select(less(arg(), Expr(0.012)), Expr(1.0) - Expr(20.0) * (arg() - Expr(0.01)), Expr(0.0))));
  const auto op = dense_operator(setup.s, true);
  for (const double load : {1.012, 1.5, 20.0}) {
    InequalitySolver solver(setup.problem, *op, {});
    InequalityState state;
    ASSERT_TRUE(go_on(solver, setup, 0.5, state).converged);
    const auto report = go_on(solver, setup, load, state);
    ASSERT_TRUE(report.converged) << load << report.verdict;
    EXPECT_NEAR(state.c[0], load, 1e-12 * load);
    ASSERT_EQ(report.branch_ends.size(), 1u);
    EXPECT_NEAR(0.5 + report.branch_ends[0] * (load - 0.5), 1.01, 1e-8);
    EXPECT_GT(report.inner_steps, 2);
  }
}

/// 40 r exp(-10 r): r + xi has its largest value where 1 + 40 (1 - 10 r) exp(-10 r) = 0.
TEST(Follow, LimitPointOfACurvedLaw) {
  Bench setup = one_spring(select(less(arg(), Expr(0.0)), Expr(40.0) * arg(),
                                  Expr(40.0) * arg() * exp(Expr(-10.0) * arg())));
  const auto force = [](double r) { return r + 40.0 * r * std::exp(-10.0 * r); };
  double low = 0.1, high = 0.19;
  for (int k = 0; k < 100; ++k) {
    const double r = 0.5 * (low + high);
    (1.0 + 40.0 * (1.0 - 10.0 * r) * std::exp(-10.0 * r) > 0.0 ? low : high) = r;
  }
  const auto op = dense_operator(setup.s, true);
  for (const int steps : {1, 2, 7, 40}) {
    InequalitySolver solver(setup.problem, *op, {});
    InequalityState state;
    int ends = 0;
    for (int n = 1; n <= steps; ++n) {
      const auto report = go_on(solver, setup, 2.0 * n / steps, state);
      ASSERT_TRUE(report.converged) << report.verdict;
      EXPECT_FALSE(report.not_followed);
      for (const double end : report.branch_ends) {
        EXPECT_NEAR((n - 1 + end) * 2.0 / steps, force(low), 1e-7);
        ++ends;
      }
      EXPECT_NEAR(force(state.c[0]), 2.0 * n / steps, 1e-10);
    }
    EXPECT_EQ(ends, 1);
    EXPECT_GT(state.c[0], 1.9); // beyond the snap
  }
}

/// A stable piece that softens is followed where Newton's method from the last state jumps over
/// it: a chain of springs whose ends soften one by one.
TEST(Follow, AnswersDoNotDependOnTheNumberOfSteps) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  int ended = 0, compared = 0, iterations = 0;
  for (int scene = 0; scene < 300; ++scene) {
    const int n = 2 + scene % 5;
    Bench setup;
    DenseMatrix a(n, n);
    for (double& v : a.reshaped()) v = any(random) - 0.5;
    setup.s = a * a.transpose() + DenseMatrix::Identity(n, n);
    setup.r = Vector::Ones(n);
    for (int i = 0; i < n; ++i) setup.r[i] += any(random);
    const double peak = 0.2 + 0.3 * any(random), fall = 0.3 + 3.0 * any(random),
                 rest = 0.1 * any(random), stiff = 1.0 + 3.0 * any(random);
    const Expr tail = Expr(stiff * peak) - Expr(fall) * (arg() - Expr(peak));
    const double end = peak + 0.8 * stiff * peak / fall;
    for (int i = 0; i < n; ++i)
      setup.point(setup.slope(select(less(arg(), Expr(peak)), Expr(stiff) * arg(),
                                     select(less(arg(), Expr(end)), tail, Expr(rest)))),
                  0.5 + any(random), {{{i, 1.0}}});
    setup.finish();
    const auto op = dense_operator(setup.s, true);
    Vector last;
    for (const int steps : {1, 5, 60}) {
      InequalitySolver solver(setup.problem, *op, {});
      InequalityState state;
      for (int k = 1; k <= steps; ++k) {
        const auto report = go_on(solver, setup, 3.0 * k / steps, state);
        ASSERT_TRUE(report.converged) << scene << report.verdict;
        ASSERT_FALSE(report.not_followed) << scene;
        ended += static_cast<int>(report.branch_ends.size());
        iterations += report.iterations;
      }
      if (last.size() > 0) {
        EXPECT_LT((state.c - last).norm(), 1e-7 * last.norm()) << "scene " << scene;
        ++compared;
      }
      last = state.c;
    }
  }
  EXPECT_EQ(compared, 600);
  EXPECT_GT(ended, 2000);
  EXPECT_LT(iterations, 2 * 300 * 66);
}

/// Without an energy no state is called stable: the step is solved, and says that its branch was
/// not followed.
TEST(Follow, IsNotDoneWithoutSymmetry) {
  Bench setup;
  setup.s = DenseMatrix::Identity(2, 2);
  setup.s(0, 1) = 0.7, setup.s(1, 0) = -0.4;
  setup.r = Vector::Ones(2);
  const Expr slope = select(less(arg(), Expr(0.2)), Expr(5.0) * arg(),
                            max(Expr(0.0), Expr(1.0) - Expr(4.0) * (arg() - Expr(0.2))));
  for (int i = 0; i < 2; ++i) setup.point(setup.slope(slope), 1.0 + 0.3 * i, {{{i, 1.0}}});
  setup.finish();
  const auto op = dense_operator(setup.s, false);
  InequalitySolver solver(setup.problem, *op, {});
  InequalityState state;
  bool said = false;
  for (int k = 1; k <= 50; ++k) {
    const auto report = go_on(solver, setup, 4.0 * k / 50, state);
    ASSERT_TRUE(report.converged);
    EXPECT_EQ(report.inner_steps, 0);
    said = said || report.not_followed;
  }
  EXPECT_TRUE(said);
}

/// Several solutions on one contact unknown: the least energy of all, found by brute force.
TEST(Follow, LeastEnergyIsTheLeast) {
  const double m = 1.6;
  Bench setup =
      one_spring(select(less(arg(), Expr(0.0)), Expr(0.0),
                        select(less(arg(), Expr(0.5)), Expr(2.0) * arg(),
                               max(Expr(0.0), Expr(1.0) - Expr(m) * (arg() - Expr(0.5))))));
  const auto slope = [&](double r) {
    return r < 0.0 ? 0.0 : (r < 0.5 ? 2.0 * r : std::max(0.0, 1.0 - m * (r - 0.5)));
  };
  const auto op = dense_operator(setup.s, true);
  for (const double load : {0.9, 1.2, 1.3, 1.4, 1.6}) {
    double best = 0.0, lowest = 0.0, stored = 0.0;
    for (int k = 0; k < 400000; ++k) {
      const double r = k * 1e-5;
      const double energy = 0.5 * r * r + stored - load * r;
      if (energy < lowest) lowest = energy, best = r;
      stored += 1e-5 * slope(r + 0.5e-5);
    }
    InequalityOptions options;
    options.branch = Branch::least_energy;
    InequalitySolver solver(setup.problem, *op, options);
    InequalityState state;
    ASSERT_TRUE(go_on(solver, setup, load, state).converged);
    EXPECT_NEAR(state.c[0], best, 2e-5) << load;
  }
}

} // namespace
} // namespace hvi::solver::test
