// Gauges against errors known in closed form.
#include "solver/study/reference.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace hvi::solver {
namespace {

/// The unit square with n x n cells and a P1 or P2 vector space.
std::shared_ptr<Discretisation> square(int n, int order) {
  Plan plan;
  plan.problem.mesh.kind = MeshSpec::Kind::rectangle;
  plan.problem.mesh.low = {0, 0, 0}, plan.problem.mesh.high = {1, 1, 0};
  plan.problem.mesh.cells = {n, n, 1};
  plan.problem.parts.push_back({"body", {}, RegionSpec{}});
  plan.problem.space.order = order;
  auto out = std::make_shared<Discretisation>();
  EXPECT_TRUE(discretise(plan, *out).empty());
  return out;
}

Expr x(int i) { return Expr::variable(slot::x(i)); }
Expr t() { return Expr::variable(slot::t); }

/// Analytic: u = 0 against (t x^2, t x y): eps = t [2x, y/2; y/2, x], so |eps|^2 integrates to
/// t^2 (4/3 + 1/6 + 1/3) and |u|^2 to t^2 (1/5 + 1/9).
TEST(Gauge, ZeroAgainstAQuadraticField) {
  const auto d = square(4, 1);
  const std::vector<Expr> exact = {t() * x(0) * x(0), t() * x(0) * x(1)};
  const auto gauge = exact_gauge(*d, exact);
  const Vector zero = Vector::Zero(d->space.n_dofs());
  gauge->step(2.0, zero);
  gauge->step(1.0, zero);
  const double v = std::sqrt(4.0 / 3 + 1.0 / 6 + 1.0 / 3), l2 = std::sqrt(1.0 / 5 + 1.0 / 9);
  EXPECT_NEAR(gauge->error().v_max, 2 * v, 1e-12);
  EXPECT_NEAR(gauge->error().v_final, v, 1e-12);
  EXPECT_NEAR(gauge->error().l2_max, 2 * l2, 1e-12);
  EXPECT_NEAR(gauge->error().size, 2 * v, 1e-12);
}

/// A function of the coarse space is itself on a nested finer mesh; its difference to another is
/// the same by both gauges.
TEST(Gauge, AFinerRunAndAnExactSolutionAgree) {
  for (const int order : {1, 2}) {
    const auto coarse = square(3, order), fine = square(6, order);
    const std::vector<Expr> linear = {x(0) + Expr(2.0) * x(1), Expr(3.0) * x(0)};
    const std::vector<Expr> other = {x(1), x(0) - x(1)};
    auto reference = std::make_shared<Trajectory>();
    reference->discretisation = fine;
    reference->times = {0.0, 1.0};
    const Vector end = interpolate(fine->space, linear, 0.0, {});
    reference->states = {Vector::Zero(end.size()), end};
    const auto by_run = trajectory_gauge(reference, *coarse);
    const Vector u = interpolate(coarse->space, other, 0.0, {});
    by_run->step(0.5, u); // half way: half of `linear`
    const std::vector<Expr> half = {Expr(0.5) * linear[0], Expr(0.5) * linear[1]};
    const auto by_formula = exact_gauge(*coarse, half);
    by_formula->step(0.5, u);
    EXPECT_NEAR(by_run->error().v_max, by_formula->error().v_max, 1e-12);
    EXPECT_NEAR(by_run->error().l2_max, by_formula->error().l2_max, 1e-12);
    EXPECT_NEAR(by_run->error().size, by_formula->error().size, 1e-12);
  }
}

/// Meshes that are not nested: both functions are seen as they are, not interpolated. Analytic: the
/// P1 interpolant of (x^2, 0) on n x n squares has |eps(u - I u)|^2 = h^2 / 3 in eps_xx, and
/// nothing in eps_xy, where the reference is the P2 function x^2 itself.
TEST(Gauge, AReferenceThatIsNotNestedSeesTheWholeError) {
  const auto fine = square(7, 2), coarse = square(16, 1);
  EXPECT_FALSE(is_nested(coarse->mesh, fine->mesh));
  EXPECT_TRUE(is_nested(square(8, 1)->mesh, coarse->mesh));
  const std::vector<Expr> exact = {x(0) * x(0), Expr(0.0)};
  auto reference = std::make_shared<Trajectory>();
  reference->discretisation = fine;
  reference->times = {0.0};
  reference->states = {interpolate(fine->space, exact, 0.0, {})};
  const auto gauge = trajectory_gauge(reference, *coarse);
  gauge->step(0.0, interpolate(coarse->space, exact, 0.0, {}));
  // int (2x - (x_i + x_{i+1}))^2 over a cell [x_i, x_{i+1}] is h^3 / 3, over both triangles alike.
  const double h = 1.0 / 16;
  EXPECT_NEAR(gauge->error().v_max, h / std::sqrt(3.0), 0.03 * h);
  EXPECT_NEAR(gauge->error().size, 2.0 / std::sqrt(3.0), 1e-12);
}

} // namespace
} // namespace hvi::solver
