// Parts of the solver by themselves: the line search, the corrected factor, Newton's method with
// and without conjugate gradients around the factor.
#include "problems.hpp"
#include "solver/inequality/active_set.hpp"
#include "solver/inequality/certificate.hpp"
#include "solver/inequality/conjugate_gradients.hpp"
#include "solver/inequality/line_search.hpp"
#include "solver/inequality/straight_pieces.hpp"

#include <gtest/gtest.h>

namespace hvi::solver::test {
namespace {

TEST(Parts, LineSearchReducesTheSlopeToAThird) {
  for (const double zero : {1e-6, 0.01, 0.3, 0.9, 1.0, 5.0})
    for (const double power : {1.0, 3.0, 9.0}) {
      const auto slope = [&](double t) {
        return std::copysign(std::pow(std::abs(t - zero), power), t - zero);
      };
      const double t = line_search(slope);
      EXPECT_GT(t, 0.0);
      EXPECT_LE(t, 1.0);
      EXPECT_TRUE(t == 1.0 || std::abs(slope(t)) <= 0.3 * std::abs(slope(0.0))) << zero << power;
      if (zero >= 1.0) {
        EXPECT_EQ(t, 1.0);
      }
    }
  EXPECT_EQ(line_search([](double) { return 1.0; }), 1.0); // does not descend
}

/// Springs with a point on each unknown: the law may be anything, its stiffness is set by hand.
Bench springs(int n, double stiffness = 1.0) {
  Bench setup;
  setup.s = 20.0 * stiffness * chain(n, 0.3);
  const int law = setup.slope(Expr(0.4) + Expr(0.1) * exp(Expr(-2.0) * arg()), true);
  for (int i = 0; i < n; ++i) setup.point(law, 0.1, {{{i, 1.0}}});
  setup.finish();
  return setup;
}

/// Where all points that moved are far, the preconditioner is S + H itself: random ones come free,
/// get stiff or get held, on bodies of any stiffness.
TEST(Parts, ThePreconditionerSolvesExactlyForFarPoints) {
  std::mt19937 random(8);
  const auto one_of = [&](unsigned n) { return random() % n == 0; };
  constexpr int n = 30;
  for (int scene = 0; scene < 200; ++scene) {
    SCOPED_TRACE(scene);
    const Bench setup = springs(n, std::pow(10.0, static_cast<double>(scene % 9) - 4.0));
    const auto op = dense_operator(setup.s, true);
    const ContactPoints points(setup.problem, *op);
    const StiffnessPattern pattern(points);
    LastFactor factor(points, pattern, *op);
    Preconditioner preconditioner(points, factor);
    const bool frees = one_of(2), holds = one_of(2);
    const double soft = 0.025 / points[0].local, stiff = 5e4 * soft;
    InequalityReport report;
    PointMatrices before = points.no_matrices(), after = before;
    std::size_t freed = 0, changed = 0;
    for (int p = 0; p < n; ++p) {
      const bool was_held = frees && one_of(4);
      const bool held = !was_held && holds && one_of(6), stiffened = !held && one_of(6);
      before[p] = was_held ? points[p].penalty : soft;
      after[p] = held ? points[p].penalty : stiffened ? (1 + p) * stiff : soft;
      freed += was_held ? 1 : 0;
      changed += !was_held && (held || stiffened) ? 1 : 0;
    }
    ASSERT_TRUE(factor.make(before, report));
    EXPECT_EQ(report.factorisations, 1);
    FarPoints far;
    ASSERT_TRUE(find_far_points(points, after, before, n, far));
    EXPECT_EQ(far.freed.size(), freed);
    EXPECT_EQ(far.changed.size(), changed);
    SparseMatrix h = pattern.zero();
    pattern.assemble(after, h);
    preconditioner.keep_up();
    ASSERT_TRUE(preconditioner.prepare(far, h));
    Vector r(n), x;
    for (int i = 0; i < n; ++i) r[i] = std::sin(1.0 + i);
    preconditioner.apply(r, x);
    const Vector exact = (setup.s + DenseMatrix(h)).fullPivLu().solve(r);
    EXPECT_LE((x - exact).lpNorm<Eigen::Infinity>(), 1e-5 * exact.lpNorm<Eigen::Infinity>());
    EXPECT_EQ(preconditioner.columns().size(), far.unknowns());
    ASSERT_TRUE(factor.make(after, report)); // what is known belongs to the factor before
    EXPECT_EQ(preconditioner.served(), 0);
    EXPECT_TRUE(preconditioner.columns().empty());
  }
}

/// A gradient in a cell with one free node is that node's value times a direction: along an axis
/// two of its three rows are rounding. Whichever way the axes stand, the point feels the same body.
TEST(Parts, ScalesOfPointsDoNotTurnWithTheAxes) {
  const auto penalty = [](const Point& gradient) {
    Bench setup;
    setup.s = DenseMatrix::Constant(1, 1, 20.0);
    setup.point(setup.slope(arg(), true), 0.1,
                {{{0, gradient[0]}}, {{0, gradient[1]}}, {{0, gradient[2]}}});
    setup.finish();
    const auto op = dense_operator(setup.s, true);
    return ContactPoints(setup.problem, *op)[0].penalty;
  };
  const double along_x = penalty({2.0, 3e-17, -1e-16});
  for (const double angle : {1e-12, 1e-3, 0.4, 1.3}) { // a scale: but for the number of rows
    const double turned = penalty({2.0 * std::cos(angle), 2.0 * std::sin(angle), 1e-17});
    EXPECT_GE(turned, 0.999 * along_x);
    EXPECT_LE(turned, 3.0 * along_x);
  }
}

/// A piece that is refused leaves the one that was taken.
TEST(Parts, ARefusedPieceChangesNothing) {
  Bench setup;
  setup.s = 20.0 * chain(1, 0.3);
  const Expr r = arg();
  const int law = setup.slope(select(less(r, 1.0), r, Expr(1.0) + Expr(1e9) * (r - Expr(1.0))));
  setup.point(law, 0.1, {{{0, 1.0}}});
  setup.finish();
  const auto op = dense_operator(setup.s, true);
  const ContactPoints points(setup.problem, *op);
  ASSERT_TRUE(StraightPieces::possible(points));
  StraightPieces pieces(points);
  pieces.resize(1);
  ASSERT_TRUE(pieces.take(0, 0));
  EXPECT_FALSE(pieces.take(0, 2));
  EXPECT_EQ(pieces.states()[0], 0);
  EXPECT_EQ(pieces[0].k, 1.0);
  EXPECT_EQ(pieces.next_state(0, 0.5), StraightPieces::stays);
}

/// Conjugate gradients around the factor can be left out: more factors, the same solutions.
TEST(Parts, NewtonWithAndWithoutConjugateGradients) {
  constexpr int n = 120, steps = 20;
  const Bench setup = springs(n);
  const InequalityOptions options;
  const auto march = [&](bool with_iterations, int& factorisations) {
    const auto op = dense_operator(setup.s, true);
    const ContactPoints points(setup.problem, *op);
    const StiffnessPattern pattern(points);
    Position at(points, *op, 1e-2 * options.tolerance);
    LastFactor factor(points, pattern, *op);
    ConjugateGradients iterations(points, pattern, factor);
    ActiveSetNewton newton(with_iterations ? static_cast<TangentSolver&>(iterations) : factor,
                           options);
    InequalityReport report;
    at.load({});
    std::vector<Vector> path;
    for (int k = 1; k <= steps; ++k) {
      Vector r(n);
      for (int i = 0; i < n; ++i) r[i] = 0.1 * std::sin(0.3 * k) * std::exp(-2.0 * i / n);
      at.balance.set_load(r);
      EXPECT_EQ(newton.solve(at, options.max_iterations, report), MethodOutcome::solved) << k;
      certify(at, options.tolerance, report);
      EXPECT_TRUE(report.converged) << k;
      path.push_back(at.c);
    }
    factorisations = report.factorisations;
    return path;
  };
  int with = 0, without = 0;
  const auto path = march(true, with), exact = march(false, without);
  EXPECT_LT(with, without);
  for (int k = 0; k < steps; ++k)
    EXPECT_LE((path[k] - exact[k]).lpNorm<Eigen::Infinity>(),
              1e-9 * (1e-3 + exact[k].lpNorm<Eigen::Infinity>()));
}

} // namespace
} // namespace hvi::solver::test
