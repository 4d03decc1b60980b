// Laws on unknowns that have no stiffness of their own, such as the pressure of an incompressible
// fluid: with all unknowns kept, against the same problem after the others are eliminated.
#include "problems.hpp"
#include "solver/inequality/stiffness.hpp"
#include "solver/linear/own_stiffness.hpp"

#include <gtest/gtest.h>

namespace hvi::solver::test {
namespace {

constexpr int of_u = 12, of_p = 6;

/// K = [A, B; -B^T, 0] with A of size 1 and B of size `unit`, and what couples p to u.
struct Saddle {
  DenseMatrix k = DenseMatrix::Zero(of_u + of_p, of_u + of_p), schur;
  Vector r, reduced;

  Saddle(std::mt19937& random, double unit) {
    std::normal_distribution<double> normal;
    const DenseMatrix a = random_spd(of_u, 50.0, random);
    DenseMatrix b(of_u, of_p);
    for (double& entry : b.reshaped()) entry = unit * normal(random);
    k.topLeftCorner(of_u, of_u) = a;
    k.topRightCorner(of_u, of_p) = b;
    k.bottomLeftCorner(of_p, of_u) = -b.transpose();
    schur = b.transpose() * a.inverse() * b;
    r.resize(of_u + of_p);
    for (int i = 0; i < r.size(); ++i) r[i] = normal(random) * (i < of_u ? 1.0 : unit);
    reduced = r.tail(of_p) + b.transpose() * a.inverse() * r.head(of_u);
  }
};

/// Differences of p stick, are pushed by at most so much, or stretch a spring.
void add_laws(Bench& bench, int first, const DenseMatrix& schur, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0.1, 1.0);
  const double stiffness = schur.diagonal().mean(), size = 1.0 / std::sqrt(stiffness);
  for (int p = 0; p + 1 < of_p; ++p) {
    const double bound = uniform(random) * stiffness * size;
    const int law =
        p % 3 == 2 ? bench.slope(Expr(2.0 * stiffness) * arg())
                   : bench.slope(select(less(arg(), Expr(0.1 * size)), Expr(-bound), Expr(bound)));
    bench.point(law, 0.7, {{{first + p, 1.0}, {first + p + 1, -1.0}}});
  }
  bench.finish();
}

TEST(Saddle, LawsOnUnknownsWithoutStiffness) {
  for (unsigned seed = 0; seed < 40; ++seed)
    for (const double unit : {1e-6, 1e-3, 1.0, 1e3, 1e6}) {
      std::mt19937 random(seed);
      const Saddle problem(random, unit);
      Bench whole, condensed;
      whole.s = problem.k, condensed.s = problem.schur;
      add_laws(whole, of_u, problem.schur, seed);
      add_laws(condensed, 0, problem.schur, seed);
      const SparseMatrix k = whole.s.sparseView();
      const auto sparse = sparse_operator(k, false);
      const auto dense = dense_operator(condensed.s, true);
      InequalitySolver on_all(whole.problem, *sparse, {}), on_p(condensed.problem, *dense, {});
      InequalityState all, p;
      const auto report = on_all.solve(problem.r, all);
      ASSERT_TRUE(report.converged) << seed << " " << unit << ": " << report.verdict;
      EXPECT_FALSE(report.used_fallback) << seed << " " << unit;
      EXPECT_LE(report.iterations, 20) << seed << " " << unit;
      ASSERT_TRUE(on_p.solve(problem.reduced, p).converged) << seed << " " << unit;
      EXPECT_LE((all.c.tail(of_p) - p.c).norm(), 1e-8 * p.c.norm()) << seed << " " << unit;
    }
}

/// How far the body gives way at points of u, where the pressure p is in other units.
std::vector<double> compliances(unsigned seed, double unit) {
  std::mt19937 random(seed);
  Bench bench;
  bench.s = Saddle(random, unit).k;
  const int law = bench.slope(Expr(1.0), true);
  for (int p = 0; p + 1 < of_u; ++p) bench.point(law, 0.7, {{{p, 1.0}}, {{p + 1, 1.0}, {p, 0.5}}});
  bench.finish();
  for (int i = 0; i < of_u + of_p; ++i) bench.problem.of_unknown.push_back(i < of_u ? 0 : 1);
  const SparseMatrix k = bench.s.sparseView();
  const auto op = sparse_operator(k, false);
  ContactPoints points(bench.problem, *op);
  points.estimate_compliance(*op, StiffnessPattern(points).zero());
  std::vector<double> out;
  for (const PointData& q : points.data) out.push_back(q.gamma);
  return out;
}

TEST(Saddle, UnitsOfThePressureDoNotChangeHowFarTheBodyGivesWay) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto plain = compliances(seed, 1.0);
    for (const double unit : {1e-8, 1e-4, 1e4, 1e8}) {
      const auto other = compliances(seed, unit);
      for (std::size_t p = 0; p < plain.size(); ++p)
        EXPECT_NEAR(other[p], plain[p], 1e-6 * plain[p]) << seed << " " << unit;
    }
  }
}

TEST(Saddle, StiffnessThatTheOthersLeave) {
  DenseMatrix k(3, 3);
  k << 4.0, 0.0, -3.0, 0.0, 0.0, 2.0, 3.0, -5.0, 0.5;
  const Vector expected = Vector{{4.0, 2.0 * 5.0 / 0.5, 0.5}};
  EXPECT_EQ(own_stiffness(k.sparseView()), expected);
}

} // namespace
} // namespace hvi::solver::test
