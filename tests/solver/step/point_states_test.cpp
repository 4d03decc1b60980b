// The equations of states at points against their definition, at values and inputs set by hand.
#include "solver/step/run_state.hpp"
#include "tests/solver/time/plans.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace hvi::solver {
namespace {

using namespace testing_plans;

/// A slab whose ground has states, at the beginning of the first step, of length k.
struct AtThePoints {
  static constexpr int steps = 4;
  static constexpr double k = 1.0 / steps;
  Plan plan = slab(3, steps);
  Discretisation d;
  std::optional<RunState> run;

  explicit AtThePoints(std::vector<StateTerm> states) {
    plan.problem.states = std::move(states);
    for (const auto& mistake : discretise(plan, d)) throw mistake;
    run.emplace(plan, d);
    run->evolution.start();
    EXPECT_FALSE(run->evolution.begin_step(1));
    of().start();
    of().begin(1);
  }
  PointStates& of() { return run->solver.equations.laws.states; }
  Contact& contact() { return run->formulation->contact(); }
  Vector& values() { return contact().state_values; }
  int points() { return contact().state_groups.front().n_points; }
};

const Expr opening = var(slot::field(field_of_u(0), slot::value(1)));

/// |z - P(z_0 + k g)| / (max(1, k |dg/dz|) size): the worst of all points, wherever that is. The
/// size is the largest of all values.
TEST(PointStates, TheErrorIsThatOfTheWorstPoint) {
  constexpr double a = 9.0, start = 0.4, high = 0.9; // a k > 1: steep
  AtThePoints at({{{}, "bond", ground, a * (opening - var(slot::state(0))), start, 0.0, high}});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  StateInputs inputs{Vector::Zero(at.of().n_inputs()), Vector::Zero(at.of().n_inputs())};
  ASSERT_EQ(inputs.values.size(), at.points());
  for (int worst = 0; worst < at.points(); ++worst) {
    double expected = 0.0, size = start;
    for (int p = 0; p < at.points(); ++p) {
      const double input = 2.0 * unit(random);
      const double exact = std::min((start + at.k * a * input) / (1.0 + at.k * a), high);
      inputs.values[p] = input;
      const double z = exact - (p == worst ? 0.1 : 0.001) * unit(random) * exact;
      at.values()[p] = z;
      const double moved = start + at.k * a * (input - z);
      expected = std::max(expected, std::abs(z - std::clamp(moved, 0.0, high)));
      size = std::max(size, z);
    }
    EXPECT_NEAR(at.of().error(inputs).worst, expected / (at.k * a) / size, 1e-14) << worst;
  }
}

/// What scales of inputs make of a state that is zero: by the slope of its rate, or where that is
/// flat before a threshold by the rate one scale away.
TEST(PointStates, SizesAreWhatScalesOfInputsMake) {
  constexpr double a = 3.0, rest = 1e-7;
  const auto error_with = [&](const Expr& rate, double input, double scale) {
    AtThePoints at({{{}, "wear", ground, rate, 0.0, -1.0, 1.0}});
    StateInputs inputs{Vector::Constant(at.points(), input), Vector::Constant(at.points(), scale)};
    at.values().setConstant(rest);
    return at.of().error(inputs).worst;
  };
  const double k = AtThePoints::k;
  const auto off = [&](double rate, double size) {
    return std::abs(rest - k * rate) / std::max(size, rest);
  };
  EXPECT_NEAR(error_with(a * opening, 0.0, 1e-3), off(0.0, k * a * 1e-3), 1e-12);
  EXPECT_NEAR(error_with(a * opening, 1e-6, 1e-3), off(a * 1e-6, k * a * 1e-3), 1e-12);
  const Expr threshold = a * max(opening - 1.0, 0.0);
  EXPECT_NEAR(error_with(threshold, 0.999, 3e-3), off(0.0, k * a * 2e-3), 1e-10);
  EXPECT_NEAR(error_with(threshold, 0.999, 5e-4), 1.0, 1e-12); // as far as the threshold nothing
  EXPECT_NEAR(error_with(a * opening * opening, 0.0, 1e-2), off(0.0, k * a * 1e-4), 1e-10);
}

/// A rate that is a number needs no solution, and keeps to its range all the same.
TEST(PointStates, WhatOnlyTimeMovesStaysInItsRange) {
  AtThePoints at({{{}, "up", ground, Expr(2.0), 0.1, 0.0, 0.35},
                  {{}, "down", ground, Expr(-2.0), 0.1, 0.05, 1.0},
                  {{}, "free", ground, Expr(-2.0), 0.1}});
  for (int p = 0; p < at.points(); ++p) {
    EXPECT_EQ(at.values()[p], 0.35);
    EXPECT_EQ(at.values()[at.points() + p], 0.05);
    EXPECT_NEAR(at.values()[2 * at.points() + p], 0.1 - 2.0 * at.k, 1e-15);
  }
}

/// Entries of one load have the size of the largest: what the others hold is rounding of it. Those
/// of two loads have their own.
TEST(PointStates, EntriesOfALoadShareTheirSize) {
  const auto error_of = [](const std::string& second) {
    const auto stretch = [](int i) {
      return var(slot::field(field_of_u(0), slot::gradient(i, i)));
    };
    std::vector<StateTerm> states{{{}, "stress", body, 5.0 * stretch(0), 0.0},
                                  {{}, second, body, 5.0 * stretch(1), 0.0}};
    for (StateTerm& state : states) state.algebraic = true;
    AtThePoints at(std::move(states));
    const int n = at.points();
    StateInputs inputs{Vector::Zero(at.of().n_inputs()), Vector::Zero(at.of().n_inputs())};
    inputs.values.head(n).setOnes(); // strains along x
    at.values().head(n).setConstant(5.0);
    at.values().tail(n).setConstant(1e-12);
    return at.of().error(inputs).worst;
  };
  EXPECT_NEAR(error_of("stress"), 1e-12 / 5.0, 1e-14);
  EXPECT_NEAR(error_of("another"), 1.0, 1e-14);
}

/// A state begins inside its range at every point.
TEST(PointStates, BeginInsideTheirRange) {
  const Expr x = var(slot::x(0)); // from 0 to 2 on the ground
  const auto begin = [](const Expr& initial, double low, double high) {
    AtThePoints({{{}, "bond", ground, -opening, initial, low, high}});
  };
  EXPECT_NO_THROW(begin(x, 0.0, 2.0));
  EXPECT_THROW(begin(x, 0.0, 1.99), Failure);
  EXPECT_THROW(begin(x, 0.01, 2.0), Failure);
}

} // namespace
} // namespace hvi::solver
