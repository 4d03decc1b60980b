// Inertia: the schemes against their own recurrences, energies, initial accelerations, masses of
// nodes in contact.
#include "solver/discrete/inertia.hpp"
#include "solver/linear/dense.hpp"
#include "solver/plan/validate.hpp"
#include "tests/solver/time/plans.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace hvi::solver {
namespace {

using namespace testing_plans;

constexpr Scheme all_schemes[] = {Scheme::backward_euler, Scheme::bdf2, Scheme::newmark,
                                  Scheme::hht, Scheme::midpoint};

FormTerm products(int components, int part, int field, double factor) {
  FormTerm form;
  form.part = part;
  form.field = field;
  for (int i = 0; i < components; ++i)
    form.entries.push_back({slot::value(i), slot::value(i), factor});
  return form;
}

LawSpec obstacle() {
  LawSpec out;
  out.name = "obstacle";
  out.by_slope = true;
  out.expression = select(less_equal(var(slot::argument(0)), 0.0), 0.0, 1e300);
  return out;
}

LawSpec tresca(double bound) {
  LawSpec out;
  out.name = "slip";
  out.radial = true;
  out.expression = Expr(bound) * var(slot::argument(0));
  return out;
}

struct Recorded {
  RunResult result;
  std::vector<Vector> states;
  std::vector<double> column(const std::string& name) const {
    const auto& table = *result.monitors;
    const auto at = std::find(table.names.begin(), table.names.end(), name);
    return table.columns.at(static_cast<std::size_t>(at - table.names.begin()));
  }
};

Recorded record(const Plan& plan) {
  Discretisation d;
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  Recorded out;
  RunSettings settings;
  settings.monitors = true;
  settings.on_step = [&](int, double, const Vector& u, const Vector&) { out.states.push_back(u); };
  out.result = run(plan, d, settings);
  return out;
}

/// u'' + damping u' + stiffness u = sin(3 t), u(0) = 1, u'(0) = .3: the same at every node.
struct Oscillator {
  double damping = 0.4, stiffness = 7.0;
  Plan plan(Scheme scheme, std::vector<double> grid) const {
    Plan out;
    out.problem.mesh.kind = MeshSpec::Kind::interval;
    out.problem.mesh.cells = {3, 1, 1};
    out.problem.parts = {all_cells("bar")};
    out.problem.space.vector = false;
    out.problem.forms = {products(1, 0, field_of_u(2), 1.0), products(1, 0, field_of_u(1), damping),
                         products(1, 0, field_of_u(0), stiffness)};
    out.problem.loads = {force(0, {sin(3.0 * var(slot::t))})};
    out.problem.time.is_static = false;
    out.problem.time.grid = std::move(grid);
    out.problem.time.scheme = scheme;
    out.problem.time.hht_alpha = -0.2;
    out.problem.time.initial = {Expr(1.0)};
    out.problem.time.velocity = {Expr(0.3)};
    out.report.probes = {at_point("u", u_value(0), {0.4, 0, 0}),
                         at_point("v", var(slot::field(field_of_u(1), 0)), {0.4, 0, 0}),
                         at_point("a", var(slot::field(field_of_u(2), 0)), {0.4, 0, 0})};
    return out;
  }
  double force_at(double t) const { return std::sin(3.0 * t); }

  /// u, u', u'' at the end, in the form of textbooks: accelerations are the unknowns.
  std::array<double, 3> by_hand(Scheme scheme, const std::vector<double>& grid) const {
    double u = 1.0, v = 0.3, a = force_at(grid[0]) - damping * v - stiffness * u, rate = v;
    double u_before = 0.0, v_before = 0.0;
    for (std::size_t n = 1; n < grid.size(); ++n) {
      const double k = grid[n] - grid[n - 1], f = force_at(grid[n]), f_old = force_at(grid[n - 1]);
      const double u_old = u, v_old = v, a_old = a;
      const bool two = scheme == Scheme::bdf2 && n > 1;
      const double w = two ? k / (grid[n - 1] - grid[n - 2]) : 0.0;
      // x'(t_n) = p x_n - q x_{n-1} + r x_{n-2}
      const double p = (1 + 2 * w) / (1 + w) / k, q = (1 + w) / k, r = w * w / (1 + w) / k;
      const auto newmark = [&](double beta, double gamma, double alpha) {
        const double u_star = u_old + k * v_old + k * k * (0.5 - beta) * a_old;
        const double v_star = v_old + k * (1 - gamma) * a_old;
        const double old = f_old - damping * v_old - stiffness * u_old;
        a = ((1 + alpha) * (f - damping * v_star - stiffness * u_star) - alpha * old) /
            (1 + (1 + alpha) * (damping * gamma * k + stiffness * beta * k * k));
        u = u_star + k * k * beta * a;
        v = v_star + k * gamma * a;
        rate = v;
      };
      switch (scheme) {
      case Scheme::backward_euler:
      case Scheme::bdf2: {
        const double known_v = -q * u_old + r * u_before;              // v = p u + known_v
        const double known_a = p * known_v - q * v_old + r * v_before; // a = p^2 u + known_a
        u = (f - known_a - damping * known_v) / (p * p + damping * p + stiffness);
        v = rate = p * u + known_v;
        a = p * p * u + known_a;
        break;
      }
      case Scheme::newmark:
        newmark(0.25, 0.5, 0.0);
        break;
      case Scheme::hht:
        newmark(0.36, 0.7, -0.2);
        break;
      case Scheme::midpoint:
        a = (0.5 * (f + f_old) - damping * v_old - stiffness * (u_old + 0.5 * k * v_old)) /
            (1 + 0.5 * k * damping + 0.25 * k * k * stiffness);
        v = v_old + k * a;
        rate = 0.5 * (v + v_old);
        u = u_old + k * rate;
        break;
      }
      u_before = u_old, v_before = v_old;
    }
    return {u, rate, a};
  }
};

TEST(Motion, SchemesAreThoseOfTheirFormulas) {
  const Oscillator oscillator;
  for (const Scheme scheme : all_schemes)
    for (const bool graded : {false, true}) {
      auto grid = uniform_grid(1.5, 24);
      if (graded)
        for (double& t : grid) t = 1.5 * std::pow(t / 1.5, 1.5);
      const auto result = solve(oscillator.plan(scheme, grid));
      const auto [u, v, a] = oscillator.by_hand(scheme, grid);
      EXPECT_NEAR(result.final.at("u"), u, 1e-12) << name_of(scheme) << graded;
      EXPECT_NEAR(result.final.at("v"), v, 1e-11) << name_of(scheme) << graded;
      EXPECT_NEAR(result.final.at("a"), a, 1e-9) << name_of(scheme) << graded;
    }
}

TEST(Motion, OrdersAreOneAndTwo) {
  const Oscillator oscillator;
  const auto fine = oscillator.by_hand(Scheme::newmark, uniform_grid(1.5, 200000))[0];
  for (const Scheme scheme : all_schemes) {
    std::array<double, 3> errors{};
    for (std::size_t i = 0; i < errors.size(); ++i)
      errors[i] = std::abs(
          solve(oscillator.plan(scheme, uniform_grid(1.5, 160 << i))).final.at("u") - fine);
    for (std::size_t i = 1; i < errors.size(); ++i)
      EXPECT_NEAR(std::log2(errors[i - 1] / errors[i]), order_of(scheme, false), 0.1)
          << name_of(scheme);
  }
}

/// A block that is thrown; `n` cells across it.
Plan block(int n, int steps, int dim, Scheme scheme, double end) {
  Plan out = slab(n, steps, dim);
  auto& problem = out.problem;
  problem.space.dirichlet.clear();
  problem.forms = {products(dim, body, field_of_u(2), 2.0),
                   elastic(dim, body, field_of_u(0), from_young(70, 0.3))};
  problem.histories.clear();
  problem.laws.clear(), problem.law_terms.clear(), problem.loads.clear();
  problem.time.grid = uniform_grid(end, steps);
  problem.time.scheme = scheme;
  out.report.probes = {norm("strain")};
  out.report.tables.clear();
  return out;
}

/// The columns of --monitors from the displacements alone, by the formulas of each scheme: forces
/// of a step act as its equation mixes them.
TEST(Motion, EnergiesAreThoseOfTheFormulas) {
  struct Step { ///< at its end; f is sampled there
    double u, v, a, f;
  };
  const Oscillator of;
  const auto grid = [] {
    auto out = uniform_grid(1.5, 30);
    for (double& t : out) t = 1.5 * std::pow(t / 1.5, 1.3);
    return out;
  }();
  for (const Scheme scheme : all_schemes) {
    const bool hht = scheme == Scheme::hht;
    const double beta = hht ? 0.36 : 0.25, gamma = hht ? 0.7 : 0.5; // of alpha = -0.2
    const double past = hht ? 0.2 : scheme == Scheme::newmark ? 0.5 : 0.0, present = 1.0 - past;
    const auto run = record(of.plan(scheme, grid));
    Step last{1.0, 0.3, 0.0, of.force_at(0.0)};
    last.a = last.f - of.damping * last.v - of.stiffness * last.u;
    double before = 0.0, work = 0.0, viscous = 0.0, lost = 0.0;
    for (std::size_t n = 1; n < grid.size(); ++n) {
      SCOPED_TRACE(std::string(name_of(scheme)) + " " + std::to_string(n));
      const double k = grid[n] - grid[n - 1];
      Step now{run.states[n - 1][0], 0.0, 0.0, of.force_at(grid[n])};
      const double d = now.u - last.u;
      double rate = d / k, force = present * now.f + past * last.f;
      if (scheme == Scheme::backward_euler || (scheme == Scheme::bdf2 && n == 1)) {
        now.v = rate;
      } else if (scheme == Scheme::bdf2) {
        const double w = k / (grid[n - 1] - grid[n - 2]);
        now.v = ((1 + 2 * w) / (1 + w) * d - w * w / (1 + w) * (last.u - before)) / k;
      } else if (scheme == Scheme::midpoint) {
        now.v = 2.0 * rate - last.v;
        force = 0.5 * (now.f + last.f);
      } else {
        now.a = (d - k * last.v - k * k * (0.5 - beta) * last.a) / (beta * k * k);
        now.v = last.v + k * ((1 - gamma) * last.a + gamma * now.a);
      }
      if (scheme != Scheme::midpoint) rate = present * now.v + past * last.v;
      const auto stored = [&](const Step& at) {
        return 0.5 * (of.stiffness * at.u * at.u + at.v * at.v);
      };
      work += force * d, viscous += of.damping * rate * d;
      lost += (force - of.damping * rate) * d - (stored(now) - stored(last));
      EXPECT_NEAR(run.column("work")[n - 1], work, 1e-9);
      EXPECT_NEAR(run.column("viscous")[n - 1], viscous, 1e-9);
      EXPECT_NEAR(run.column("lost")[n - 1], lost, 1e-9);
      EXPECT_NEAR(run.column("kinetic")[n - 1], 0.5 * now.v * now.v, 1e-9);
      before = last.u, last = now;
    }
    const bool keeps = scheme == Scheme::newmark || scheme == Scheme::midpoint;
    EXPECT_EQ(std::abs(lost) < 1e-9, keeps) << lost;
    EXPECT_GT(std::min(std::abs(work), viscous), 0.01);
    EXPECT_LT(run.result.monitors->balance_error, 1e-12);
  }
}

/// By midpoint a mean of the load stands for both ends of its step: nothing is lost with it,
/// either.
TEST(Motion, MeansOfLoadsAtMidpointLoseNothing) {
  const Oscillator of;
  auto plan = of.plan(Scheme::midpoint, uniform_grid(1.5, 20));
  plan.problem.time.sampling = LoadSampling::average;
  const auto run = record(plan);
  double work = 0.0, last = 1.0;
  for (std::size_t n = 1; n <= 20; ++n) {
    const double a = plan.problem.time.grid[n - 1], b = plan.problem.time.grid[n];
    const double u = run.states[n - 1][0];
    work += (std::cos(3.0 * a) - std::cos(3.0 * b)) / (3.0 * (b - a)) * (u - last);
    EXPECT_NEAR(run.column("work")[n - 1], work, 1e-10);
    EXPECT_NEAR(run.column("lost")[n - 1], 0.0, 1e-12);
    last = u;
  }
}

/// A free block that loses stiffness: by the schemes that lose nothing themselves all that is lost
/// is what its states release.
TEST(Motion, WhatIsLostIsWhatStatesRelease) {
  for (const int dim : {2, 3})
    for (const Scheme scheme : {Scheme::newmark, Scheme::midpoint}) {
      Plan plan = block(2, 40, dim, scheme, 1.0);
      const Expr stretch = var(slot::field(field_of_u(0), slot::gradient(0, 0)));
      const Expr lost_part = var(slot::state(0));
      plan.problem.states = {
          {{}, "lost", body, 40.0 * stretch * stretch * (1.0 - lost_part), 0.1, 0.0, 0.95}};
      for (auto& form : plan.problem.forms)
        if (form.field == field_of_u(0))
          for (auto& entry : form.entries)
            entry.coefficient = (1.0 - lost_part) * entry.coefficient;
      plan.problem.time.velocity = {sin(2.0 * var(slot::x(0))), Expr(0.3) * var(slot::x(1))};
      if (dim == 3) plan.problem.time.velocity->push_back(Expr(0.0));
      const auto run = record(plan);
      const auto lost = run.column("lost"), released = run.column("released_forms");
      const double all = run.column("kinetic").front() + run.column("elastic").front();
      for (std::size_t n = 0; n < lost.size(); ++n)
        ASSERT_NEAR(lost[n], released[n], 1e-11 * all) << name_of(scheme) << dim << " " << n;
      EXPECT_GT(lost.back(), 0.02 * all);
    }
}

/// Two hundred to a thousand steps of a free block with waves in it.
TEST(Motion, EnergyIsKeptWhereNothingTouches) {
  for (const int dim : {2, 3})
    for (const Scheme scheme : {Scheme::newmark, Scheme::midpoint}) {
      Plan plan = block(2, dim == 2 ? 1000 : 200, dim, scheme, 2.0);
      const Expr x = var(slot::x(0)), y = var(slot::x(1));
      plan.problem.time.velocity = {sin(2.0 * x), Expr(0.3) * x * y};
      if (dim == 3) plan.problem.time.velocity->push_back(Expr(-0.4) + y * y);
      const auto run = record(plan);
      const auto kinetic = run.column("kinetic"), lost = run.column("lost");
      const auto [least, most] = std::ranges::minmax(kinetic);
      EXPECT_LT(least, 0.99 * most) << "there are waves";
      for (const double l : lost) ASSERT_NEAR(l, 0.0, 2e-12 * most) << name_of(scheme) << dim;
      EXPECT_LT(run.result.monitors->balance_error, 1e-12);
    }
}

/// Thrown on a ground where it rubs: neither contact, stiff or unilateral, nor friction gives it
/// energy, and what friction takes is told.
TEST(Motion, MidpointNeverGainsEnergy) {
  for (const int dim : {2, 3})
    for (const bool stiff : {false, true}) {
      Plan plan = block(dim == 2 ? 4 : 2, 300, dim, Scheme::midpoint, 1.5);
      LawSpec compliance = obstacle();
      compliance.expression = max(var(slot::argument(0)), 0.0) * 500.0;
      plan.problem.laws = {stiff ? obstacle() : compliance, tresca(0.5)};
      plan.problem.law_terms = {normal_term(0, ground, dim), tangential_term(1, ground, dim)};
      plan.problem.law_terms[0].rows[0].offset = -0.05;
      plan.problem.law_terms[1].field = field_of_u(1);
      plan.problem.time.velocity = {Expr(0.7), Expr(-1.0) - 0.3 * var(slot::x(0))};
      if (dim == 3) plan.problem.time.velocity->push_back(Expr(0.2));
      const auto run = record(plan);
      const auto lost = run.column("lost"), friction = run.column("friction_slip");
      const double all = run.column("energy").front();
      for (std::size_t n = 1; n < lost.size(); ++n) {
        ASSERT_GE(lost[n] - lost[n - 1], friction[n] - friction[n - 1] - 1e-12 * all) << n;
        ASSERT_GE(friction[n], friction[n - 1] - 1e-14 * all) << n;
      }
      EXPECT_GT(friction.back(), 1e-3 * all);
      EXPECT_LT(lost.back() - friction.back(), 0.05 * all) << "the contact takes little";
      EXPECT_LT(run.result.monitors->balance_error, 1e-11);
    }
}

/// A block that rubs at every point of it. Pulled by less than the bound: the initial acceleration
/// is none, and so is the motion. Pulled by more it slides as a whole, u = (pull - bound)/2 t^2/2.
TEST(Motion, FrictionAtRestHoldsOrLetsGo) {
  for (const Scheme scheme : {Scheme::newmark, Scheme::hht})
    for (const double pull : {0.3, 0.8}) {
      Plan plan = block(2, 40, 2, scheme, 1.0);
      plan.problem.laws = {tresca(0.5)};
      plan.problem.law_terms = {tangential_term(0, body, 2)};
      plan.problem.law_terms[0].field = field_of_u(1);
      plan.problem.law_terms[0].rows = {{{1.0, 0.0}}, {{0.0, 1.0}}};
      plan.problem.loads = {force(body, {Expr(0.6 * pull), Expr(0.8 * pull)})};
      plan.report.probes = {at_point("u", u_value(0), {1, 0.5, 0})};
      const double a = 0.6 * std::max(0.0, pull - 0.5) / 2.0; // the density is 2
      EXPECT_NEAR(solve(plan).final.at("u"), 0.5 * a, 1e-12) << name_of(scheme) << pull;
    }
}

/// Where an argument stands on a jump of its law, the force at the start is the one on the side it
/// moves to; where it rests, the one that keeps it there. The block translates: with the density 2,
/// 2 u'' is what the load leaves over, and both schemes are exact.
TEST(Motion, ForcesAtTheStartAreOnTheSideOfTheMotion) {
  const Expr r = var(slot::argument(0)), t = var(slot::t);
  LawSpec sides, pulls, ball = tresca(0.5), harder;
  sides.name = pulls.name = harder.name = "law";
  sides.by_slope = pulls.by_slope = harder.by_slope = harder.radial = true;
  sides.expression = select(less(r, 0.0), -0.5, 0.7);
  pulls.expression = select(less(r, 0.0), -0.5, 0.0);
  harder.expression = select(less(r, 0.4), 0.5, 0.9);
  struct Case {
    LawSpec law;
    Expr offset; ///< of the first row
    std::array<double, 2> velocity, force, load = {0.6, 0.0};
  };
  const Case cases[] = {{sides, -0.5 * t, {0.3, 0.0}, {-0.5, 0.0}},
                        {sides, 0.0, {0.3, 0.0}, {0.7, 0.0}},
                        {sides, -0.3 * t, {0.3, 0.0}, {0.6, 0.0}}, // all of the load
                        {pulls, -0.3 * t, {0.3, 0.0}, {-0.3, 0.0}, {-0.3, 0.0}},
                        {ball, 0.0, {0.3, -0.4}, {0.3, -0.4}, {0.6, -0.8}},
                        {harder, 0.4, {0.3, 0.0}, {0.9, 0.0}},
                        {harder, 0.4, {-0.3, 0.0}, {0.5, 0.0}}};
  for (const Scheme scheme : {Scheme::newmark, Scheme::hht})
    for (const Case& c : cases) {
      Plan plan = block(1, 1, 2, scheme, 0.01);
      plan.problem.laws = {c.law};
      plan.problem.law_terms = {tangential_term(0, body, 2)};
      auto& rows = plan.problem.law_terms[0].rows;
      rows = {{{1.0, 0.0}, c.offset}, {{0.0, 1.0}}};
      if (!c.law.radial) rows.pop_back();
      plan.problem.loads = {force(body, {Expr(c.load[0]), Expr(c.load[1])})};
      plan.problem.time.velocity = {Expr(c.velocity[0]), Expr(c.velocity[1])};
      for (int i = 0; i < 2; ++i)
        plan.report.probes.push_back(at_point(
            i == 0 ? "x" : "y", var(slot::field(field_of_u(2), slot::value(i))), {1, 0.5, 0}));
      plan.report.probes.push_back(at_point("u", u_value(0), {1, 0.5, 0}));
      const auto final = solve(plan).final;
      const double moved = 0.01 * c.velocity[0] + 0.25e-4 * (c.load[0] - c.force[0]);
      EXPECT_NEAR(final.at("u"), moved, 1e-13) << name_of(scheme) << c.force[0];
      EXPECT_NEAR(final.at("x"), (c.load[0] - c.force[0]) / 2.0, 1e-9)
          << name_of(scheme) << c.force[0];
      EXPECT_NEAR(final.at("y"), (c.load[1] - c.force[1]) / 2.0, 1e-9)
          << name_of(scheme) << c.force[0];
    }
}

/// A block that moves across the direction that a law sees: by rounding alone its arguments move,
/// at every point another way, and the law holds what the load is.
TEST(Motion, ArgumentsThatMoveByRoundingRest) {
  LawSpec sides;
  sides.name = "law";
  sides.by_slope = true;
  sides.expression = select(less(var(slot::argument(0)), 0.0), -0.5, 0.7);
  for (const auto& [angle, speed] :
       {std::pair(0.5, 0.3), std::pair(0.7, 0.1), std::pair(1.0, 0.7)}) {
    const double c = std::cos(angle), s = std::sin(angle);
    Plan plan = block(2, 1, 2, Scheme::newmark, 0.01);
    plan.problem.laws = {sides};
    plan.problem.law_terms = {tangential_term(0, body, 2)};
    plan.problem.law_terms[0].rows = {{{c, s}}};
    plan.problem.loads = {force(body, {Expr(0.3 * c), Expr(0.3 * s)})};
    plan.problem.time.velocity = {Expr(-speed * s), Expr(speed * c)};
    for (int i = 0; i < 2; ++i)
      plan.report.probes.push_back(at_point(i == 0 ? "x" : "y", u_value(i), {1, 0.5, 0}));
    const auto final = solve(plan).final;
    EXPECT_NEAR(final.at("x"), -0.01 * speed * s, 1e-15) << angle;
    EXPECT_NEAR(final.at("y"), 0.01 * speed * c, 1e-15) << angle;
  }
}

/// What a law reads of the velocity is known at the initial time: the bound 0.5 u'_y holds the
/// pull.
TEST(Motion, BoundsThatReadVelocitiesHoldAtTheStart) {
  Plan plan = block(2, 1, 2, Scheme::newmark, 0.01);
  LawSpec slip = tresca(0.5);
  slip.expression = var(slot::reading(0)) * slip.expression;
  slip.readings = {var(slot::field(field_of_u(1), slot::value(1)))};
  plan.problem.laws = {slip};
  plan.problem.law_terms = {tangential_term(0, body, 2)};
  plan.problem.law_terms[0].field = field_of_u(1);
  plan.problem.law_terms[0].rows = {{{1.0, 0.0}}, {{0.0, 0.0}}};
  plan.problem.loads = {force(body, {Expr(0.3)})};
  plan.problem.time.velocity = {Expr(0.0), Expr(1.0)};
  plan.report.probes = {at_point("u", u_value(0), {1, 0.5, 0})};
  EXPECT_NEAR(solve(plan).final.at("u"), 0.0, 1e-15);
}

/// Above the ground a block falls as every body does, with and without mass at its lower nodes.
TEST(Motion, FallsAsAWhole) {
  for (const int dim : {2, 3})
    for (const bool over_ground : {false, true}) {
      Plan plan = block(2, 20, dim, Scheme::midpoint, 0.2);
      if (over_ground) {
        plan.problem.laws = {obstacle()};
        plan.problem.law_terms = {normal_term(0, ground, dim)};
        plan.problem.law_terms[0].rows[0].offset = -5.0;
      }
      plan.problem.loads = {force(body, {Expr(0.0), Expr(-2.0 * 9.81)})};
      plan.problem.time.velocity.emplace(static_cast<std::size_t>(dim), Expr(0.0));
      (*plan.problem.time.velocity)[1] = Expr(-1.0);
      plan.report.probes = {at_point("foot", u_value(1), {1, 0, 0}),
                            at_point("top", u_value(1), {1, 1, 0})};
      const auto result = solve(plan);
      const double fall = -0.2 - 9.81 * 0.2 * 0.2 / 2;
      EXPECT_NEAR(result.final.at("foot"), fall, 1e-11) << dim << over_ground;
      EXPECT_NEAR(result.final.at("top"), fall, 1e-11) << dim << over_ground;
    }
}

/// What a law reads of a memory is known at the initial time, too: exp of nothing is one.
TEST(Motion, BoundsThatReadMemoriesHoldAtTheStart) {
  Plan plan = block(2, 40, 2, Scheme::newmark, 1.0);
  plan.problem.histories = {{{}, exponential_kernel(0.5)}};
  LawSpec slip = tresca(0.5);
  slip.expression = var(slot::reading(0)) * slip.expression;
  slip.readings = {exp(var(slot::field(field_of_memory(0), slot::value(0))))};
  plan.problem.laws = {slip};
  plan.problem.law_terms = {tangential_term(0, body, 2)};
  plan.problem.law_terms[0].field = field_of_u(1);
  plan.problem.law_terms[0].rows = {{{1.0, 0.0}}, {{0.0, 1.0}}};
  plan.problem.loads = {force(body, {Expr(0.3)})};
  plan.report.probes = {at_point("u", u_value(0), {1, 0.5, 0})};
  EXPECT_NEAR(solve(plan).final.at("u"), 0.0, 1e-14);
}

/// Coulomb's bound at the start is the multiplier there: a block that is pressed by 1 slides.
TEST(Motion, BoundsThatAreMultipliersHoldAtTheStart) {
  LawSpec press, slip = tresca(0.3);
  press.name = "press";
  press.by_slope = true;
  press.expression = 5.0 * var(slot::argument(0));
  slip.expression = abs(var(slot::coupled)) * slip.expression;
  slip.coupled = "press";
  Plan plan = block(1, 1, 2, Scheme::newmark, 0.01);
  plan.problem.laws = {press, slip};
  plan.problem.law_terms = {normal_term(0, body), tangential_term(1, body, 2)};
  plan.problem.law_terms[0].name = "press";
  plan.problem.law_terms[0].rows = {{{0.0, 1.0}, 0.2}};
  plan.problem.law_terms[1].rows = {{{1.0, 0.0}}, {{0.0, 1.0}}};
  plan.problem.law_terms[1].field = field_of_u(1);
  plan.problem.loads = {force(body, {Expr(0.6), Expr(1.0)})};
  plan.problem.time.velocity = {Expr(0.3), Expr(0.0)};
  plan.report.probes = {at_point("u", u_value(0), {1, 0.5, 0})};
  EXPECT_NEAR(solve(plan).final.at("u"), 0.3e-2 + 0.25e-4 * 0.3, 1e-13);
}

/// Mass taken off the nodes in contact: symmetric, none there, positive elsewhere, and with the
/// kinetic energy of every rigid motion.
TEST(Motion, MassOffTheGroundKeepsRigidMotions) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (const int dim : {2, 3})
    for (const int order : {1, 2}) {
      Plan plan = block(dim == 2 ? 3 : 2, 4, dim, Scheme::midpoint, 1.0);
      plan.problem.space.order = order;
      plan.problem.laws = {obstacle()};
      plan.problem.law_terms = {normal_term(0, ground, dim)};
      plan.problem.law_terms[0].rule = Rule::gauss;
      Discretisation d;
      ASSERT_TRUE(discretise(plan, d).empty());
      const SparseMatrix taken = inertia_matrix(plan.problem, d);
      const SparseMatrix whole = matrix_of(plan.problem, d, field_of_u(2));
      EXPECT_LT(SparseMatrix(taken - SparseMatrix(taken.transpose())).norm(), 1e-14 * whole.norm());
      for (int trial = 0; trial < 10; ++trial) {
        Point shift{}, spin{};
        for (int i = 0; i < 3; ++i) shift[i] = any(random), spin[i] = any(random);
        Vector v(d.space.n_dofs());
        for (int node = 0; node < static_cast<int>(d.space.nodes.size()); ++node) {
          const Point& x = d.space.nodes[static_cast<std::size_t>(node)];
          const Point turned =
              dim == 2 ? Point{-spin[2] * x[1], spin[2] * x[0], 0.0}
                       : Point{spin[1] * x[2] - spin[2] * x[1], spin[2] * x[0] - spin[0] * x[2],
                               spin[0] * x[1] - spin[1] * x[0]};
          for (int c = 0; c < dim; ++c) v[d.space.dof(node, c)] = shift[c] + turned[c];
        }
        expect_relative(v.dot(taken * v), v.dot(whole * v), 1e-12, "kinetic energy");
      }
      std::vector<int> heavy;
      for (int node = 0; node < static_cast<int>(d.space.nodes.size()); ++node) {
        const bool low = d.space.nodes[static_cast<std::size_t>(node)][1] == 0.0;
        for (int c = 0; c < dim; ++c) {
          const int dof = d.space.dof(node, c);
          if (!low) heavy.push_back(dof);
          if (low) {
            EXPECT_EQ(taken.row(dof).norm(), 0.0);
          }
        }
      }
      const DenseMatrix dense(taken);
      const Vector values = symmetric_eigenvalues(dense(heavy, heavy));
      EXPECT_GT(values[0], 1e-4 * values[values.size() - 1]);
    }
}

/// Dirichlet values that move have their own rates: u = x g(t) solves the wave equation with the
/// load x g''(t) exactly.
TEST(Motion, ImposedValuesHaveTheirRates) {
  const Expr t = var(slot::t), x = var(slot::x(0));
  const Expr g = Expr(0.3) * t + sin(2.0 * t), gpp = Expr(-4.0) * sin(2.0 * t);
  for (const Scheme scheme : all_schemes) {
    std::array<double, 2> errors{};
    for (std::size_t i = 0; i < errors.size(); ++i) {
      Plan plan = Oscillator{}.plan(scheme, uniform_grid(1.0, 40 << i));
      auto& problem = plan.problem;
      problem.parts.push_back(group("left", "left"));
      problem.parts.push_back(group("right", "right"));
      problem.space.dirichlet = {clamp(1), clamp(2, -1, {g})};
      problem.forms = {products(1, 0, field_of_u(2), 1.0), diffusion(1, 0, field_of_u(0))};
      problem.loads = {force(0, {x * gpp})};
      problem.time.initial.clear();
      problem.time.velocity = {Expr(2.3) * x};
      plan.report.probes = {at_point("u", u_value(0), {1.0 / 3, 0, 0})};
      const double exact = (0.3 + std::sin(2.0)) / 3;
      errors[i] = std::abs(solve(plan).final.at("u") - exact);
    }
    EXPECT_LT(errors[1], 0.02) << name_of(scheme);
    EXPECT_NEAR(std::log2(errors[0] / errors[1]), order_of(scheme, false), 0.25) << name_of(scheme);
  }
}

/// A bar with viscosity whose end is moved by `value`; at the end of time its force, u' and u''.
Plan moved_bar(Scheme scheme, std::vector<double> grid, const Expr& value) {
  Plan plan = Oscillator{}.plan(scheme, std::move(grid));
  auto& problem = plan.problem;
  problem.parts.push_back(group("left", "left"));
  problem.parts.push_back(group("right", "right"));
  problem.space.dirichlet = {clamp(1), clamp(2, -1, {value})};
  problem.forms = {products(1, 0, field_of_u(2), 1.0), diffusion(1, 0, field_of_u(1), 2.0),
                   diffusion(1, 0, field_of_u(0))};
  problem.loads.clear();
  problem.time.initial.clear();
  problem.time.velocity.reset();
  plan.report.probes = {at_point("rate", var(slot::field(field_of_u(1), 0)), {1, 0, 0}),
                        at_point("second", var(slot::field(field_of_u(2), 0)), {1, 0, 0})};
  auto& force = plan.report.probes.emplace_back();
  force.name = "force", force.kind = Probe::Kind::reaction, force.part = 2;
  return plan;
}

/// The end stops at t = 1.0025, inside a step or at its end; what is left at t = 20 is the force of
/// a bar at rest. Formulas that carry velocities on would answer the kink with +-v for ever.
TEST(Motion, AKinkOfImposedValuesIsForgotten) {
  const Expr ramp = 0.1 * min(var(slot::t) / Expr(1.0025), Expr(1.0));
  for (const Scheme scheme : all_schemes)
    for (const int steps : {400, 401, 8000}) {
      const auto final = solve(moved_bar(scheme, uniform_grid(20.0, steps), ramp)).final;
      EXPECT_NEAR(final.at("force"), 0.1, 1e-6) << name_of(scheme) << ", " << steps;
      EXPECT_NEAR(final.at("rate"), 0.0, 1e-12) << name_of(scheme) << ", " << steps;
      EXPECT_NEAR(final.at("second"), 0.0, 1e-9) << name_of(scheme) << ", " << steps;
    }
}

/// u = t^3 has u''(1) = 6, whether the number of steps is even or odd.
TEST(Motion, AccelerationsOfImposedValuesConverge) {
  const Expr t = var(slot::t);
  for (const Scheme scheme : {Scheme::newmark, Scheme::bdf2})
    for (const int steps : {200, 201}) {
      const auto final = solve(moved_bar(scheme, uniform_grid(1.0, steps), t * t * t)).final;
      EXPECT_NEAR(final.at("rate"), 3.0, 1e-4) << name_of(scheme) << ", " << steps;
      EXPECT_NEAR(final.at("second"), 6.0, 2e-2) << name_of(scheme) << ", " << steps;
    }
}

/// Functions that are t from t = 0 on move the end as t does.
TEST(Motion, AKinkAtTheStartIsNoRest) {
  const Expr t = var(slot::t);
  for (const Scheme scheme : all_schemes) {
    const auto grid = uniform_grid(1.0, 50);
    const double expected = solve(moved_bar(scheme, grid, t)).final.at("force");
    for (const Expr& same : {max(t, Expr(0.0)), abs(t), select(less_equal(t, 0.0), 0.0, t)})
      EXPECT_NEAR(solve(moved_bar(scheme, grid, same)).final.at("force"), expected, 1e-12)
          << name_of(scheme);
  }
}

/// u = x (.3 t + .7 t^2): what is imposed accelerates from the start, and one step is exact.
TEST(Motion, ImposedValuesAccelerateFromTheStart) {
  const Expr t = var(slot::t), x = var(slot::x(0));
  for (const Scheme scheme : {Scheme::newmark, Scheme::hht}) {
    Plan plan = Oscillator{}.plan(scheme, uniform_grid(0.01, 1));
    auto& problem = plan.problem;
    problem.parts.push_back(group("left", "left"));
    problem.parts.push_back(group("right", "right"));
    problem.space.dirichlet = {clamp(1), clamp(2, -1, {0.3 * t + 0.7 * t * t})};
    problem.forms = {products(1, 0, field_of_u(2), 1.0), diffusion(1, 0, field_of_u(0))};
    problem.loads = {force(0, {1.4 * x})};
    problem.time.initial.clear();
    problem.time.velocity = {0.3 * x};
    plan.report.probes.push_back(at_point("end", var(slot::field(field_of_u(2), 0)), {1, 0, 0}));
    const auto final = solve(plan).final;
    EXPECT_NEAR(final.at("a"), 1.4 * 0.4, 1e-9) << name_of(scheme);
    EXPECT_NEAR(final.at("end"), 1.4, 1e-9) << name_of(scheme);
    EXPECT_NEAR(final.at("u"), 0.4 * (0.3e-2 + 0.7e-4), 1e-13) << name_of(scheme);
  }
}

/// Without a given velocity imposed values bring their own; a given one must be theirs.
TEST(Motion, VelocitiesOfImposedValuesAreGivenOrFollow) {
  Plan plan = Oscillator{}.plan(Scheme::newmark, uniform_grid(1.0, 4));
  plan.problem.parts.push_back(group("right", "right"));
  plan.problem.space.dirichlet = {clamp(1, -1, {Expr(1.0) + 0.5 * var(slot::t)})};
  Discretisation d;
  EXPECT_EQ(discretise(plan, d).size(), 1U); // .3 is given
  plan.problem.time.velocity.reset();
  EXPECT_TRUE(discretise(plan, d).empty());
}

TEST(Motion, PlansWithoutInertiaAreRefused) {
  Plan plan = Oscillator{}.plan(Scheme::newmark, uniform_grid(1.0, 4));
  EXPECT_TRUE(validate(plan, 1).empty());
  Plan no_alpha = plan;
  no_alpha.problem.time.hht_alpha = 0.1;
  EXPECT_EQ(validate(no_alpha, 1).size(), 1U);
  Plan two = plan;
  two.problem.time.velocity->push_back(Expr(0.0));
  EXPECT_EQ(validate(two, 1).size(), 1U);
  plan.problem.forms.erase(plan.problem.forms.begin());
  EXPECT_EQ(validate(plan, 1).size(), 3U); // scheme, velocity, the column of u''
}

/// Newmark's and HHT's schemes start from an acceleration, which massless parts do not have.
TEST(Motion, MassesThatAreMissingAreSaid) {
  for (const Scheme scheme : all_schemes) {
    Plan plan = Oscillator{}.plan(scheme, uniform_grid(1.0, 4));
    plan.problem.parts.push_back(all_cells("half"));
    auto& region = plan.problem.parts.back().region;
    region.kind = RegionSpec::Kind::where;
    region.children = {RegionSpec{}};
    region.predicate = less(var(slot::x(0)), 0.5);
    plan.problem.forms[0].part = 1;
    const bool needs = scheme == Scheme::newmark || scheme == Scheme::hht;
    if (!needs) {
      EXPECT_NO_THROW(solve(plan)) << name_of(scheme);
      continue;
    }
    try {
      solve(plan);
      FAIL() << name_of(scheme);
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.kind, FailureKind::not_coercive);
    }
  }
}

} // namespace
} // namespace hvi::solver
