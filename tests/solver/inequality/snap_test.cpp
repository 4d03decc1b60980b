// The solver's own check, on hand-made states: within rounding of a break, and a few hundred times
// as far away, on rows along an axis and turned.
#include "solver/inequality/certificate.hpp"
#include "tests/solver/inequality/problems.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace hvi::solver {
namespace {

using test::arg;

/// Two unknowns with stiffness 2, held at argument 0 by a law along (cos, sin).
struct Node {
  test::Bench bench;
  double angle;
  Node(const Expr& slope, bool radial, double angle_) : angle(angle_) {
    bench.s = 2.0 * DenseMatrix::Identity(2, 2);
    const int law = bench.slope(slope, radial);
    bench.point(law, 0.5, {{{0, std::cos(angle)}, {1, std::sin(angle)}}});
    bench.finish();
  }
  /// The inclusion that the solver certifies at c with this multiplier.
  double inclusion(const Vector& c, double xi, const Vector& r) {
    const auto op = dense_operator(bench.s, true);
    const InequalityOptions options;
    const ContactPoints points(bench.problem, *op);
    Position at(points, *op, 1e-2 * options.tolerance);
    at.balance.set_load(r);
    at.c = c;
    at.xi = Vector::Constant(1, xi);
    InequalityReport report;
    certify(at, options.tolerance, report);
    return report.inclusion;
  }
  Vector along() const { return Eigen::Vector2d(std::cos(angle), std::sin(angle)); }
  Vector across() const { return Eigen::Vector2d(-std::sin(angle), std::cos(angle)); }
};

const double angles[] = {0.0, 0.3, 0.7853981633974483, 1.2, 2.9, 4.4};

TEST(Snap, IsRoundingOfWhatTheArgumentIsMadeOf) {
  for (const double angle : angles) {
    Node stick(Expr(1.0), true, angle);
    // r = 2 c + 0.5 xi g balances; the displacement across is 1e-2.
    for (const double xi : {-0.7, 0.7}) {
      const Vector c = 1e-2 * stick.across(), r = 2.0 * c + 0.5 * xi * stick.along();
      EXPECT_EQ(stick.inclusion(c, xi, r), 0.0) << angle;
      // |G| (|c| + |r| / 2) + local |xi| is between .1 and 1 here: a snap is at most 1e-12.
      const Vector off = c - std::copysign(1e-10, xi) * stick.along();
      EXPECT_NEAR(stick.inclusion(off, xi, r), 1.7, 1e-9) << angle;
      EXPECT_EQ(stick.inclusion(c + 3e-14 * stick.along(), xi, r), 0.0) << angle;
    }
  }
}

TEST(Snap, HasAScaleWhereNothingMoves) {
  for (const double unit : {1e-9, 1.0, 1e9})
    for (const double angle : angles) {
      Node stick(Expr(1.0), true, angle);
      stick.bench.s /= unit; // displacements of that unit
      const Vector r = 0.35 * stick.along();
      for (const double part : {0.0, 1e-16, 3e-14})
        EXPECT_EQ(stick.inclusion(part * unit * stick.along(), 0.7, r), 0.0) << angle;
      EXPECT_NEAR(stick.inclusion(-1e-10 * unit * stick.along(), 0.7, r), 1.7, 1e-9) << angle;
    }
}

// An unknown on which nothing acts moves by the rounding of the others.
TEST(Snap, KnowsTheLargestDisplacement) {
  Node stick(Expr(1.0), true, 0.0);
  const Vector r = 0.35 * stick.along() + 2.0 * stick.across(); // held: 0.5 xi = r along
  const Vector c = stick.across();
  EXPECT_EQ(stick.inclusion(c, 0.7, r), 0.0);
  const Vector idle = 2.0 * stick.across();
  EXPECT_EQ(stick.inclusion(c + 3e-16 * stick.along(), 0.0, idle), 0.0);
  EXPECT_NEAR(stick.inclusion(c + 1e-12 * stick.along(), 0.0, idle), 1.0, 1e-9);
}

// More points than unknowns, bounds far above the load: multipliers that balance each other would
// be as large as the bounds and hide whether the points rest.
TEST(Snap, PointsThatShareUnknownsHaveNoIdleMultipliers) {
  for (const double bound : {1e3, 1e6, 1e10})
    for (const bool radial : {false, true}) {
      test::Bench bench;
      bench.s = (DenseMatrix(2, 2) << 200.0, -40.0, -40.0, 150.0).finished();
      const Expr slope =
          radial ? Expr(bound) : select(less_equal(arg(), Expr(0.0)), Expr(-bound), Expr(bound));
      const int law = bench.slope(slope, radial);
      for (const double a : {0.11, 0.33, 0.62, 0.91})
        bench.point(law, 0.3, {{{0, a}, {1, 1.0 - a}}});
      bench.finish();
      const auto op = dense_operator(bench.s, true);
      InequalitySolver solver(bench.problem, *op, {});
      InequalityState state;
      ASSERT_TRUE(solver.solve(Eigen::Vector2d(3.0, -7.0), state).converged) << bound;
      EXPECT_LT(state.c.lpNorm<Eigen::Infinity>(), 1e-13) << bound;
      EXPECT_LT(state.xi.lpNorm<Eigen::Infinity>(), 100.0) << bound;
    }
}

// What is known of the argument may be the rest of numbers that cancelled.
TEST(Snap, KnowsWhatCancelledInTheOffset) {
  Node stop(select(less_equal(arg(), Expr(0.0)), Expr(0.0), Expr(1e300)), false, 0.0);
  const Vector none = Vector::Zero(2);
  const auto at = [&](double offset, double size) {
    stop.bench.problem.offset = Vector::Constant(1, offset);
    stop.bench.problem.offset_size = Vector::Constant(1, size);
    const Vector r = 2e-6 * stop.along(); // xi = 4e-6: compliance times force is 1e-6
    return stop.inclusion(none, 4e-6, r);
  };
  EXPECT_EQ(at(-3e-14, 1.0), 0.0);
  EXPECT_EQ(at(-3e-10, 1.0), 1.0);
  EXPECT_EQ(at(-3e-14, 3e-14), 1.0);
}

// At a held node the balance does not see the multiplier: what is no number there is a law that
// does not hold, whichever points come after it.
/// Forces that are rounding of their own unknown's forces are none: the other one has other units.
TEST(Certificate, RoundingIsThatOfTheUnknownThatALawActsOn) {
  test::Bench setup;
  setup.s = DenseMatrix::Identity(2, 2);
  const int law = setup.slope(arg());
  for (const int unknown : {0, 1}) setup.point(law, 0.5, {{{unknown, 1.0}}});
  setup.finish();
  setup.problem.of_unknown = {0, 1};
  const auto dropped = [&](double first, double second) {
    ByUnknown most{};
    most[0] = first, most[1] = second;
    Vector xi = Vector::Constant(2, 2e-3); // forces of 1e-3
    const bool any = drop_rounding(setup.problem, most, xi);
    EXPECT_EQ(any, xi.minCoeff() == 0.0);
    return std::pair(xi[0] == 0.0, xi[1] == 0.0);
  };
  EXPECT_EQ(dropped(1e-9, 1.0), std::pair(false, true));
  EXPECT_EQ(dropped(1.0, 1e-9), std::pair(true, false));
  EXPECT_EQ(dropped(1e-9, 1e-9), std::pair(false, false));
}

TEST(Certificate, AMultiplierThatIsNoNumberIsNoSolution) {
  for (const int bad : {0, 1, 2}) {
    test::Bench bench;
    bench.s = DenseMatrix::Identity(1, 1);
    const int law = bench.slope(arg(), false);
    for (int p = 0; p < 3; ++p) bench.point(law, 0.5, {{}});
    bench.finish();
    const auto op = dense_operator(bench.s, true);
    const InequalityOptions options;
    const ContactPoints points(bench.problem, *op);
    Position at(points, *op, 1e-2 * options.tolerance);
    at.balance.set_load(Vector::Zero(1));
    at.c.setZero();
    at.xi.setZero();
    InequalityReport report;
    certify(at, options.tolerance, report);
    EXPECT_TRUE(report.converged);
    at.xi[bad] = std::nan("");
    certify(at, options.tolerance, report);
    EXPECT_FALSE(report.converged) << bad;
    EXPECT_EQ(report.worst_point, bad);
  }
}

// The break's near side, a few hundred snaps away: open, not stopped.
TEST(Snap, SolutionsNearABreakAreNotMovedOntoIt) {
  const Expr law = select(less_equal(arg(), Expr(1.0)), Expr(0.0), Expr(1e300));
  for (const double angle : angles)
    for (const double gap : {3e-10, 1e-9, 1e-7}) {
      Node stop(law, false, angle);
      for (const double side : {-1.0, 1.0}) {
        const Vector r = 2.0 * (1.0 + side * gap) * stop.along();
        const auto op = dense_operator(stop.bench.s, true);
        InequalitySolver solver(stop.bench.problem, *op, {});
        InequalityState state;
        ASSERT_TRUE(solver.solve(r, state).converged) << angle;
        const double z = stop.along().dot(state.c);
        // Beyond it by 4 gap: 2 (z - 1 - gap) + 0.5 xi = 0.
        EXPECT_NEAR(z - 1.0, side < 0 ? -gap : 0.0, 1e-12) << angle;
        EXPECT_NEAR(state.xi[0], side < 0 ? 0.0 : 4.0 * gap, 4e-12) << angle;
      }
    }
}

} // namespace
} // namespace hvi::solver
