// Branches followed from the last state: limit points by hand, and answers that do not depend on
// the number of steps.
#include "problems.hpp"
#include "solver/inequality/curve_walk.hpp"
#include "solver/inequality/equilibrium_curve.hpp"

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

/// The stationary states of least energy among all combinations of pieces and upward breaks: one
/// linear solve each. S z = r - w xi, xi = v_i + s_i (z - x_i) on piece i; z held at a break.
struct BruteLaw {
  std::vector<double> breaks, v, s; ///< piece i from breaks[i - 1] (the first: from breaks[0])
  double slope(int i, double z) const { return v[i] + s[i] * (z - breaks[std::max(i - 1, 0)]); }
  double energy(double z) const { // from breaks[0]
    double sum = 0.0, at = breaks[0];
    const auto part = [&](int i, double from, double to) {
      return 0.5 * (to - from) * (slope(i, from) + slope(i, to));
    };
    if (z <= at) return -part(0, z, at);
    for (std::size_t i = 1; i < v.size(); ++i) {
      const double to = i < breaks.size() ? std::min(breaks[i], z) : z;
      sum += part(static_cast<int>(i), at, to);
      if (to >= z) break;
      at = to;
    }
    return sum;
  }
};

double brute_least(const Bench& setup, const std::vector<BruteLaw>& laws,
                   const std::vector<double>& weights, const Vector& r) {
  const auto n = static_cast<int>(r.size());
  std::vector<int> place(n, 0);
  double lowest = std::numeric_limits<double>::infinity();
  const auto consider = [&] {
    DenseMatrix k = setup.s;
    Vector b = r;
    for (int p = 0; p < n; ++p) {
      const BruteLaw& law = laws[p];
      const int i = place[p] / 2;
      if (place[p] % 2 == 0) {
        k(p, p) += weights[p] * law.s[i];
        b[p] -= weights[p] * (law.v[i] - law.s[i] * law.breaks[std::max(i - 1, 0)]);
      } else {
        k.row(p).setZero(), k(p, p) = 1.0, b[p] = law.breaks[i];
      }
    }
    const Vector z = k.partialPivLu().solve(b);
    double sum = 0.5 * z.dot(setup.s * z) - r.dot(z); // feasible, so never below the least
    for (int p = 0; p < n; ++p) sum += weights[p] * laws[p].energy(z[p]);
    if (sum < lowest) lowest = sum;
  };
  for (;;) {
    consider();
    int p = 0;
    while (p < n && ++place[p] == static_cast<int>(2 * laws[p].breaks.size() + 1)) place[p++] = 0;
    if (p == n) return lowest;
  }
}

/// Random bodies and laws of straight pieces that soften, drop and jump up: never more than the
/// least of all combinations, and proved to be the least.
TEST(LeastEnergy, IsTheLeastOfAllCombinations) {
  std::mt19937 random(29);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  int proved = 0, better = 0;
  const int scenes = 300;
  for (int scene = 0; scene < scenes; ++scene) {
    const int n = 1 + scene % 4;
    const double unit = std::pow(10.0, 6.0 * any(random) - 3.0),
                 stress = std::pow(10.0, 6.0 * any(random) - 3.0);
    Bench setup;
    setup.s = random_spd(n, std::pow(10.0, 2.0 * any(random)), random) * (stress / unit);
    setup.r = Vector(n);
    for (double& v : setup.r) v = stress * (3.0 * any(random) - 0.5);
    std::vector<BruteLaw> laws(n);
    std::vector<double> weights(n);
    for (int p = 0; p < n; ++p) {
      BruteLaw& law = laws[p];
      weights[p] = 0.2 + any(random);
      double x = unit * (any(random) - 0.3), v = 0.0;
      law.breaks = {x}, law.v = {0.0}, law.s = {any(random) < 0.5 ? 0.0 : stress / unit};
      const int pieces = 1 + static_cast<int>(3.0 * any(random));
      for (int i = 0; i < pieces; ++i) {
        const double length = unit * (0.05 + any(random)), kind = any(random);
        const double s = stress / length * (kind < 0.4 ? any(random) : -1.5 * any(random));
        law.v.push_back(v), law.s.push_back(s);
        x += length, v += s * length;
        law.breaks.push_back(x);
        if (any(random) < 0.4) v += stress * (1.5 * any(random) - 1.0);
      }
      law.v.push_back(v), law.s.push_back(0.0);
      Expr slope = Expr(law.v.back());
      for (int i = static_cast<int>(law.breaks.size()) - 1; i >= 0; --i)
        slope =
            select(less(arg(), Expr(law.breaks[i])),
                   Expr(law.v[i]) + Expr(law.s[i]) * (arg() - Expr(law.breaks[std::max(i - 1, 0)])),
                   slope);
      setup.point(setup.slope(slope), weights[p], {{{p, 1.0}}});
    }
    setup.finish();
    const auto op = dense_operator(setup.s, true);
    InequalityOptions options;
    options.branch = Branch::least_energy;
    InequalitySolver solver(setup.problem, *op, options);
    InequalityState state;
    const auto report = go_on(solver, setup, 1.0, state);
    ASSERT_TRUE(report.converged) << scene << report.verdict;
    const auto energy = [&](const Vector& z) {
      double sum = 0.5 * z.dot(setup.s * z) - setup.r.dot(z);
      for (int p = 0; p < n; ++p) sum += weights[p] * laws[p].energy(z[p]);
      return sum;
    };
    const double size = 0.5 * state.c.dot(setup.s * state.c) + std::abs(setup.r.dot(state.c));
    const double least = brute_least(setup, laws, weights, setup.r);
    EXPECT_LT(energy(state.c) - least, 1e-9 * size) << scene;
    ASSERT_GE(report.least_gap, 0.0) << scene;
    proved += report.least_gap <= 1e-9;
    InequalitySolver continuing(setup.problem, *op, {});
    InequalityState other;
    if (go_on(continuing, setup, 1.0, other).converged)
      better += energy(other.c) > energy(state.c) + 1e-6 * size;
  }
  EXPECT_GE(proved, scenes * 99 / 100);
  EXPECT_GT(better, scenes / 20);
}

/// A visit goes both ways from the last state and counts the steps of both: three kinks lie each
/// way.
TEST(Follow, AVisitCountsTheStepsOfBothWays) {
  Expr slope = 2.0 * arg();
  for (const double kink : {-3.0, -2.0, -1.0, 1.0, 2.0, 3.0})
    slope = slope + 0.25 * abs(arg() - Expr(kink));
  Bench setup = one_spring(slope);
  const PreparedLaw law(*setup.owned[0], setup.problem.graphs[0]);
  const CurveGraph graph(law);
  const EquilibriumCurve curve(DenseMatrix::Constant(1, 1, 1.0), {{&graph, 1.0}});
  const auto steps = [&](double z, double load) {
    const Vector at = Vector::Constant(1, z);
    int solutions = 0;
    const Vector xi = Vector::Constant(
        1, setup.owned[0]->slope(setup.problem.graphs[0], piece_of(setup.problem.graphs[0], z), z));
    const int out =
        curve.visit(at, xi, Vector::Constant(1, load), [&](const CurveState&) { ++solutions; });
    EXPECT_EQ(solutions, 1);
    return out;
  };
  EXPECT_GE(steps(0.0, 50.0), 6);
  EXPECT_GE(steps(0.0, -50.0), 6);
}

/// Points that leave their corners together, onto pieces that fall, may take turns without a step
/// between them: six on a chain of springs do so for ever. The visit ends all the same.
TEST(Follow, AVisitEndsWherePointsTakeTurns) {
  const Expr up = Expr(0.122) + Expr(0.163) * exp(Expr(-30.0) * arg()),
             down = Expr(-0.122) - Expr(0.163) * exp(Expr(30.0) * arg());
  Bench setup = one_spring(select(less(arg(), Expr(0.0)), down, up));
  const PreparedLaw law(*setup.owned[0], setup.problem.graphs[0]);
  const CurveGraph graph(law);
  for (int n = 4; n <= 8; ++n) {
    DenseMatrix stiffness = 3.0 * DenseMatrix::Identity(n, n);
    for (int p = 0; p + 1 < n; ++p) stiffness(p, p + 1) = stiffness(p + 1, p) = -1.0;
    const DenseMatrix compliance = stiffness.inverse();
    const std::vector<CurvePoint> points(static_cast<std::size_t>(n), {&graph, 1.0});
    const EquilibriumCurve curve(compliance, points);
    const Vector load = compliance * Vector::Constant(n, 0.135);
    int solutions = 0;
    const int steps = curve.visit(Vector::Zero(n), Vector::Zero(n), load,
                                  [&](const CurveState&) { ++solutions; });
    EXPECT_GE(solutions, 1) << n; // of the points at rest
    EXPECT_LE(steps, 2 * (most_curve_steps(n) + 80)) << n;
  }
}

} // namespace
} // namespace hvi::solver::test
