// Friction of a vector from starts that are hard: slips that are nearly nothing.
#include "problems.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace hvi::solver::test {
namespace {

/// The secant bound / |z| of a point that slips by next to nothing is beyond all numbers: the
/// stiffness that stands for it has to end somewhere, or no factor of S + H is to be had.
TEST(Friction, ASlipThatIsNearlyNothingIsHeldByAFiniteStiffness) {
  const double bound = 0.3, weight = 0.7;
  for (const double size : {1e-310, 1e-200, 1e-100, 1e-20})
    for (const double pull : {0.1, 1.0}) { // sticks, slips
      Bench setup;
      setup.s.resize(2, 2);
      setup.s << 2.0, 0.5, 0.5, 3.0;
      setup.r = Vector{{0.8 * pull, -0.6 * pull}};
      setup.point(setup.potential(Expr(bound) * arg(), true), weight, {{{0, 1.0}}, {{1, 1.0}}});
      setup.finish();
      InequalityState state;
      state.c = Vector{{size, -size}};
      state.xi = Vector{{bound, 0.0}};
      state.state = {0}; // slips
      const auto op = dense_operator(setup.s, true);
      InequalitySolver solver(setup.problem, *op, {});
      const auto report = solver.solve(setup.r, state);
      ASSERT_TRUE(report.converged) << size << " " << pull << report.verdict;
      EXPECT_FALSE(report.used_fallback) << size << " " << pull;
      const double slip = state.c.norm();
      EXPECT_EQ(slip > 0.0, pull == 1.0) << size;
      EXPECT_LE((setup.s * state.c + weight * state.xi - setup.r).norm(), 1e-12);
      if (slip > 0.0) {
        EXPECT_LE((state.xi - bound / slip * state.c).norm(), 1e-11);
      } else {
        EXPECT_LE(state.xi.norm(), bound);
      }
    }
}

} // namespace
} // namespace hvi::solver::test
