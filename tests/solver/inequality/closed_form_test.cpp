// Small reduced inequalities with answers by hand.
#include "problems.hpp"

#include <gtest/gtest.h>

namespace hvi::solver::test {
namespace {

InequalityReport run(Bench& setup, InequalityState& state, InequalityOptions options = {},
                     bool symmetric = true) {
  const auto op = dense_operator(setup.s, symmetric);
  InequalitySolver solver(setup.problem, *op, options);
  return solver.solve(setup.r, state);
}

Bench one_spring(double k, double force) {
  Bench setup;
  setup.s = DenseMatrix::Constant(1, 1, k);
  setup.r = Vector::Constant(1, force);
  return setup;
}

TEST(Inequality, NoContactIsTheLinearProblemWithoutNewton) {
  Bench setup = one_spring(4.0, -2.0);
  setup.point(setup.slope(Expr(100.0) * max(arg(), Expr(0.0))), 0.5, {{{0, 1.0}}});
  setup.finish();
  InequalityState state;
  const auto report = run(setup, state);
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(state.c[0], -0.5);
  EXPECT_EQ(state.xi[0], 0.0);
  EXPECT_EQ(report.iterations, 0);
  EXPECT_EQ(report.factorisations, 1);
}

TEST(Inequality, CompliantSpringHasTheHarmonicAnswer) {
  Bench setup = one_spring(4.0, 2.0);
  setup.point(setup.slope(Expr(100.0) * max(arg(), Expr(0.0))), 0.5, {{{0, 1.0}}});
  setup.finish();
  InequalityState state;
  EXPECT_TRUE(run(setup, state).converged);
  EXPECT_NEAR(state.c[0], 2.0 / 54.0, 1e-16); // 4 c + .5 * 100 c = 2
  EXPECT_NEAR(state.xi[0], 100.0 * 2.0 / 54.0, 1e-14);
}

TEST(Inequality, StaysStuckBelowTheBoundAndSlipsAbove) {
  for (const double force : {-0.9, -0.29, 0.0, 0.1, 0.3, 0.31, 5.0}) {
    Bench setup = one_spring(2.0, force);
    setup.point(setup.potential(Expr(0.3) * arg(), true), 1.0, {{{0, 1.0}}});
    setup.finish();
    InequalityState state;
    EXPECT_TRUE(run(setup, state).converged) << force;
    const double slip = std::copysign(std::max(0.0, std::abs(force) - 0.3), force) / 2.0;
    EXPECT_NEAR(state.c[0], slip, 2e-14) << force; // at the bound itself stick and slip meet
    EXPECT_NEAR(state.xi[0], force - 2.0 * slip, 1e-12) << force;
  }
}

TEST(Inequality, RestsOnAnUpwardJumpForManySteps) {
  Bench setup = one_spring(1.0, 0.0);
  setup.point(setup.slope(select(less(arg(), Expr(1.0)), arg(), arg() + Expr(4.0))), 1.0,
              {{{0, 1.0}}});
  setup.finish();
  const auto op = dense_operator(setup.s, true);
  InequalitySolver solver(setup.problem, *op, {});
  InequalityState state;
  for (double force = 0.0; force <= 10.0; force += 0.125) {
    const auto report = solver.solve(Vector::Constant(1, force), state);
    ASSERT_TRUE(report.converged) << report.verdict;
    const double expected = force < 2 ? force / 2 : (force <= 6 ? 1.0 : (force - 4) / 2);
    EXPECT_NEAR(state.c[0], expected, 1e-14) << force;
    EXPECT_NEAR(state.xi[0], force - expected, 1e-12) << force;
    EXPECT_LE(report.iterations, 3);
    EXPECT_EQ(report.events, 0);
  }
}

/// k z + slope = f with slope 24 z below .5 and 8 z + 4 above: the lower branch ends at f = 12 + .5
/// k, on the way back the upper one at f = 8 + .5 k.
TEST(Inequality, ReleasesAtADownwardJumpAndReturnsLater) {
  Bench setup = one_spring(1.0, 0.0);
  setup.point(setup.slope(select(less(arg(), Expr(0.5)), Expr(24.0) * arg(),
                                 Expr(8.0) * arg() + Expr(4.0))),
              1.0, {{{0, 1.0}}});
  setup.finish();
  const auto op = dense_operator(setup.s, true);
  InequalitySolver solver(setup.problem, *op, {});
  InequalityState state;
  int events = 0, reattached = 0;
  const auto step = [&](double force, double expected) {
    const auto report = solver.solve(Vector::Constant(1, force), state);
    ASSERT_TRUE(report.converged) << force << report.verdict;
    EXPECT_NEAR(state.c[0], expected, 1e-14) << force;
    events += report.events, reattached += report.reattached;
  };
  for (double f = 0.0; f <= 12.5; f += 0.25) step(f, f / 25);
  EXPECT_EQ(events, 0);
  step(12.75, (12.75 - 4) / 9);
  EXPECT_EQ(events, 1);
  EXPECT_EQ(reattached, 0); // from 12 down to 8
  for (double f = 12.75; f >= 8.5; f -= 0.25) step(f, (f - 4) / 9);
  EXPECT_EQ(events, 1);
  step(8.25, 8.25 / 25);
  EXPECT_EQ(events, 2);
  EXPECT_EQ(reattached, 1); // and back to the larger force
}

/// A point of any weight, with a law that has the same force.
TEST(Inequality, BranchesOfABistableSpring) {
  const auto solve = [](Branch branch, double force, double weight) {
    Bench setup = one_spring(1.0, force);
    setup.point(setup.slope(Expr(1.0 / weight) * select(less(arg(), Expr(0.5)), Expr(24.0) * arg(),
                                                        Expr(8.0) * arg() + Expr(4.0))),
                weight, {{{0, 1.0}}});
    setup.finish();
    InequalityState state;
    InequalityOptions options;
    options.branch = branch;
    EXPECT_TRUE(run(setup, state, options).converged);
    return state.c[0];
  };
  // Energies: -f^2/50 against c^2/2 + 3 + 4 (c^2 - .25) + 4 (c - .5) - f c; they cross at f = 10.
  const auto lower = [](double f) { return -f * f / 50; };
  const auto upper = [](double f) {
    const double c = (f - 4) / 9;
    return c * c / 2 + 3 + 4 * (c * c - .25) + 4 * (c - .5) - f * c;
  };
  EXPECT_NEAR(lower(10.0), upper(10.0), 1e-14);
  for (const double weight : {0.125, 1.0, 8.0})
    for (const double f : {9.0, 9.9, 10.1, 11.0, 12.0}) {
      SCOPED_TRACE(f);
      EXPECT_NEAR(solve(Branch::continuing, f, weight), f / 25, 1e-14);
      EXPECT_NEAR(solve(Branch::release, f, weight), (f - 4) / 9, 1e-14); // whatever its energy
      EXPECT_NEAR(solve(Branch::least_energy, f, weight),
                  lower(f) < upper(f) ? f / 25 : (f - 4) / 9, 1e-13);
    }
}

/// Two bonds one behind the other, of which the step overloads both: the one that gives way first
/// takes the load off the other, which holds.
TEST(Inequality, BondsInARowGiveWayOneAfterTheOther) {
  constexpr double k = 10.0, s = 0.1;
  for (const bool first_is_weaker : {true, false}) {
    Bench setup;
    setup.s = s * DenseMatrix::Identity(2, 2);
    const double ends[] = {first_is_weaker ? 1.0 : 1.2, first_is_weaker ? 1.2 : 1.0};
    const auto bond = [&](double end) {
      return setup.slope(select(less(arg(), Expr(end)), Expr(k) * arg(), Expr(0.0)));
    };
    setup.point(bond(ends[0]), 1.0, {{{0, 1.0}}});
    setup.point(bond(ends[1]), 1.0, {{{1, 1.0}, {0, -1.0}}});
    setup.finish();
    setup.r = Vector::Unit(2, 1) * 13.3; // both would be stretched to about 1.3
    InequalityState state;
    const auto report = run(setup, state);
    EXPECT_TRUE(report.converged);
    EXPECT_EQ(report.events, 1);
    const DenseMatrix g = first_is_weaker ? DenseMatrix{{-1.0, 1.0}} : DenseMatrix{{1.0, 0.0}};
    const Vector expected = (setup.s + k * g.transpose() * g).llt().solve(setup.r);
    EXPECT_LE((state.c - expected).norm(), 1e-10 * expected.norm());
  }
}

/// A point dragged around a circle in 3D: slip follows the force, |xi| = mu.
TEST(Inequality, SlipDirectionTurnsThroughAFullCircle) {
  Bench setup;
  setup.s = 3.0 * DenseMatrix::Identity(2, 2);
  setup.r = Vector::Zero(2);
  setup.point(setup.potential(Expr(0.5) * arg(), true), 2.0, {{{0, 1.0}}, {{1, 1.0}}});
  setup.finish();
  const auto op = dense_operator(setup.s, true);
  InequalitySolver solver(setup.problem, *op, {});
  InequalityState state;
  for (int k = 0; k <= 72; ++k) {
    const double a = k * 2 * M_PI / 72;
    Vector force(2);
    force << 4.0 * std::cos(a), 4.0 * std::sin(a);
    const auto report = solver.solve(force, state);
    ASSERT_TRUE(report.converged) << report.verdict;
    EXPECT_NEAR(state.c[0], std::cos(a), 1e-12); // 3 c + 2 * .5 = 4
    EXPECT_NEAR(state.c[1], std::sin(a), 1e-12);
    EXPECT_NEAR(state.xi.norm(), 0.5, 1e-12);
    EXPECT_LE(report.iterations, 6);
    EXPECT_FALSE(report.used_fallback);
  }
}

/// Two blocks joined by a spring: pulled, the first slips before the second.
TEST(Inequality, TwoBlocksSlipOneAfterTheOther) {
  Bench setup;
  setup.s = DenseMatrix(2, 2);
  setup.s << 2.0, -1.0, -1.0, 2.0;
  setup.r = Vector::Zero(2);
  const int law = setup.potential(arg(), true);
  setup.point(law, 1.0, {{{0, 1.0}}});
  setup.point(law, 1.0, {{{1, 1.0}}});
  setup.finish();
  const auto op = dense_operator(setup.s, true);
  InequalitySolver solver(setup.problem, *op, {});
  InequalityState state;
  for (double f = 0.0; f <= 6.0; f += 0.25) {
    Vector force(2);
    force << f, 0.0;
    const auto report = solver.solve(force, state);
    ASSERT_TRUE(report.converged) << f << ": " << report.verdict;
    const double first = f <= 1 ? 0 : (f <= 3 ? (f - 1) / 2 : (2 * (f - 1) - 1) / 3);
    const double second = f <= 3 ? 0 : (first - 1) / 2;
    EXPECT_NEAR(state.c[0], first, 2e-14) << f;
    EXPECT_NEAR(state.c[1], second, 2e-14) << f;
  }
}

TEST(Inequality, OverdeterminedPointsShareOneUnknown) {
  Bench setup;
  setup.s = chain(3, 0.5);
  setup.r = Vector::Constant(3, 0.4);
  const int law = setup.potential(arg(), true);
  // Six points on three unknowns, all stuck: c = 0 although xi is not unique.
  for (int k = 0; k < 6; ++k)
    setup.point(law, 0.3, {{{k % 3, 0.25 * (1 + k / 3)}, {(k + 1) % 3, 1.0}}});
  setup.finish();
  InequalityState state;
  const auto report = run(setup, state);
  EXPECT_TRUE(report.converged) << report.verdict;
  EXPECT_LE(state.c.lpNorm<Eigen::Infinity>(), 1e-13);
}

TEST(Inequality, UnsymmetricOperator) {
  Bench setup;
  setup.s = DenseMatrix(2, 2);
  setup.s << 2.0, -1.5, 0.5, 2.0;
  setup.r = Vector(2);
  setup.r << 3.0, 1.0;
  setup.point(setup.slope(max(arg(), Expr(0.0)) * Expr(2.0)), 1.0, {{{0, 1.0}}});
  setup.point(setup.potential(Expr(5.0) * arg(), true), 1.0, {{{1, 1.0}}});
  setup.finish();
  for (const bool fallback : {false, true}) {
    InequalityState state;
    InequalityOptions options;
    options.force_fallback = fallback;
    EXPECT_TRUE(run(setup, state, options, false).converged);
    EXPECT_NEAR(state.c[0], 0.75, 1e-13); // (2 + 2) c0 = 3, c1 stuck: .5 * .75 + xi = 1
    EXPECT_NEAR(state.c[1], 0.0, 1e-13);
    EXPECT_NEAR(state.xi[1], 0.625, 1e-12);
  }
}

Expr rigid() { return select(less_equal(arg(), Expr(0.0)), Expr(0.0), Expr(1e300)); }

/// All sets of points that may touch are tried: the one with forces that push and gaps that stay
/// open is the answer (independent).
Vector obstacle_by_enumeration(const DenseMatrix& s, const Vector& r, const Vector& gap) {
  const int n = static_cast<int>(r.size());
  for (unsigned set = 0; set < 1u << n; ++set) {
    DenseMatrix a = s;
    Vector b = r;
    for (int i = 0; i < n; ++i)
      if (set >> i & 1u) a.row(i) = Vector::Unit(n, i).transpose(), b[i] = gap[i];
    const Vector c = a.partialPivLu().solve(b), force = r - s * c;
    bool good = true;
    for (int i = 0; i < n; ++i) good = good && (set >> i & 1u ? force[i] >= 0.0 : c[i] <= gap[i]);
    if (good) return c;
  }
  return {};
}

TEST(Inequality, UnilateralContactIsTheObstacleProblem) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  for (int k = 0; k < 40; ++k) {
    Bench setup;
    const int n = 6;
    setup.s = random_spd(n, 1e4, random);
    setup.r.resize(n);
    Vector gap(n);
    for (int i = 0; i < n; ++i)
      setup.r[i] = normal(random), gap[i] = 0.3 * std::abs(normal(random));
    const int law = setup.slope(rigid());
    for (int i = 0; i < n; ++i) setup.point(law, 0.5, {{{i, 1.0}}}, {-gap[i]});
    setup.finish();
    const Vector expected = obstacle_by_enumeration(setup.s, setup.r, gap);
    for (const bool fallback : {false, true}) {
      InequalityState state;
      InequalityOptions options;
      options.force_fallback = fallback;
      const auto report = run(setup, state, options);
      ASSERT_TRUE(report.converged) << k << " " << report.verdict;
      EXPECT_LE((state.c - expected).lpNorm<Eigen::Infinity>(),
                1e-11 * expected.lpNorm<Eigen::Infinity>());
      const Vector force = 0.5 * state.xi; // what the certificate calls small is small beside it
      EXPECT_LE((setup.r - setup.s * expected - force).lpNorm<Eigen::Infinity>(),
                1e-11 * setup.r.lpNorm<Eigen::Infinity>());
    }
  }
}

TEST(Inequality, ARigidGroundIsNoScaleOfTheCertificate) {
  Bench setup = one_spring(1.0, 2.0);
  setup.point(setup.slope(rigid()), 1.0, {{{0, 1.0}}});
  setup.finish();
  const LawConstants constants = setup.problem.laws[0]->constants({}, 0.0);
  EXPECT_EQ(constants.slope_scale, 0.0);
  EXPECT_EQ(constants.c, std::numeric_limits<double>::infinity());
  EXPECT_EQ(constants.m, 0.0);
  InequalityState state;
  EXPECT_TRUE(run(setup, state).converged);
  EXPECT_EQ(state.c[0], 0.0);
  EXPECT_EQ(state.xi[0], 2.0);
}

TEST(Inequality, RejectsANonFiniteRightHandSide) {
  Bench setup = one_spring(1.0, std::nan(""));
  setup.point(setup.slope(arg()), 1.0, {{{0, 1.0}}});
  setup.finish();
  InequalityState state;
  const auto report = run(setup, state);
  EXPECT_FALSE(report.converged);
  EXPECT_NE(report.verdict.find("not finite"), std::string::npos);
}

} // namespace
} // namespace hvi::solver::test
