// Randomised reduced inequalities with fixed seeds: against the slow reference, cold against warm,
// Newton against the fallback, dense against sparse, and certificates recomputed from scratch.
#include "problems.hpp"
#include "reference.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace hvi::solver::test {
namespace {

enum class Points { own_unknown, shared, vector, many_rows };

struct Random {
  Bench bench;
  std::vector<const KnownLaw*> known;
};

const std::vector<KnownLaw>& all_laws() {
  static const std::vector<KnownLaw> laws = known_laws();
  return laws;
}

/// A random problem with n unknowns and laws whose m is finite; its step margin is `ratio`.
Random make(unsigned seed, int n, Points kind, double ratio, double condition = 100.0) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::normal_distribution<double> normal;
  Random out;
  out.bench.s = random_spd(n, condition, random);
  const bool of_vectors = kind == Points::vector || kind == Points::many_rows;
  for (const KnownLaw& law : all_laws()) {
    if (!std::isfinite(law.m) || (of_vectors && !law.spec.radial)) continue;
    out.bench.law(law.spec);
    out.known.push_back(&law);
  }
  const auto pick = [&](int count) {
    return static_cast<int>(random() % static_cast<unsigned>(count));
  };
  const int count = of_vectors ? n / 2 : (kind == Points::shared ? 2 * n : n);
  for (int p = 0; p < count; ++p) {
    const int law = pick(static_cast<int>(out.known.size()));
    const double weight = std::pow(10.0, uniform(random)) * 0.3, offset = 0.3 * uniform(random);
    if (kind == Points::own_unknown) {
      out.bench.point(law, weight, {{{p, 1.0 + 0.5 * uniform(random)}}}, {offset});
    } else if (kind == Points::shared) {
      out.bench.point(law, weight, {{{pick(n), normal(random)}, {pick(n), normal(random)}}},
                      {offset});
    } else if (kind == Points::many_rows) { // as those of a strain or a gradient
      std::vector<std::vector<std::pair<int, double>>> rows(
          static_cast<std::size_t>(4 + pick(slot::most_arguments - 3)));
      std::vector<double> offsets;
      for (auto& row : rows) {
        row = {{pick(n), normal(random)}, {pick(n), normal(random)}};
        offsets.push_back(0.3 * uniform(random));
      }
      out.bench.point(law, weight, rows, offsets);
    } else {
      const double a = 3.0 * uniform(random);
      out.bench.point(law, weight,
                      {{{2 * p, std::cos(a)}, {2 * p + 1, std::sin(a)}},
                       {{2 * p, -std::sin(a)}, {2 * p + 1, std::cos(a)}}});
    }
  }
  out.bench.finish();
  if (out.bench.descent().norm() > 0.0) out.bench.set_margin(ratio);
  out.bench.r.resize(n);
  for (int i = 0; i < n; ++i) out.bench.r[i] = 2.0 * normal(random) * out.bench.s.diagonal().mean();
  return out;
}

InequalityReport run(const Random& problem, InequalityState& state,
                     InequalityOptions options = {}) {
  const auto op = dense_operator(problem.bench.s, true);
  InequalitySolver solver(problem.bench.problem, *op, options);
  return solver.solve(problem.bench.r, state);
}

double distance(const Vector& a, const Vector& b) {
  return (a - b).lpNorm<Eigen::Infinity>() / (1e-300 + b.lpNorm<Eigen::Infinity>());
}

class RandomInequality : public testing::TestWithParam<std::tuple<Points, int>> {
protected:
  Random problem =
      make(static_cast<unsigned>(1000 + std::get<1>(GetParam())), 8, std::get<0>(GetParam()), 0.8);
};

TEST_P(RandomInequality, CertificateIsHonest) {
  InequalityState state;
  const auto report = run(problem, state);
  ASSERT_TRUE(report.converged) << report.verdict;
  const Certificate own = recompute(problem.bench, problem.known, state);
  EXPECT_LE(own.residual, 1e-10);
  EXPECT_LE(own.inclusion, 1e-10);
  // Where there are more rows than unknowns, forces at rest may be shared in many ways.
  EXPECT_LE(report.iterations, std::get<0>(GetParam()) == Points::many_rows ? 250 : 60);
}

TEST_P(RandomInequality, AgreesWithTheSlowReference) {
  InequalityState state, slow;
  ASSERT_TRUE(run(problem, state).converged);
  ASSERT_TRUE(
      reference_solve(problem.bench.problem, problem.bench.s, problem.bench.r, 1e-13, slow));
  EXPECT_LE(distance(state.c, slow.c), 1e-8);
}

TEST_P(RandomInequality, FallbackAndWarmStartsGiveTheSameAnswer) {
  InequalityState cold, fallback, warm;
  ASSERT_TRUE(run(problem, cold).converged);
  InequalityOptions options;
  options.force_fallback = true;
  const auto report = run(problem, fallback, options);
  ASSERT_TRUE(report.converged) << report.verdict;
  EXPECT_TRUE(report.used_fallback);
  EXPECT_LE(distance(fallback.c, cold.c), 1e-9);
  // A warm start from another load's solution.
  warm = cold;
  const auto op = dense_operator(problem.bench.s, true);
  InequalitySolver solver(problem.bench.problem, *op, {});
  ASSERT_TRUE(solver.solve(-problem.bench.r, warm).converged);
  ASSERT_TRUE(solver.solve(problem.bench.r, warm).converged);
  EXPECT_LE(distance(warm.c, cold.c), 1e-9);
  // Started at the solution it stays there.
  const auto again = solver.solve(problem.bench.r, warm);
  EXPECT_LE(again.iterations, 2);
  EXPECT_LE(distance(warm.c, cold.c), 1e-9);
}

TEST_P(RandomInequality, DenseAndSparseOperatorsAgree) {
  InequalityState dense, sparse;
  ASSERT_TRUE(run(problem, dense).converged);
  const SparseMatrix s = problem.bench.s.sparseView();
  const auto op = sparse_operator(s, true);
  InequalitySolver solver(problem.bench.problem, *op, {});
  ASSERT_TRUE(solver.solve(problem.bench.r, sparse).converged);
  EXPECT_LE(distance(sparse.c, dense.c), 1e-10);
  const auto lu = dense_operator(problem.bench.s, false);
  InequalitySolver general(problem.bench.problem, *lu, {});
  InequalityState unsymmetric;
  ASSERT_TRUE(general.solve(problem.bench.r, unsymmetric).converged);
  EXPECT_LE(distance(unsymmetric.c, dense.c), 1e-10);
}

INSTANTIATE_TEST_SUITE_P(Kinds, RandomInequality,
                         testing::Combine(testing::Values(Points::own_unknown, Points::shared,
                                                          Points::vector, Points::many_rows),
                                          testing::Range(0, 40)));

/// Towards the loss of uniqueness the iterations stay bounded and the answer stays certified.
TEST(Margin, IterationsStayBoundedTowardsTheLossOfUniqueness) {
  for (const double ratio : {0.9, 0.99, 0.999, 1 - 1e-6})
    for (const Points kind :
         {Points::own_unknown, Points::shared, Points::vector, Points::many_rows})
      for (unsigned seed = 0; seed < 10; ++seed) {
        const Random problem = make(seed, 10, kind, ratio);
        InequalityState state, other;
        const auto report = run(problem, state);
        ASSERT_TRUE(report.converged) << ratio << " " << seed << " " << report.verdict;
        EXPECT_LE(report.iterations, 200) << ratio << " " << seed;
        // From another start: the distance is bounded by the residuals over the margin.
        other.c = Vector::Constant(10, 3.0);
        ASSERT_TRUE(run(problem, other).converged);
        EXPECT_LE(distance(state.c, other.c), 1e-9 / (1 - ratio));
      }
}

TEST(Margin, PastTheLossOfUniquenessAnswersAreStillCertified) {
  int converged = 0;
  for (const double ratio : {1.01, 2.0})
    for (const Points kind :
         {Points::own_unknown, Points::shared, Points::vector, Points::many_rows})
      for (unsigned seed = 0; seed < 20; ++seed) {
        const Random problem = make(seed, 8, kind, ratio);
        InequalityState state;
        const auto report = run(problem, state);
        if (!report.converged) {
          EXPECT_FALSE(report.verdict.empty());
          continue;
        }
        ++converged;
        const Certificate own = recompute(problem.bench, problem.known, state);
        EXPECT_LE(std::max(own.residual, own.inclusion), 1e-10);
      }
  EXPECT_GE(converged, 154); // of 160
}

/// Units do not matter: lengths by a, forces by b.
TEST(Scaling, UnitsFromTinyToHugeGiveTheSameAnswer) {
  const auto solve = [](double a, double b) {
    std::mt19937 random(3);
    Bench bench;
    bench.s = random_spd(6, 50.0, random) * 100.0 * (b / a);
    const Expr r = arg();
    const int normal = bench.slope(
        select(less(r, Expr(0.0)), Expr(0.0),
               select(less(r, Expr(0.02 * a)), Expr(100.0 * (b / a)) * r, Expr(2.0 * b))));
    const int friction = bench.potential(Expr(0.5 * b) * r, true);
    for (int k = 0; k < 3; ++k) {
      bench.point(normal, 0.7, {{{2 * k, 1.0}}});
      bench.point(friction, 0.7, {{{2 * k + 1, 1.0}}});
    }
    bench.finish();
    bench.r = Vector::LinSpaced(6, -1.0, 2.0) * b;
    InequalityState state;
    const auto op = dense_operator(bench.s, true);
    InequalitySolver solver(bench.problem, *op, {});
    const auto report = solver.solve(bench.r, state);
    EXPECT_TRUE(report.converged) << a << " " << b << report.verdict;
    EXPECT_FALSE(report.used_fallback);
    return Vector(state.c / a);
  };
  const Vector expected = solve(1.0, 1.0);
  for (const double a : {1e-100, 1e-10, 1e100})
    for (const double b : {1e-100, 1e30, 1e100}) EXPECT_LE(distance(solve(a, b), expected), 1e-12);
}

TEST(Friction, BoundsOverEightDecadesOnOneBody) {
  const int n = 64;
  Bench bench;
  bench.s = chain(n, 1e-3);
  std::vector<KnownLaw> laws;
  for (int i = 0; i < n; ++i) {
    const double mu = i % 7 == 0 ? 0.0 : std::pow(10.0, -6.0 + 8.0 * i / (n - 1.0));
    laws.push_back(
        {"t", {"t", Origin{}, true, true, Expr(mu)}, [mu](double) { return mu; }, {}, {}, 0, 0, 0});
    bench.point(bench.law(laws.back().spec), 0.1, {{{i, 1.0}}});
  }
  bench.finish();
  std::vector<const KnownLaw*> known;
  for (const auto& law : laws) known.push_back(&law);
  const auto op = dense_operator(bench.s, true);
  InequalitySolver solver(bench.problem, *op, {});
  InequalityState state;
  int transitions = 0;
  for (int step = 0; step <= 1200;
       ++step) { // loading, unloading: thousands of stick/slip transitions
    const double load = std::sin(step * 2 * M_PI / 100);
    bench.r = Vector::Constant(n, load) + Vector::LinSpaced(n, -load, 2 * load);
    const auto before = state.state;
    const auto report = solver.solve(bench.r, state);
    ASSERT_TRUE(report.converged) << step << report.verdict;
    EXPECT_LE(report.iterations, 40) << step;
    const Certificate own = recompute(bench, known, state);
    EXPECT_LE(std::max(own.residual, own.inclusion), 1e-10) << step;
    for (std::size_t p = 0; p < before.size(); ++p) transitions += before[p] != state.state[p];
  }
  EXPECT_GE(transitions, 1000);
}

/// Compliance from soft to nearly rigid (Signorini's limit): the penetration is force / compliance.
TEST(Stiffness, CompliancesOverEighteenDecades) {
  for (double stiffness = 1e-6; stiffness <= 1e12; stiffness *= 10) {
    Bench bench;
    bench.s = chain(20, 0.01);
    const int law = bench.slope(Expr(stiffness) * max(arg(), Expr(0.0)));
    for (int i = 0; i < 20; ++i) bench.point(law, 0.05, {{{i, 1.0}}});
    bench.finish();
    bench.r = Vector::LinSpaced(20, -1.0, 2.0);
    InequalityState state, slow;
    const auto op = dense_operator(bench.s, true);
    InequalitySolver solver(bench.problem, *op, {});
    const auto report = solver.solve(bench.r, state);
    EXPECT_TRUE(report.converged) << stiffness << report.verdict;
    EXPECT_FALSE(report.used_fallback);
    EXPECT_LE(report.iterations, 20);
    ASSERT_TRUE(reference_solve(bench.problem, bench.s, bench.r, 1e-13, slow));
    EXPECT_LE(distance(state.c, slow.c), 1e-8) << stiffness;
  }
}

} // namespace
} // namespace hvi::solver::test
