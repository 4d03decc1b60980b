// The terms of the Cea type inequality, each from its formula for a function that is no solution:
// sums by hand over the steps, laws in closed form, the memory by a quadrature of its own.
#include "solver/assembly/assembly.hpp"
#include "solver/mesh/generate.hpp"
#include "solver/study/cea.hpp"
#include "tests/solver/time/plans.hpp"

#include <cmath>

namespace hvi::solver {
namespace {

using namespace testing_plans;

constexpr int cells = 3, steps = 4;
constexpr double tau = 0.5; ///< of slab()'s memory

/// A law for the normal part that jumps where it is touched, and friction of bound 0.7.
Plan plan_of() {
  Plan plan = slab(cells, steps, 2, true);
  plan.problem.laws[0].expression = select(less(var(slot::argument(0)), 0.0), 0.0, 3.0);
  plan.problem.laws[1].expression = Expr(0.7);
  for (double& t : plan.problem.time.grid) t = 0.25 + t * (1 + t) / 2;
  plan.problem.time.initial = {}; // of the functions below, not read here
  return plan;
}

/// Pressed on the right half of the ground, just touching on the left; slides there as well.
std::vector<Expr> exact() {
  const Expr x = var(slot::x(0)), y = var(slot::x(1)), t = var(slot::t);
  const Expr right = select(less(x, 1.0), 0.0, (x - 1.0) * (x - 1.0));
  return {t * t * right + y * sin(t + x), t * y * exp(x) - (1.0 + t) * right};
}

/// The ground's nodes in a P2 space with the weights of Simpson's rule on each facet.
std::vector<std::pair<int, double>> ground_of(const Discretisation& d, double facet) {
  std::vector<std::pair<int, double>> out;
  for (int node = 0; node < static_cast<int>(d.space.nodes.size()); ++node) {
    const auto& x = d.space.nodes[static_cast<std::size_t>(node)];
    if (x[1] != 0.0) continue;
    const bool corner = node < static_cast<int>(d.mesh.nodes.size());
    const bool end = x[0] == 0.0 || x[0] == 2.0;
    out.emplace_back(node, facet * (!corner ? 4.0 / 6 : end ? 1.0 / 6 : 2.0 / 6));
  }
  return out;
}

/// int_{t_0}^{t_n} exp(-(t_n - s)/tau) u(s) ds, u affine on each step: the midpoint rule on many
/// parts of each, whose error is below 1e-9 of it.
Vector memory_of(const std::vector<double>& grid, const std::vector<Vector>& u, std::size_t n) {
  Vector out = Vector::Zero(u[0].size());
  constexpr int parts = 4000;
  for (std::size_t l = 1; l <= n; ++l)
    for (int i = 0; i < parts; ++i) {
      const double part = (i + 0.5) / parts, k = grid[l] - grid[l - 1], s = grid[l - 1] + part * k;
      const double q = std::exp(-(grid[n] - s) / tau) * k / parts;
      out += q * (1 - part) * u[l - 1] + q * part * u[l];
    }
  return out;
}

TEST(Cea, TermsAreThoseOfTheFormula) {
  const Plan plan = plan_of();
  Discretisation coarse;
  for (const auto& mistake : discretise(plan, coarse)) throw mistake;
  const FineSolution solution = fine_exact(plan.problem, coarse.mesh, exact());
  const auto terms = cea_terms(solution, plan.problem, coarse);
  ASSERT_TRUE(terms);

  const Discretisation& d = *solution.discretisation;
  ASSERT_EQ(d.mesh.cells.size(), 4 * coarse.mesh.cells.size());
  const auto a = matrix_of(solution.problem, d, field_of_u(1)),
             b = matrix_of(solution.problem, d, field_of_u(0)),
             e = matrix_of(solution.problem, d, field_of_memory(0));
  const auto strains =
      assemble_form(d.space, d.parts[body], elastic(2, body, field_of_u(0), {0.0, 0.5}));
  const auto square = [&](const Vector& v) { return v.dot(strains * v); };
  LoadAssembler loads(d.space, d.parts, plan.problem.loads);
  const SparseMatrix down = transfer(d.space, coarse.space), up = transfer(coarse.space, d.space);
  const auto ground = ground_of(d, 0.5 / cells);
  const auto& grid = plan.problem.time.grid;
  std::vector<Expr> rates;
  for (const Expr& component : exact()) rates.push_back(derivative(component, slot::t));

  CeaTerms expected;
  std::vector<Vector> u;
  Vector off_before;
  for (std::size_t n = 0; n < grid.size(); ++n) {
    u.push_back(interpolate(d.space, exact(), grid[n], {}));
    const Vector off = up * (down * u[n]) - u[n];
    expected.interpolation = std::max(expected.interpolation, square(off));
    if (n == 0) {
      expected.start = square(off), off_before = off;
      continue;
    }
    const double k = grid[n] - grid[n - 1];
    const Vector rate = interpolate(d.space, rates, grid[n], {});
    Vector f = Vector::Zero(off.size());
    loads.add(grid[n], f);
    double s = off.dot(a * rate + b * u[n] + e * memory_of(grid, u, n) - f), trace = 0;
    for (const auto& [node, weight] : ground) {
      const int across = d.space.dof(node, 0), vertical = d.space.dof(node, 1);
      const double z = -u[n][vertical], dz = -off[vertical];
      s += weight * (z > 0 ? 3 * dz : z < 0 ? 0.0 : std::max(0.0, 3 * dz));
      const double slip = u[n][across], d_slip = off[across];
      s += weight * 0.7 * (slip > 0 ? d_slip : slip < 0 ? -d_slip : std::abs(d_slip));
      trace += weight * (dz * dz + d_slip * d_slip);
    }
    expected.interpolation_rate += square(off - off_before) / k;
    expected.trace += k * std::sqrt(trace);
    expected.residual += k * std::abs(s);
    expected.largest_residual = std::max(expected.largest_residual, std::abs(s));
    expected.rate += k * square((u[n] - u[n - 1]) / k - rate);
    expected.step = std::max(expected.step, k * k);
    off_before = off;
  }
  const auto near = [](double value, double reference, const char* what) {
    EXPECT_GT(reference, 0.0) << what;
    EXPECT_NEAR(value, reference, 1e-7 * reference) << what;
  };
  near(terms->interpolation, expected.interpolation, "interpolation");
  near(terms->interpolation_rate, expected.interpolation_rate, "rate of interpolation");
  near(terms->trace, expected.trace, "trace");
  near(terms->residual, expected.residual, "residual");
  near(terms->largest_residual, expected.largest_residual, "largest residual");
  near(terms->rate, expected.rate, "rate");
  near(terms->start, expected.start, "start");
  near(terms->step, expected.step, "step");
  near(terms->bound(),
       expected.interpolation + expected.interpolation_rate + expected.trace + expected.residual +
           expected.rate + expected.start + expected.step,
       "bound");
}

TEST(Cea, SaysNothingOfStaticPlansAndUnilateralContact) {
  Plan plan = plan_of();
  Discretisation coarse;
  for (const auto& mistake : discretise(plan, coarse)) throw mistake;
  plan.problem.laws[0].expression = select(less(var(slot::argument(0)), 0.0), 0.0, 1e300);
  EXPECT_FALSE(cea_terms(fine_exact(plan.problem, coarse.mesh, exact()), plan.problem, coarse));
  Plan still = plan_of();
  still.problem.time.is_static = true;
  EXPECT_FALSE(
      cea_terms(fine_exact(plan_of().problem, coarse.mesh, exact()), still.problem, coarse));
}

TEST(Cea, SaysNothingOfWhatTheTheoremDoesNotHave) {
  const Plan plan = plan_of();
  Discretisation coarse;
  ASSERT_TRUE(discretise(plan, coarse).empty());
  const auto says = [&](const auto& change) {
    Problem other = plan.problem;
    change(other);
    return cea_terms(fine_exact(plan.problem, coarse.mesh, exact()), other, coarse).has_value();
  };
  EXPECT_TRUE(says([](Problem&) {}));
  EXPECT_FALSE(says([](Problem& p) { p.states.emplace_back(); }));
  EXPECT_FALSE(says([](Problem& p) { p.laws[1].coupled = "layer"; }));
  EXPECT_FALSE(says([](Problem& p) { p.laws[0].readings = {Expr(1.0)}; }));
  EXPECT_FALSE(says([](Problem& p) { p.law_terms[0].seen = {{{field_of_u(0), 2.0}}}; }));
  EXPECT_FALSE(says([](Problem& p) { p.law_terms[0].field = field_of_u(1); }));
}

/// Between the times of a finer run the state is affine and its rate the step's difference
/// quotient.
TEST(Cea, ARunGivesItsRates) {
  auto trajectory = std::make_shared<Trajectory>();
  auto d = std::make_shared<Discretisation>();
  for (const auto& mistake : discretise(plan_of(), *d)) throw mistake;
  trajectory->discretisation = d;
  trajectory->times = {0.0, 0.5, 2.0, 2.25};
  for (const double value : {0.0, 1.0, 4.0, 6.0})
    trajectory->states.push_back(Vector::Constant(d->space.n_dofs(), value));
  const auto fine = fine_trajectory(plan_of().problem, trajectory);
  for (const auto& [t, value, rate] : {std::array{0.0, 0.0, 2.0},
                                       {0.25, 0.5, 2.0},
                                       {0.5, 1.0, 2.0},
                                       {0.6, 1.2, 2.0},
                                       {2.0, 4.0, 2.0},
                                       {2.1, 4.8, 8.0},
                                       {2.25, 6.0, 8.0}}) {
    EXPECT_NEAR(fine.u(t)[0], value, 1e-12) << t;
    EXPECT_NEAR(fine.rate(t)[0], rate, 1e-12) << t;
  }
}

} // namespace
} // namespace hvi::solver
