// The choice between a factor and iterations, and the size of a factor that it is made by, against
// the analysis of the matrices, which knows that size exactly.
#include "solver/formulation/solver_choice.hpp"
#include "solver/linear/factorisation.hpp"
#include "tests/solver/time/plans.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace hvi::solver {
namespace {

using namespace testing_plans;

/// The estimated entries of the factor by those that an analysis counts.
double estimate_by_analysis(const Plan& plan) {
  Discretisation d;
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  const StateLayout layout = make_layout(d.space, d.dofs);
  const Operators operators = assemble_operators(plan.problem, d, layout, 1);
  const Contact contact = make_contact(plan.problem, d, layout);
  const StepSizes sizes = sizes_of_steps(plan, d, layout, operators, contact);
  const SparseMatrix k = combine(operators, Vector::Ones(operators.n_bases()));
  EXPECT_EQ(sizes.unknowns, k.rows());
  EXPECT_EQ(sizes.entries, static_cast<double>(k.nonZeros()));
  EXPECT_EQ(sizes.contact, static_cast<double>(contact.unknowns.size()));
  return sizes.factor.nonzeros / analyse(k, contact.unknowns, true)->statistics().nonzeros;
}

Plan with_cells(Plan plan, std::array<double, 3> size, std::array<int, 3> cells, int order = 1) {
  plan.problem.mesh.high = size;
  plan.problem.mesh.cells = cells;
  plan.problem.space.order = order;
  plan.report = {};
  return plan;
}

TEST(FactorEstimate, IsWithinAFactorOfTwoWhateverTheShape) {
  const auto check = [](const char* what, const Plan& plan) {
    const double ratio = estimate_by_analysis(plan);
    EXPECT_GT(ratio, 0.5) << what;
    EXPECT_LT(ratio, 2.0) << what;
  };
  check("plane", with_cells(slab(4, 2), {2, 1, 0}, {40, 20, 1}));
  check("plane, P2", with_cells(slab(4, 2), {2, 1, 0}, {20, 10, 1}, 2));
  check("strip", with_cells(slab(4, 2), {50, 1, 0}, {200, 4, 1}));
  check("cube", with_cells(slab(4, 2, 3), {1, 1, 1}, {9, 9, 9}));
  check("cube, P2", with_cells(slab(4, 2, 3), {1, 1, 1}, {4, 4, 4}, 2));
  check("bar", with_cells(slab(4, 2, 3), {20, 1, 1}, {60, 3, 3}));
  check("plate", with_cells(slab(4, 2, 3), {1, 0.1, 1}, {20, 2, 20}));
  check("cube, friction", with_cells(slab(4, 2, 3, true), {1, 1, 1}, {9, 9, 9}));
}

const SolverCosts factor_is_faster{{3e9, 30.0}, {6e8, 40.0}};
const SolverCosts iterations_are_faster{{3e9, 30.0}, {6e8, 20.0}};
const MemoryRoom large{1e10, "this machine"}, small{1e9, "this machine"}, tiny{1e8, "this machine"};

ChosenSolver choice(LinearSolver asked, const SolverCosts& costs, const MemoryRoom& room,
                    const std::string& obstacle = "") {
  return choose_solver(asked, costs, obstacle, room);
}

TEST(SolverChoice, IsWhatWasAskedForWhateverItCosts) {
  for (const LinearSolver asked : {LinearSolver::direct, LinearSolver::iterative}) {
    const ChosenSolver chosen = choice(asked, iterations_are_faster, tiny, "an obstacle");
    EXPECT_EQ(chosen.solver, asked);
    EXPECT_EQ(chosen.why, "");
  }
}

TEST(SolverChoice, OfAScriptThatSaysNothingIsAFactorThatFits) {
  const auto asked = LinearSolver::direct_if_it_fits;
  EXPECT_EQ(SolverOptions().solver, asked);
  const ChosenSolver fits = choice(asked, iterations_are_faster, large);
  EXPECT_EQ(fits.solver, LinearSolver::direct);
  EXPECT_EQ(fits.why, "");
  const ChosenSolver does_not = choice(asked, factor_is_faster, small);
  EXPECT_EQ(does_not.solver, LinearSolver::iterative);
  EXPECT_EQ(does_not.why,
            "a factor takes 3 GB, more than this machine leaves; iterations take 600 MB");
}

TEST(SolverChoice, IsTheFasterOneOfThoseThatFit) {
  const auto asked = LinearSolver::automatic;
  EXPECT_EQ(choice(asked, factor_is_faster, large).solver, LinearSolver::direct);
  EXPECT_EQ(choice(asked, factor_is_faster, large).why,
            "a factor is predicted to take 3 GB and 30 s, iterations 600 MB and 40 s");
  EXPECT_EQ(choice(asked, iterations_are_faster, large).solver, LinearSolver::iterative);
  EXPECT_EQ(choice(asked, factor_is_faster, small).solver, LinearSolver::iterative);
  const SolverCosts factor_is_smaller{{3e8, 30.0}, {6e8, 20.0}};
  EXPECT_EQ(choice(asked, factor_is_smaller, {4e8, "a limit"}).solver, LinearSolver::direct);
}

TEST(SolverChoice, IsAFactorWhereIterationsCannotOrNothingFits) {
  for (const auto asked : {LinearSolver::direct_if_it_fits, LinearSolver::automatic}) {
    const ChosenSolver cannot = choice(asked, iterations_are_faster, small, "two unknowns");
    EXPECT_EQ(cannot.solver, LinearSolver::direct);
    EXPECT_EQ(cannot.why, "iterations cannot: two unknowns");
    const ChosenSolver neither = choice(asked, iterations_are_faster, tiny);
    EXPECT_EQ(neither.solver, LinearSolver::direct);
    EXPECT_NE(neither.why.find("neither"), std::string::npos);
  }
}

TEST(SolverChoice, AFactorInSinglePrecisionTakesHalfOfTheFactor) {
  StepSizes sizes;
  sizes.unknowns = 2e5, sizes.entries = 9e6, sizes.contact = 2e3;
  sizes.factor = {3e8, 1e12};
  const SolverCosts doubles = predicted_costs(sizes);
  sizes.singles = true;
  const SolverCosts singles = predicted_costs(sizes);
  EXPECT_NEAR(doubles.direct.bytes - singles.direct.bytes, 4.0 * 3e8, 1.0);
  EXPECT_GT(doubles.direct.seconds - singles.direct.seconds, 0.4 * doubles.direct.seconds);
  EXPECT_EQ(doubles.iterative.bytes, singles.iterative.bytes);
}

/// bench/slab3d.hvi by its sizes: a factor's work grows like unknowns^2, that of iterations like
/// unknowns.
TEST(SolverChoice, CostsCrossOnceAsBodiesGrow) {
  const auto costs = [](double unknowns) {
    StepSizes s;
    s.unknowns = unknowns, s.entries = 43 * unknowns, s.steps = 16, s.matrices = 2;
    s.factor = {0.06 * std::pow(unknowns, 4.0 / 3.0) * 300, 30 * unknowns * unknowns};
    return predicted_costs(s);
  };
  const SolverCosts few = costs(3e3), many = costs(3e6);
  EXPECT_LT(few.direct.seconds, few.iterative.seconds);
  EXPECT_GT(many.direct.seconds, many.iterative.seconds);
  EXPECT_GT(many.direct.bytes, 5 * many.iterative.bytes);
}

} // namespace
} // namespace hvi::solver
