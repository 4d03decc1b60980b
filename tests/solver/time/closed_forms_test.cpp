// Runs whose discrete solution is known in closed form, or computed here another way.
#include "solver/discrete/time_scheme.hpp"
#include "tests/solver/time/plans.hpp"

#include <cmath>

namespace hvi::solver {
namespace {

using namespace testing_plans;

/// A unit square held on the left, pulled by a constant load.
Plan square(int steps) {
  Plan plan;
  plan.problem.mesh.high = {1, 1, 0};
  plan.problem.mesh.cells = {6, 5, 1};
  plan.problem.parts = {all_cells("body"), group("left", "left"), group("right", "right")};
  plan.problem.space.dirichlet = {clamp(1)};
  plan.problem.forms = {elastic(2, 0, field_of_u(0), {3, 2})};
  plan.problem.loads = {force(2, {0.3, -0.2})};
  plan.problem.time.is_static = steps == 0;
  if (steps > 0) plan.problem.time.grid = uniform_grid(1.0, steps);
  plan.report.probes = {at_point("u", u_value(1), {1, 1, 0})};
  plan.report.tables = {{{}, {0}, 1, false, ""}};
  return plan;
}

// Analytic: A = B, f constant: u_n = (1 - (1 + k)^-n) u_static.
TEST(KelvinVoigt, BackwardEulerInClosedForm) {
  const double u_static = solve(square(0)).final.at("u");
  auto plan = square(20);
  plan.problem.forms.push_back(elastic(2, 0, field_of_u(1), {3, 2}));
  const auto result = solve(plan);
  for (int n = 1; n <= 20; ++n)
    expect_relative(result.columns.at("u")[n - 1], (1 - std::pow(1.05, -n)) * u_static, 1e-12,
                    "step " + std::to_string(n));
  EXPECT_EQ(result.work.matrices, 1);
}

// Analytic: int_0^t (t^2 - s^2)^(-1/2) ds = pi/2 for every t, so that a constant load keeps u
// constant, while the weight of the own step (0.39 in the first, 0.11 in the tenth) changes the
// matrix in each.
TEST(Memory, OwnStepWeightsThatVaryMuchFromStepToStep) {
  const double pi = 3.14159265358979323846;
  auto fixed = square(0);
  fixed.problem.forms.push_back(elastic(2, 0, field_of_u(0), {1, 2}, -0.125 * pi));
  const double exact = solve(fixed).final.at("u");
  const Expr t = var(slot::t), s = t - var(slot::lag);
  for (const double grading : {1.0, 3.0, 0.5}) {
    auto plan = square(10);
    plan.problem.forms.push_back(elastic(2, 0, field_of_memory(0), {1, 2}));
    plan.problem.histories = {{{}, {"q", {}, Expr(-0.25) * pow(t * t - s * s, Expr(-0.5))}}};
    for (double& time : plan.problem.time.grid) time = std::pow(time, grading);
    const auto result = solve(plan);
    for (const double u : result.columns.at("u"))
      expect_relative(u, exact, 1e-11, "graded by " + std::to_string(grading));
  }
}

// Analytic: the same recursion with the lengths of a graded grid, a factor per length.
TEST(KelvinVoigt, GradedGrid) {
  const double u_static = solve(square(0)).final.at("u");
  auto plan = square(12);
  plan.problem.forms.push_back(elastic(2, 0, field_of_u(1), {3, 2}));
  for (std::size_t n = 0; n < plan.problem.time.grid.size(); ++n)
    plan.problem.time.grid[n] = std::pow(static_cast<double>(n) / 12, 2);
  const auto result = solve(plan);
  double factor = 1;
  for (int n = 1; n <= 12; ++n) {
    factor /= 1 + plan.problem.time.grid[n] - plan.problem.time.grid[n - 1];
    expect_relative(result.columns.at("u")[n - 1], (1 - factor) * u_static, 1e-12, "graded");
  }
  EXPECT_EQ(result.work.analyses, 1);
  EXPECT_EQ(result.work.factorisations, 12);
}

TEST(KelvinVoigt, ReturningLengthsKeepTheirFactors) {
  auto plan = square(1);
  plan.problem.forms.push_back(elastic(2, 0, field_of_u(1), {3, 2}));
  plan.problem.time.grid = {0};
  for (int n = 0; n < 12; ++n)
    plan.problem.time.grid.push_back(plan.problem.time.grid.back() + (n % 3 == 2 ? 0.25 : 0.125));
  const auto alternating = solve(plan);
  EXPECT_EQ(alternating.work.factorisations, 2);
  EXPECT_EQ(alternating.work.analyses, 1); // of the pattern, which no step size changes
}

// Analytic: A = B, f = t b, the recursion u_n = (u_{n-1} + k g_n u_static) / (1 + k) with g_n the
// mean of t over the step, and g_n = t_n for end-point sampling.
TEST(KelvinVoigt, LoadSampledAsMeanOrAtTheEnd) {
  const double u_static = solve(square(0)).final.at("u");
  for (const auto sampling : {LoadSampling::endpoint, LoadSampling::average}) {
    auto plan = square(10);
    plan.problem.forms.push_back(elastic(2, 0, field_of_u(1), {3, 2}));
    for (auto& entry : plan.problem.loads[0].entries) entry.value = entry.value * var(slot::t);
    plan.problem.time.sampling = sampling;
    double u = 0;
    for (int n = 1; n <= 10; ++n)
      u = (u + 0.1 * (sampling == LoadSampling::average ? 0.1 * n - 0.05 : 0.1 * n) * u_static) /
          1.1;
    expect_relative(solve(plan).final.at("u"), u, 1e-11, "sampling");
  }
}

// Analytic: u(t) = (1 - exp(-t)) u_static; BDF2 is of second order in u, backward Euler of first.
TEST(Bdf2, SecondOrderOnUniformAndGradedGrids) {
  const double exact = (1 - std::exp(-1.0)) * solve(square(0)).final.at("u");
  for (const bool graded : {false, true}) {
    std::vector<double> errors;
    for (const int steps : {80, 160, 320}) {
      auto plan = square(steps);
      plan.problem.forms.push_back(elastic(2, 0, field_of_u(1), {3, 2}));
      plan.problem.time.scheme = Scheme::bdf2;
      if (graded)
        for (auto& t : plan.problem.time.grid) t = 0.5 * t + 0.5 * t * t;
      errors.push_back(std::abs(solve(plan).final.at("u") - exact));
    }
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(std::log2(errors[i] / errors[i + 1]), 2.0, 0.1);
  }
}

// Analytic: creep of the standard linear solid with kernel -c exp(-s/tau) under the load t b:
// u(t) = u_static (t + b (t - (1 - exp(-a t)) / a)), a = (1 - c tau) / tau, b = c tau / (1 - c
// tau). (A load that is not zero at once would make u jump at t = 0, away from the affine
// interpolant.)
double standard_linear_solid_error(int steps, Scheme scheme) {
  const double tau = 0.5, c = 0.8;
  auto plan = square(steps);
  plan.problem.forms.push_back(elastic(2, 0, field_of_memory(0), {3, 2}, -c));
  plan.problem.histories = {{{}, exponential_kernel(tau)}};
  for (auto& entry : plan.problem.loads[0].entries) entry.value = entry.value * var(slot::t);
  plan.problem.time.scheme = scheme;
  const double a = (1 - c * tau) / tau, b = c * tau / (1 - c * tau);
  const double exact = solve(square(0)).final.at("u") * (1 + b * (1 - (1 - std::exp(-a)) / a));
  return std::abs(solve(plan).final.at("u") - exact) / std::abs(exact);
}

TEST(StandardLinearSolid, ConvergesWithTheOrderOfItsScheme) {
  const double e1 = standard_linear_solid_error(40, Scheme::backward_euler);
  const double e2 = standard_linear_solid_error(80, Scheme::backward_euler);
  EXPECT_NEAR(std::log2(e1 / e2), 1.0, 0.1);
  const double q1 = standard_linear_solid_error(20, Scheme::bdf2);
  const double q2 = standard_linear_solid_error(40, Scheme::bdf2);
  EXPECT_NEAR(std::log2(q1 / q2), 2.0, 0.1);
}

// Analytic: the standard linear solid in strain control, relaxation of the stress under a constant
// imposed stretch: sigma(t_n) = (E0 + E1 exp(-t_n / tau)) c eps, exactly (u is constant).
TEST(StandardLinearSolid, StressRelaxesExactlyUnderImposedStrain) {
  const double e0 = 2, e1 = 3, tau = 0.4, stretch = 0.01;
  Plan plan;
  plan.problem.mesh.high = {1, 1, 0};
  plan.problem.mesh.cells = {3, 3, 1};
  plan.problem.parts = {all_cells("body"), group("left", "left"), group("right", "right"),
                        group("bottom", "bottom"), group("top", "top")};
  plan.problem.space.dirichlet = {clamp(1, 0), clamp(2, 0, {Expr(stretch)}), clamp(3, 1),
                                  clamp(4, 1)};
  plan.problem.forms = {elastic(2, 0, field_of_u(0), {1, 1}, e0 + e1),
                        elastic(2, 0, field_of_memory(0), {1, 1}, -e1 / tau)};
  plan.problem.histories = {{{}, exponential_kernel(tau)}};
  plan.problem.time.is_static = false;
  plan.problem.time.grid = uniform_grid(1.0, 10);
  plan.problem.time.initial = {stretch * var(slot::x(0)), 0.0};
  const auto d = [](int field, int i, int j) {
    return var(slot::field(field, slot::gradient(i, j)));
  };
  const auto tensor = [&](int field) { // sigma_xx of the unit tensor
    return 3.0 * d(field, 0, 0) + d(field, 1, 1);
  };
  plan.report.probes = {
      at_point("s", (e0 + e1) * tensor(field_of_u(0)) - Expr(e1 / tau) * tensor(field_of_memory(0)),
               {0.5, 0.5, 0})};
  plan.report.tables = {{{}, {0}, 1, false, ""}};
  const auto result = solve(plan);
  for (int n = 1; n <= 10; ++n)
    expect_relative(result.columns.at("s")[n - 1],
                    (e0 + e1 * std::exp(-0.1 * n / tau)) * 3 * stretch, 1e-12, "stress");
}

// Independent: a kernel q(t, s) that is no convolution changes the matrix of every step. A scalar
// chain with one unknown solves the same recursion in plain arithmetic.
TEST(NonConvolution, MatchesThePlainRecursion) {
  const auto q = [](double t, double s) { return std::exp(-(t - s)) * (1 + t) / (1 + s); };
  const Expr t = var(slot::t), lag = var(slot::lag);
  Plan plan; // u' ' = f on (0, 1) with two cells: one unknown, stiffness 4
  plan.problem.mesh.kind = MeshSpec::Kind::interval;
  plan.problem.mesh.cells = {2, 1, 1};
  plan.problem.parts = {all_cells("bar"), group("left", "left"), group("right", "right")};
  plan.problem.space.vector = false;
  plan.problem.space.dirichlet = {clamp(1), clamp(2)};
  plan.problem.forms = {diffusion(1, 0, field_of_u(1)), diffusion(1, 0, field_of_u(0)),
                        diffusion(1, 0, field_of_memory(0), -0.7)};
  plan.problem.histories = {{{}, {"q", {}, exp(-lag) * (1.0 + t) / (1.0 + t - lag)}}};
  plan.problem.loads = {force(0, {8.0 * t})};
  plan.problem.time.is_static = false;
  const int steps = 24;
  plan.problem.time.grid = uniform_grid(1.0, steps);
  plan.report.probes = {at_point("u", u_value(0), {0.5, 0, 0})};
  plan.report.tables = {{{}, {0}, 1, false, ""}};
  const auto result = solve(plan);

  // Gauss-Legendre with 5 points integrates the smooth kernel to rounding on these intervals.
  const double nodes[] = {0, .5384693101056831, .9061798459386640};
  const double weights[] = {.5688888888888889, .4786286704993665, .2369268850561891};
  const auto weight = [&](int n, int j) {
    const double k = 1.0 / steps, middle = (j - 0.5) * k;
    double sum = weights[0] * q(n * k, middle);
    for (int i = 1; i < 3; ++i)
      sum +=
          weights[i] * (q(n * k, middle + nodes[i] * k / 2) + q(n * k, middle - nodes[i] * k / 2));
    return sum * k / 2;
  };
  std::vector<double> u{0};
  for (int n = 1; n <= steps; ++n) {
    const double k = 1.0 / steps;
    double memory = 0;
    for (int j = 1; j < n; ++j) memory += weight(n, j) * u[j];
    // 4 (u_n - u_{n-1}) / k + 4 u_n - 2.8 (memory + w u_n) = 8 t_n / 2
    u.push_back((4 * n * k + 4 * u[n - 1] / k + 2.8 * memory) / (4 / k + 4 - 2.8 * weight(n, n)));
    expect_relative(result.columns.at("u")[n - 1], u[n], 1e-8, "step " + std::to_string(n));
  }
  EXPECT_LE(result.work.factorisations, 3); // refined with an old factor, not factored again
}

// Property: a problem moved in time has the same answers, its memories begin where its grid does.
TEST(Memory, BeginsAtTheFirstTimeOfTheGrid) {
  const Expr t = var(slot::t);
  const auto moved = [&](double t0, bool graded) {
    Plan plan = slab(4, 16);
    plan.problem.loads = {force(body, {0.0, -10.0 * (t - Expr(t0))}),
                          force(flank, {3.0 * (t - Expr(t0))})};
    if (graded) plan.problem.histories[0].route = HistoryRoute::direct;
    for (std::size_t n = 0; n < plan.problem.time.grid.size(); ++n) {
      const double part = plan.problem.time.grid[n];
      plan.problem.time.grid[n] = t0 + (graded ? part * (1.0 + part) / 2.0 : part);
    }
    return solve(plan);
  };
  for (const bool graded : {false, true}) {
    const auto there = moved(0.0, graded);
    for (const double t0 : {-3.0, 0.5, 4.0}) {
      const auto here = moved(t0, graded);
      EXPECT_TRUE(here.certificate.certified);
      for (const auto& [name, column] : there.columns)
        for (std::size_t n = 0; n < column.size(); ++n)
          EXPECT_NEAR(here.columns.at(name)[n], column[n], 1e-9 * std::abs(column.back()))
              << name << t0;
    }
  }
}

// Analytic: unsymmetric B (diffusion + convection) on an interval, nodally exact linear solution.
TEST(Unsymmetric, ConvectionDiffusion) {
  Plan plan; // -u'' + u' = 1 with u(0) = u(1) = 0 on a fine grid
  plan.problem.mesh.kind = MeshSpec::Kind::interval;
  plan.problem.mesh.cells = {400, 1, 1};
  plan.problem.parts = {all_cells("bar"), group("left", "left"), group("right", "right")};
  plan.problem.space.vector = false;
  plan.problem.space.order = 2;
  plan.problem.space.dirichlet = {clamp(1), clamp(2)};
  FormTerm convection;
  convection.entries = {{slot::value(0), slot::gradient(0, 0), 1.0}};
  plan.problem.forms = {diffusion(1, 0, field_of_u(0)), convection};
  plan.problem.loads = {force(0, {1.0})};
  plan.report.probes = {at_point("u", u_value(0), {0.5, 0, 0})};
  const double exact = 0.5 - (std::exp(0.5) - 1) / (std::exp(1.0) - 1);
  expect_relative(solve(plan).final.at("u"), exact, 1e-9, "u(1/2)");
}

// Analytic: a bar pulled by an imposed, moving displacement: linear in x at all times.
TEST(Imposed, MovingEndIsFollowed) {
  auto plan = square(8);
  plan.problem.loads.clear();
  plan.problem.space.dirichlet = {clamp(1), clamp(2, -1, {0.1 * var(slot::t), 0.0 * var(slot::t)})};
  plan.problem.forms = {elastic(2, 0, field_of_u(0), {0, 1}), elastic(2, 0, field_of_u(1), {0, 1})};
  // lambda = 0 and u = (a x, 0): stress free at top and bottom, so this is the solution.
  plan.report.probes = {at_point("u", u_value(0), {0.5, 0.4, 0}),
                        at_point("v", var(slot::field(field_of_u(1), 0)), {0.5, 0.4, 0})};
  const auto result = solve(plan);
  EXPECT_NEAR(result.final.at("u"), 0.05, 1e-13);
  EXPECT_NEAR(result.final.at("v"), 0.05, 1e-12);
}

// Analytic: scalar problem with an obstacle-like law in the whole domain (all unknowns are contact
// unknowns): -u'' + c u = f with the law's slope c r, against the same problem with a mass form.
TEST(DomainLaw, EqualsTheFormItStandsFor) {
  Plan plan;
  plan.problem.mesh.high = {1, 1, 0};
  plan.problem.mesh.cells = {24, 24, 1};
  plan.problem.parts = {all_cells("body"), group("left", "left")};
  plan.problem.space.vector = false;
  plan.problem.space.dirichlet = {clamp(1)};
  plan.problem.forms = {diffusion(2, 0, field_of_u(0))};
  plan.problem.loads = {force(0, {1.0 + var(slot::x(0))})};
  plan.report.probes = {at_point("u", u_value(0), {0.75, 0.5, 0})};
  auto with_form = plan;
  FormTerm mass;
  mass.rule = Rule::nodal;
  mass.entries = {{slot::value(0), slot::value(0), 5.0}};
  with_form.problem.forms.push_back(mass);
  LawSpec law;
  law.by_slope = true;
  law.expression = 5.0 * var(slot::argument(0));
  plan.problem.laws = {law};
  LawTerm term;
  term.rows.resize(1);
  term.rows[0].u[0] = 1.0;
  plan.problem.law_terms = {term};
  const auto by_law = solve(plan);
  expect_relative(by_law.final.at("u"), solve(with_form).final.at("u"), 1e-11, "u");
  EXPECT_EQ(by_law.work.factorisations, 0); // nothing is condensed
}

// Analytic: an argument with a gap, u . nu - g: one spring per node closes the gap linearly.
TEST(Gap, ContactBeginsBeyondTheGap) {
  Plan plan; // a bar pressed against a spring: u(1) = (f + c g) / (1 + c), E = 1
  plan.problem.mesh.kind = MeshSpec::Kind::interval;
  plan.problem.mesh.cells = {5, 1, 1};
  plan.problem.parts = {all_cells("bar"), group("left", "left"), group("right", "right")};
  plan.problem.space.vector = false;
  plan.problem.space.dirichlet = {clamp(1)};
  plan.problem.forms = {diffusion(1, 0, field_of_u(0))};
  plan.problem.loads = {force(2, {0.3})};
  LawSpec law;
  law.by_slope = true;
  law.expression = 50.0 * max(var(slot::argument(0)), 0.0);
  plan.problem.laws = {law};
  LawTerm term;
  term.part = 2;
  term.rows.resize(1);
  term.rows[0].u[0] = 1.0;
  term.rows[0].offset = -0.1;
  plan.problem.law_terms = {term};
  plan.report.probes = {at_point("u", u_value(0), {1, 0, 0}),
                        integral("p", var(slot::multiplier(0, 0)), 2)};
  const auto result = solve(plan);
  EXPECT_NEAR(result.final.at("u"), (0.3 + 50 * 0.1) / 51, 1e-13);
  EXPECT_NEAR(result.final.at("p"), 50 * ((0.3 + 5.0) / 51 - 0.1), 1e-12);
}

TEST(TimeGrid, UniformGridHasOneLength) {
  Problem problem;
  TimeSpec& spec = problem.time;
  spec.is_static = false;
  spec.grid = uniform_grid(0.7, 1000);
  const TimeGrid grid(spec);
  for (int n = 2; n <= 1000; ++n) EXPECT_EQ(grid.length(n), grid.length(1));
  EXPECT_EQ(useful_factors(*make_scheme(problem)), 1);
}

} // namespace
} // namespace hvi::solver
