// The error indicator against known recoveries, adapted meshes, and what runs share.
#include "solver/discrete/shared_work.hpp"
#include "solver/fem/pointwise.hpp"
#include "solver/mesh/bisect.hpp"
#include "solver/time/adapt.hpp"
#include "tests/solver/time/plans.hpp"

#include <cmath>
#include <numeric>

namespace hvi::solver {
namespace {

using namespace testing_plans;

Plan square(int n, int order, bool vector) {
  Plan plan;
  plan.problem.mesh.kind = MeshSpec::Kind::rectangle;
  plan.problem.mesh.cells = {n, n, 1};
  plan.problem.parts = {all_cells("body"), group("bottom", "bottom"), group("left", "left")};
  plan.problem.space.order = order;
  plan.problem.space.vector = vector;
  plan.problem.forms = {vector ? elastic(2, 0, field_of_u(0), {1, 1})
                               : diffusion(2, 0, field_of_u(0))};
  return plan;
}

double total(const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); }

/// Analytic: the recovery of a function of the space whose gradient is continuous is its gradient.
TEST(RecoveryIndicator, IsZeroForASmoothFunctionOfTheSpace) {
  for (const int order : {1, 2}) {
    const Plan plan = square(4, order, true);
    Discretisation d;
    ASSERT_TRUE(discretise(plan, d).empty());
    const Expr x = var(slot::x(0)), y = var(slot::x(1));
    const std::vector<Expr> u = order == 1 ? std::vector<Expr>{x + y, x - y * Expr(2.0)}
                                           : std::vector<Expr>{x * x + y * x, y * y - x * y};
    EXPECT_LT(total(recovery_indicator(d.space, interpolate(d.space, u, 0.0, {})).cells), 1e-26);
  }
}

/// Analytic: far from the axis a body of revolution is the plane one times its circumference; at
/// the axis the recovery of (c r, d z) is its strain.
TEST(RecoveryIndicator, CarriesTheWeightOfABodyOfRevolution) {
  const Expr x = var(slot::x(0)), y = var(slot::x(1));
  const double away = 1e6;
  const std::vector<Expr> u = {x * x * y - Expr(away * away) * y, x * y * y};
  Plan plan = square(4, 1, true);
  plan.problem.mesh.low = {away, 0, 0};
  plan.problem.mesh.high = {away + 1, 1, 1};
  Discretisation plane, ring;
  ASSERT_TRUE(discretise(plan, plane).empty());
  plan.problem.mesh.axisymmetric = true;
  ASSERT_TRUE(discretise(plan, ring).empty());
  const auto flat = recovery_indicator(plane.space, interpolate(plane.space, u, 0.0, {})).cells;
  const auto round = recovery_indicator(ring.space, interpolate(ring.space, u, 0.0, {})).cells;
  ASSERT_EQ(flat.size(), round.size());
  const double turn = 2 * 3.14159265358979323846 * away;
  for (std::size_t c = 0; c < flat.size(); ++c) EXPECT_NEAR(round[c] / (turn * flat[c]), 1, 1e-4);

  plan.problem.mesh.low = {0, 0, 0};
  plan.problem.mesh.high = {1, 1, 1};
  Discretisation axis;
  ASSERT_TRUE(discretise(plan, axis).empty());
  const std::vector<Expr> uniform = {Expr(2.0) * x, Expr(-3.0) * y};
  EXPECT_LT(total(recovery_indicator(axis.space, interpolate(axis.space, uniform, 0.0, {})).cells),
            1e-26);
}

/// Independent: |grad(u - I u)| of a quadratic by the gauge's own integral. Inside the square the
/// recovery of P1 is superconvergent, so indicator and error agree to a few per cent.
TEST(RecoveryIndicator, IsTheErrorOfASmoothSolution) {
  const Plan plan = square(32, 1, false);
  Discretisation d;
  ASSERT_TRUE(discretise(plan, d).empty());
  const Expr x = var(slot::x(0)), y = var(slot::x(1));
  const std::vector<Expr> exact = {x * x + Expr(0.5) * y * y};
  const Vector u = interpolate(d.space, exact, 0.0, {});
  const auto indicator = recovery_indicator(d.space, u).cells;
  // In a right triangle with legs h: int |grad(u - I u)|^2 = h^4 (a^2 + b^2) / 24, u_xx = a, u_yy =
  // b.
  const double h = 1.0 / 32, cell = h * h * h * h * (2.0 * 2.0 + 1.0) / 24;
  int inside = 0;
  for (std::size_t c = 0; c < indicator.size(); ++c) {
    const auto& nodes = d.mesh.cells[c];
    bool inner = true;
    for (int k = 0; k < 3; ++k)
      for (int a = 0; a < 2; ++a) {
        const double s = d.mesh.nodes[nodes[k]][a];
        inner = inner && s > 0.5 * h && s < 1 - 0.5 * h;
      }
    if (!inner) continue;
    ++inside;
    EXPECT_NEAR(indicator[c] / cell, 1.0, 1e-9);
  }
  EXPECT_GT(inside, 1000);
}

/// Two materials: the kink of u at their interface is no error where the cells are told apart.
TEST(RecoveryIndicator, SeesNoErrorInAKinkBetweenMaterials) {
  const Plan plan = square(4, 1, false);
  Discretisation d;
  ASSERT_TRUE(discretise(plan, d).empty());
  Vector u(d.space.n_dofs());
  for (std::size_t n = 0; n < d.space.nodes.size(); ++n)
    u[static_cast<Eigen::Index>(n)] = std::abs(d.space.nodes[n][0] - 0.5);
  std::vector<int> kinds;
  for (const auto& cell : d.mesh.cells) {
    double middle = 0;
    for (int k = 0; k < 3; ++k) middle += d.mesh.nodes[cell[k]][0] / 3;
    kinds.push_back(middle < 0.5 ? 0 : 1);
  }
  EXPECT_LT(total(recovery_indicator(d.space, u, kinds).cells), 1e-28);
  EXPECT_GT(total(recovery_indicator(d.space, u).cells), 1e-2);
}

/// -u'' = f on lines, zero or `value` at the ends.
Plan bar(std::vector<double> lines, int order, const Expr& load, const Expr& value) {
  Plan plan;
  plan.problem.mesh.kind = MeshSpec::Kind::interval;
  plan.problem.mesh.cells = {4, 1, 1};
  plan.problem.mesh.grading[0] = std::move(lines);
  plan.problem.parts = {all_cells("bar"), group("left", "left"), group("right", "right")};
  plan.problem.space.order = order;
  plan.problem.space.vector = false;
  plan.problem.space.dirichlet = {clamp(1, -1, {value}), clamp(2, -1, {value})};
  plan.problem.forms = {diffusion(1, 0, field_of_u(0))};
  plan.problem.loads = {force(0, {load})};
  return plan;
}

/// Analytic: on lines of any lengths the error of x^2 in P1, and of x^3 in P2, cell by cell.
TEST(RecoveryIndicator, IsTheErrorOnIntervalsOfAnyLengths) {
  const std::vector<double> lines = {0, 0.5, 0.501, 0.6, 0.60001, 0.9, 1};
  for (const int order : {1, 2}) {
    const Plan plan = bar(lines, order, 0.0, 0.0);
    Discretisation d;
    ASSERT_TRUE(discretise(plan, d).empty());
    const Expr x = var(slot::x(0));
    const Vector u =
        interpolate(d.space, std::vector<Expr>{order == 1 ? x * x : x * x * x}, 0.0, {});
    const auto indicator = recovery_indicator(d.space, u).cells;
    for (std::size_t c = 1; c + 2 < lines.size(); ++c) { // those with neighbours on both sides
      const double h = lines[c + 1] - lines[c];
      const double error = order == 1 ? h * h * h / 3 : h * h * h * h * h / 20;
      EXPECT_NEAR(indicator[c] / error, 1.0, 1e-5) << order << " " << c;
    }
  }
}

/// A cell that is all of its material has nothing to be compared with: it counts as not resolved.
TEST(RecoveryIndicator, TrustsNoCellThatIsAloneInItsMaterial) {
  for (const int order : {1, 2}) {
    const Plan plan = bar({0, 0.5, 1}, order, 0.0, 0.0);
    Discretisation d;
    ASSERT_TRUE(discretise(plan, d).empty());
    const Expr x = var(slot::x(0));
    const Vector u = interpolate(d.space, std::vector<Expr>{x * x}, 0.0, {});
    const std::vector<int> kinds = {0, 1};
    for (const double own : recovery_indicator(d.space, u, kinds).cells) EXPECT_GT(own, 0.1);
  }
  const Plan plan = square(1, 1, false);
  Discretisation d;
  ASSERT_TRUE(discretise(plan, d).empty());
  const Expr x = var(slot::x(0)), y = var(slot::x(1));
  const Vector u = interpolate(d.space, std::vector<Expr>{x + y}, 0.0, {});
  const std::vector<int> kinds = {0, 1};
  for (const double own : recovery_indicator(d.space, u, kinds).cells) EXPECT_NEAR(own, 1.0, 1e-12);
}

TEST(MarkedCells, AreTheLeastThatHoldTheBulk) {
  const std::vector<double> eta = {1, 5, 2, 4, 3};
  EXPECT_EQ(marked_cells(eta, 0.5), (std::vector<std::int32_t>{1, 3}));
  EXPECT_EQ(marked_cells(eta, 0.61), (std::vector<std::int32_t>{1, 3, 4}));
  EXPECT_EQ(marked_cells(eta, 1.0).size(), 5U);
}

/// -Laplace u = 1 on the square, zero on two sides that meet others without condition: singular
/// where they end.
Plan membrane(int cells) {
  Plan plan = square(4, 1, false);
  plan.problem.mesh.adapted = cells;
  plan.problem.space.dirichlet = {clamp(1)};
  plan.problem.forms = {diffusion(2, 0, field_of_u(0))};
  plan.problem.loads = {force(0, {1.0 + var(slot::x(0)) * 20.0 * var(slot::x(1))})};
  return plan;
}

TEST(AdaptedMesh, HasAlmostAsManyCellsAsAskedForAndIsNested) {
  std::set<Point> coarser;
  for (const int cells : {100, 400, 1600}) {
    const Plan plan = membrane(cells);
    Discretisation d;
    ASSERT_TRUE(discretise(plan, d).empty());
    EXPECT_LE(d.mesh.cells.size(), static_cast<std::size_t>(cells));
    EXPECT_GE(d.mesh.cells.size(), static_cast<std::size_t>(0.9 * cells));
    std::set<Point> nodes(d.mesh.nodes.begin(), d.mesh.nodes.end());
    for (const Point& p : coarser) EXPECT_TRUE(nodes.contains(p));
    coarser = std::move(nodes);
  }
}

/// Analytic: u = exp(-80 x), all in the first of four cells. The best n cells have, of the size of
/// u, the errors 0.75/n (P1) and 0.52/n^2 (P2), uniform ones 23/n and 153/n^2.
TEST(AdaptedMesh, SeesALayerInsideTheFirstOfAFewIntervals) {
  const Expr x = var(slot::x(0)), layer = exp(x * Expr(-80.0));
  for (const int order : {1, 2}) {
    double before = 0.0;
    for (const int cells : {64, 256, 1024}) {
      Plan plan = bar({}, order, Expr(-6400.0) * layer, layer);
      plan.problem.mesh.adapted = cells;
      const Expr off = var(slot::field(field_of_u(0), slot::gradient(0, 0))) + Expr(80.0) * layer;
      plan.report.probes = {integral("error", off * off, 0)};
      plan.report.tables = {{{}, {0}, 1, false, ""}};
      Discretisation d;
      ASSERT_TRUE(discretise(plan, d).empty());
      EXPECT_GE(d.mesh.cells.size(), static_cast<std::size_t>(0.9 * cells));
      const double error = std::sqrt(run(plan, d, {}).final.at("error") / 40.0);
      const double best = order == 1 ? 0.75 / cells : 0.52 / cells / cells;
      EXPECT_LT(error, 2.5 * best) << order << " " << cells;
      if (before > 0.0) {
        EXPECT_NEAR(std::log(before / error) / std::log(4.0), order, 0.15);
      }
      before = error;
    }
  }
}

TEST(AdaptedMesh, StopsWhenAsked) {
  Plan plan = membrane(4000);
  Discretisation d;
  const std::atomic<bool> stop = true;
  try {
    discretise(plan, d, &stop);
    FAIL();
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.kind, FailureKind::interrupted);
  }
}

/// A run that takes matrices, orders and factors from an earlier one has its bits.
TEST(SharedWork, RunsThatTakeOverHaveTheSameBits) {
  Plan plan = square(12, 2, true);
  plan.problem.space.dirichlet = {clamp(1)};
  plan.problem.forms = {elastic(2, 0, field_of_u(1), {1, 2}), elastic(2, 0, field_of_u(0), {5, 7})};
  plan.problem.loads = {force(0, {var(slot::t), Expr(-1.0)})};
  plan.problem.time.is_static = false;
  plan.problem.time.grid = uniform_grid(1.0, 8);
  Discretisation own, common;
  ASSERT_TRUE(discretise(plan, own).empty());
  ASSERT_TRUE(discretise(plan, common).empty());
  common.shared = std::make_shared<SharedWork>();
  for (const int steps : {8, 16, 16, 5}) {
    plan.problem.time.grid = uniform_grid(1.0, steps);
    const auto alone = run(plan, own, {}), shared = run(plan, common, {});
    ASSERT_EQ(alone.u.size(), shared.u.size());
    for (Eigen::Index i = 0; i < alone.u.size(); ++i) ASSERT_EQ(alone.u[i], shared.u[i]);
    EXPECT_EQ(alone.work.triangular_solves, shared.work.triangular_solves);
  }
  const auto spared = common.shared->spared();
  EXPECT_EQ(spared.matrices, 3 * 2);
  EXPECT_EQ(spared.factors, 1); // the second run with 16 steps
  EXPECT_EQ(spared.orders, 2);  // 16 and 5 steps: other matrices of the same pattern
}

} // namespace
} // namespace hvi::solver
