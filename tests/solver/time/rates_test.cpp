// Laws on u': what friction dissipates, sticking that does not creep, resumed runs, both paths.
#include "solver/plan/validate.hpp"
#include "tests/solver/time/plans.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hvi::solver {
namespace {

using namespace testing_plans;

constexpr double bound = 0.4;

/// Tresca's friction on the rate of the ground, under a shear of the flank that comes and goes.
Plan joint(int n, int steps, double cycles, double pull, int dim = 2) {
  Plan plan = slab(n, steps, dim);
  LawSpec slip;
  slip.name = "slip";
  slip.radial = true;
  slip.expression = Expr(bound) * var(slot::argument(0));
  plan.problem.laws.push_back(slip);
  plan.problem.law_terms.push_back(tangential_term(1, ground, dim));
  plan.problem.law_terms.back().field = field_of_u(1);
  const Expr turns = Expr(2.0 * std::numbers::pi * cycles) * var(slot::t);
  plan.problem.loads = {force(body, {0.0, -10.0}), force(flank, {Expr(pull) * sin(turns)})};
  return plan;
}

struct RecordedRates {
  RunResult result;
  std::vector<Vector> states, multipliers;
};

RecordedRates record_rates(const Plan& plan, bool monitors = true) {
  Discretisation d;
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  RecordedRates out;
  out.states.push_back(Vector::Zero(d.space.n_dofs()));
  RunSettings settings;
  settings.monitors = monitors;
  settings.on_step = [&](int, double, const Vector& u, const Vector& xi) {
    out.states.push_back(u);
    out.multipliers.push_back(xi);
  };
  out.result = run(plan, d, settings);
  return out;
}

std::vector<double> column(const RecordedRates& run, const std::string& name) {
  const auto& table = *run.result.monitors;
  const auto at = std::find(table.names.begin(), table.names.end(), name);
  return table.columns.at(static_cast<std::size_t>(at - table.names.begin()));
}

/// Over a hundred cycles friction dissipates the bound times the path of every point, by the
/// trapezoidal rule of the ground's nodes, and the work balances.
TEST(Rates, DissipationIsTheBoundTimesThePath) {
  constexpr int n = 2;
  const Plan plan = joint(n, 2000, 100.0, 60.0);
  const auto run = record_rates(plan);
  Discretisation d;
  ASSERT_TRUE(discretise(plan, d).empty());
  double path = 0.0;
  const auto friction = column(run, "friction_slip");
  for (std::size_t m = 1; m < run.states.size(); ++m) {
    for (int v = 0; v < static_cast<int>(d.mesh.nodes.size()); ++v) {
      const auto& x = d.mesh.nodes[static_cast<std::size_t>(v)];
      if (x[1] != 0.0) continue;
      const double weight = (x[0] == 0.0 || x[0] == 2.0 ? 0.5 : 1.0) / n;
      const int dof = d.space.dof(v, 0);
      path += weight * std::abs(run.states[m][dof] - run.states[m - 1][dof]);
    }
    ASSERT_NEAR(friction[m - 1], bound * path, 1e-9 * bound * path) << "after step " << m;
  }
  EXPECT_GT(path, 1.0);
  EXPECT_GT(column(run, "lost").back(), friction.back());
  EXPECT_LT(run.result.monitors->balance_error, 1e-12);
}

/// A law on two parts has two columns.
TEST(Rates, EveryApplicationHasItsColumn) {
  Plan plan = joint(2, 4, 1.0, 6.0);
  plan.problem.law_terms.push_back(plan.problem.law_terms.back());
  plan.problem.law_terms.back().part = flank;
  const auto names = record_rates(plan).result.monitors->names;
  EXPECT_EQ(std::vector<std::string>(names.end() - 2, names.end()),
            (std::vector<std::string>{"friction_slip_ground", "friction_slip_flank"}));
}

/// Below the bound nothing slips, and ten thousand steps later nothing has.
TEST(Rates, StickingDoesNotCreep) {
  Plan plan = joint(2, 10000, 50.0, 0.1);
  plan.problem.loads[0] = force(body, {0.0, 0.0});
  const auto run = record_rates(plan, false);
  Discretisation d;
  ASSERT_TRUE(discretise(plan, d).empty());
  double moved = 0.0, size = 0.0;
  for (const auto& u : run.states) {
    size = std::max(size, u.lpNorm<Eigen::Infinity>());
    for (int v = 0; v < static_cast<int>(d.mesh.nodes.size()); ++v)
      if (d.mesh.nodes[static_cast<std::size_t>(v)][1] == 0.0)
        moved = std::max(moved, std::abs(u[d.space.dof(v, 0)]));
  }
  EXPECT_GT(size, 1e-5);
  EXPECT_LE(moved, 1e-13 * size);
}

/// What slipped and is let go a little sticks: nothing moves in ten thousand steps,
/// with either scheme (the last rate of bdf2 fades within a few steps).
TEST(Rates, WhatStopsStays) {
  for (const int dim : {2, 3})
    for (const Scheme scheme : {Scheme::backward_euler, Scheme::bdf2}) {
      Plan plan = joint(1, 16000, 1.0, 1.0, dim);
      plan.problem.time.scheme = scheme;
      plan.problem.time.grid = uniform_grid(16.0, 16000);
      plan.problem.histories.clear();
      std::erase_if(plan.problem.forms, [](const FormTerm& f) { return is_memory(f.field); });
      const Expr pull = select(less(var(slot::t), 5.0), 6.0, 5.8);
      plan.problem.loads = {force(body, {pull, -10.0})};
      const auto run = record_rates(plan, false);
      Discretisation d;
      ASSERT_TRUE(discretise(plan, d).empty());
      const auto ground_of = [&](std::size_t step) {
        std::vector<double> out;
        for (int v = 0; v < static_cast<int>(d.mesh.nodes.size()); ++v)
          if (d.mesh.nodes[static_cast<std::size_t>(v)][1] == 0.0)
            out.push_back(run.states[step][d.space.dof(v, 0)]);
        return out;
      };
      const auto stopped = ground_of(6000);
      double slipped = 0.0, moved = 0.0;
      for (std::size_t step = 6000; step < run.states.size(); ++step) {
        const auto now = ground_of(step);
        for (std::size_t i = 0; i < now.size(); ++i) {
          slipped = std::max(slipped, std::abs(now[i]));
          moved = std::max(moved, std::abs(now[i] - stopped[i]));
        }
      }
      EXPECT_GT(slipped, 1e-3);
      EXPECT_LE(moved, 1e-13 * slipped) << dim;
    }
}

/// On all unknowns and on the contact unknowns; in 3D friction has two rows.
TEST(Rates, BothPathsGiveTheSame) {
  for (const int dim : {2, 3})
    for (const Scheme scheme : {Scheme::backward_euler, Scheme::bdf2}) {
      Plan plan = joint(2, 12, 1.0, 6.0, dim);
      plan.problem.time.scheme = scheme;
      for (double& t : plan.problem.time.grid) t = t * (2 + t) / 3; // every step has its own length
      const auto b = from_young(70, 0.3);
      plan.problem.forms[0] = elastic(dim, body, field_of_u(1), b, 0.2); // multiples of one tensor
      const auto reduced = record_rates(plan, false);
      plan.options.proportional_path = false;
      const auto all = record_rates(plan, false);
      double size = 0.0, apart = 0.0;
      for (std::size_t m = 0; m < all.states.size(); ++m) {
        size = std::max(size, all.states[m].lpNorm<Eigen::Infinity>());
        apart = std::max(apart, (all.states[m] - reduced.states[m]).lpNorm<Eigen::Infinity>());
      }
      EXPECT_LE(apart, 1e-9 * size) << dim;
      EXPECT_GT(size, 1e-3);
    }
}

/// In a memory that a law sees the present must count: the step's problem has the law's row times
/// it.
TEST(Rates, LawsSeeMemoriesThatArePositiveAtLagZero) {
  Plan plan = slab(2, 4);
  plan.problem.histories.push_back({{}, exponential_kernel(0.1)});
  plan.problem.law_terms[0].field = field_of_memory(1);
  EXPECT_TRUE(record_rates(plan, false).result.certificate.certified);
  auto& kernel = plan.problem.histories.back().kernel;
  kernel.expression = -1.0 * kernel.expression;
  try {
    solve(plan);
    FAIL() << "it ran";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.kind, FailureKind::bad_kernel);
    EXPECT_EQ(failure.origin, plan.problem.law_terms[0].origin);
  }
}

/// The joint whose bound grows with what the memory of u holds at the point.
Plan remembering(double share, int steps, int dim, Scheme scheme) {
  Plan plan = joint(2, steps, 1.0, 6.0, dim);
  plan.problem.time.scheme = scheme;
  const auto past = [](int i) { return var(slot::field(field_of_memory(0), slot::value(i))); };
  Expr square = 0.0;
  for (int i = 0; i < dim; ++i) square = square + past(i) * past(i);
  LawSpec& slip = plan.problem.laws.back();
  slip.readings = {sqrt(square)};
  slip.expression = slip.expression * (1.0 + share * var(slot::reading(0)));
  const auto b = from_young(70, 0.3);
  plan.problem.forms[0] = elastic(dim, body, field_of_u(1), b, 0.2); // multiples of one tensor
  return plan;
}

/// The memory is that of the end of the step: where a point slips, its multiplier is the bound that
/// the state after the step makes, on contact unknowns and on all of them.
TEST(Rates, BoundsReadMemoriesOfTheSameState) {
  for (const int dim : {2, 3})
    for (const Scheme scheme : {Scheme::backward_euler, Scheme::bdf2}) {
      Plan plan = remembering(100.0, 12, dim, scheme);
      const auto reduced = record_rates(plan, false);
      plan.options.proportional_path = false;
      const auto all = record_rates(plan, false);
      plan.problem.laws.back().readings = {0.0};
      const auto without = record_rates(plan, false);
      double size = 0.0, apart = 0.0, changed = 0.0;
      for (std::size_t m = 0; m < all.states.size(); ++m) {
        size = std::max(size, all.states[m].lpNorm<Eigen::Infinity>());
        apart = std::max(apart, (all.states[m] - reduced.states[m]).lpNorm<Eigen::Infinity>());
        changed = std::max(changed, (all.states[m] - without.states[m]).lpNorm<Eigen::Infinity>());
      }
      EXPECT_LE(apart, 1e-9 * size) << dim;
      EXPECT_GT(changed, 1e-2 * size) << dim;
    }
}

/// Readings that the step's own solution moves by more than they moved it are found, too.
TEST(Rates, ReadingsNeedNotContract) {
  const auto run = record_rates(remembering(1e6, 2, 2, Scheme::backward_euler), false);
  EXPECT_TRUE(run.result.certificate.certified);
  EXPECT_LE(run.result.certificate.inclusion, 1e-10);
}

/// What is no value of a memory cannot be read, nor a fifth quantity.
TEST(Rates, WhatLawsCannotReadIsRefused) {
  const auto good = [](const Expr& reading, int count = 1) {
    Plan plan = remembering(1.0, 2, 2, Scheme::backward_euler);
    plan.problem.laws.back().readings.assign(static_cast<std::size_t>(count), reading);
    return validate(plan, 2).empty();
  };
  const int memory = field_of_memory(0);
  EXPECT_TRUE(good(var(slot::field(memory, slot::value(1))), slot::most_readings));
  EXPECT_FALSE(good(var(slot::field(memory, slot::value(1))), slot::most_readings + 1));
  EXPECT_FALSE(good(var(slot::field(memory, slot::gradient(0, 0)))));
  EXPECT_FALSE(good(var(slot::field(memory + 1, slot::value(0)))));
  EXPECT_TRUE(good(var(slot::field(field_of_u(0), slot::value(0)))));
  EXPECT_TRUE(good(var(slot::field(field_of_u(1), slot::value(1)))));
  EXPECT_FALSE(good(var(slot::field(field_of_u(2), slot::value(0)))));
  EXPECT_TRUE(good(var(slot::multiplier(0, 0))));
  EXPECT_FALSE(good(var(slot::multiplier(7, 0)))); // there is no such law
  EXPECT_FALSE(good(var(slot::argument(0))));
}

/// A law on the rate of a plan without time, or on a field that there is not, is a mistake of the
/// plan.
TEST(Rates, PlansWithoutARateAreRefused) {
  Plan plan = joint(1, 2, 1.0, 1.0);
  EXPECT_TRUE(validate(plan, 2).empty());
  plan.problem.law_terms.back().field = field_of_memory(1);
  EXPECT_FALSE(validate(plan, 2).empty());
  plan.problem.law_terms.back().field = -1;
  EXPECT_FALSE(validate(plan, 2).empty());
  plan.problem.law_terms.back().field = field_of_u(1);
  plan.problem.time.is_static = true;
  EXPECT_FALSE(validate(plan, 2).empty());
}

} // namespace
} // namespace hvi::solver
