// What cannot be computed is refused, with the plan item that is to blame.
#include "solver/results/trust.hpp"
#include "tests/solver/time/plans.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

namespace hvi::solver {
namespace {

using namespace testing_plans;
using testing::HasSubstr;

std::vector<Failure> mistakes(const Plan& plan) {
  Discretisation d;
  return discretise(plan, d);
}

Failure failure_of(const Plan& plan, const RunSettings& settings = {},
                   RunResult* partial = nullptr) {
  Discretisation d;
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  try {
    run(plan, d, settings, partial);
  } catch (const Failure& failure) {
    return failure;
  }
  ADD_FAILURE() << "the run went through";
  return Failure(FailureKind::output, {}, "");
}

TEST(Discretise, SeveralMistakesAtOnce) {
  auto plan = slab(4, 4);
  plan.problem.parts.push_back(group("a", "nowhere"));
  plan.problem.parts.push_back(group("b", "elsewhere"));
  plan.problem.parts[4].origin = {7};
  plan.problem.time.grid = {0, 1, 1};
  const auto found = mistakes(plan);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0].kind, FailureKind::bad_value);
  EXPECT_EQ(found[1].kind, FailureKind::unknown_group);
  EXPECT_EQ(found[2].kind, FailureKind::unknown_group);
}

TEST(Discretise, ALawOnAClampedFacetIsRefusedASharedNodeIsNot) {
  auto plan = slab(4, 4);
  plan.problem.space.dirichlet.push_back(clamp(flank)); // shares a node with the ground
  plan.problem.loads.pop_back();
  EXPECT_TRUE(mistakes(plan).empty());
  plan.problem.space.dirichlet.push_back(clamp(ground));
  const auto found = mistakes(plan);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].kind, FailureKind::overlapping_regions);
  EXPECT_EQ(found[0].origin, plan.problem.law_terms[0].origin);
  EXPECT_THAT(found[0].what(), HasSubstr("`ground`"));
}

TEST(Discretise, ALawTwiceOnAPart) {
  auto plan = slab(4, 4);
  plan.problem.law_terms.push_back(plan.problem.law_terms[0]);
  const auto found = mistakes(plan);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].kind, FailureKind::overlapping_regions);
}

TEST(Discretise, InitialStateAgainstImposedValues) {
  auto plan = slab(4, 4);
  plan.problem.time.initial = {1.0, 0.0};
  const auto found = mistakes(plan);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].kind, FailureKind::bad_value);
  plan.problem.time.initial = {1.0 - var(slot::x(1)), 0.0};
  EXPECT_TRUE(mistakes(plan).empty());
}

TEST(Discretise, PointsAndTimesOfProbes) {
  auto plan = slab(4, 4);
  plan.report.probes[0].point = {3, 0, 0};
  plan.report.probes[1].time = 1.5;
  EXPECT_EQ(mistakes(plan).size(), 2u);
}

TEST(Coercivity, RigidMotionsAreNamed) {
  auto plan = slab(4, 4);
  plan.problem.space.dirichlet = {clamp(roof, 1)}; // free along x
  auto failure = failure_of(plan);
  EXPECT_EQ(failure.kind, FailureKind::not_coercive);
  EXPECT_THAT(failure.what(),
              HasSubstr("neither values nor forms nor laws: the body moves along x"));
  plan.problem.law_terms.clear();
  plan.report = {};
  failure = failure_of(plan);
  EXPECT_THAT(failure.what(), HasSubstr("the body moves along x"));
  plan.problem.space.dirichlet.clear();
  failure = failure_of(plan);
  EXPECT_EQ(failure.kind, FailureKind::not_coercive);
  EXPECT_THAT(failure.what(), HasSubstr("the body turns about ("));
  EXPECT_THAT(failure.what(), HasSubstr("the body moves along y"));
  PartSpec corner{"corner", {}, {}};
  corner.region.kind = RegionSpec::Kind::point;
  corner.region.point = {0, 1, 0};
  plan.problem.parts.push_back(corner);
  plan.problem.space.dirichlet = {clamp(4)}; // turns about its corner
  failure = failure_of(plan);
  EXPECT_EQ(failure.kind, FailureKind::not_coercive);
  EXPECT_THAT(failure.what(), HasSubstr("the body turns about (0, 1)"));
}

/// More pieces than are asked one by one, of which the first alone is held.
TEST(Coercivity, MotionsOfManyPiecesAreToldTogether) {
  auto plan = slab(1, 4);
  MeshSpec piece = std::exchange(plan.problem.mesh, {});
  piece.cells = {1, 1, 1};
  plan.problem.mesh.kind = MeshSpec::Kind::pieces;
  for (int i = 0; i < 62; ++i) {
    piece.name = "p" + std::to_string(i);
    piece.low[0] = 3.0 * i, piece.high[0] = piece.low[0] + 2.0;
    plan.problem.mesh.pieces.push_back(piece);
  }
  plan.problem.parts = {all_cells("all"), group("roof", "p0.top")};
  plan.problem.forms = {elastic(2, body, field_of_u(0), from_young(70, 0.3))};
  plan.problem.histories.clear();
  plan.problem.laws.clear(), plan.problem.law_terms.clear();
  plan.problem.loads = {force(body, {Expr(0.0), Expr(-1.0)})};
  plan.report = {};
  const auto failure = failure_of(plan);
  EXPECT_EQ(failure.kind, FailureKind::not_coercive);
  EXPECT_THAT(failure.what(), HasSubstr("leave a motion free that strains no cell"));
}

TEST(Coercivity, NegativeStiffnessIsRefused) {
  auto plan = slab(4, 4);
  plan.problem.forms = {elastic(2, body, field_of_u(0), {1, 1}, -1.0)};
  plan.problem.histories.clear();
  EXPECT_EQ(failure_of(plan).kind, FailureKind::not_coercive);
}

TEST(Coercivity, AMemoryThatTakesMoreThanTheBodyHasIsNoMistakeOfTheForms) {
  auto plan = slab(4, 4);
  plan.problem.forms.back() = elastic(2, body, field_of_memory(0), {1, 1}, -1e4);
  const auto failure = failure_of(plan);
  EXPECT_EQ(failure.kind, FailureKind::not_coercive);
  EXPECT_THAT(failure.what(), HasSubstr("step 1"));
  EXPECT_THAT(failure.what(), HasSubstr("memory's kernel"));
}

TEST(Coercivity, AMatrixThatRoundingMadeSingularIsNoMistakeOfTheScript) {
  auto plan = slab(4, 4);
  plan.problem.forms = {elastic(2, body, field_of_u(0), from_young(70, 0.3))};
  plan.problem.histories.clear();
  plan.problem.space.dirichlet = {clamp(flank)};
  plan.problem.loads.pop_back();
  plan.problem.mesh.high = {1e6, 1, 0};
  const auto failure = failure_of(plan);
  EXPECT_EQ(failure.kind, FailureKind::mostly_rounding);
}

/// The kind of what a result of this sort is refused with.
std::optional<FailureKind> refused(const RunResult& result, const Plan& plan) {
  try {
    refuse_rounding(result, plan.problem);
    return std::nullopt;
  } catch (const Failure& failure) {
    return failure.kind;
  }
}

TEST(Rounding, WorkThatIsNotTheEnergiesIsNoResult) {
  const auto plan = slab(4, 4);
  RunSettings settings;
  settings.monitors = true;
  auto result = solve(plan, settings);
  refuse_rounding(result, plan.problem);
  result.monitors->balance_error = 1e-5;
  EXPECT_EQ(refused(result, plan), FailureKind::mostly_rounding);
  result.monitors->balance_error = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refused(result, plan), FailureKind::mostly_rounding);
}

TEST(Rounding, AColumnThatIsMostlyRoundingIsNoResult) {
  const auto plan = slab(4, 4);
  auto result = solve(plan);
  refuse_rounding(result, plan.problem);
  result.forward_error.columns[1].relative = 0.02;
  EXPECT_EQ(refused(result, plan), FailureKind::mostly_rounding);
  result.forward_error.columns[1].relative = 0.0;
  result.forward_error.solution = 0.02;
  EXPECT_EQ(refused(result, plan), FailureKind::mostly_rounding);
}

/// The sawtooth-like law with a cliff the body cannot follow: no stable solution near the last one.
Plan hopeless() {
  auto plan = slab(4, 8);
  const Expr r = var(slot::argument(0));
  // Softens faster than the whole body is stiff: the step's problem has no minimum.
  plan.problem.laws[0].expression = select(less(r, 0.004), 100.0 * r, 0.4 - 1e7 * (r - 0.004));
  return plan;
}

TEST(Certificate, WithoutOneTheRunStopsAndKeepsTheLastGoodState) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "hvi_not_certified";
  std::filesystem::remove_all(folder);
  RunSettings settings;
  settings.output_folder = folder.string();
  RunResult partial;
  const auto plan = hopeless();
  const auto failure = failure_of(plan, settings, &partial);
  EXPECT_EQ(failure.kind, FailureKind::not_certified);
  EXPECT_EQ(failure.origin, plan.problem.law_terms[0].origin);
  EXPECT_THAT(failure.what(), HasSubstr("step " + std::to_string(partial.steps + 1)));
  EXPECT_FALSE(partial.certificate.certified);
  ASSERT_GT(partial.steps, 0);
  EXPECT_EQ(partial.times.size(), static_cast<std::size_t>(partial.steps));
  EXPECT_GT(partial.u.norm(), 0.0);
  EXPECT_TRUE(std::filesystem::exists(folder / "result.csv"));
}

TEST(Certificate, InterruptedRunsKeepTheirState) {
  std::atomic<bool> stop = false;
  RunSettings settings;
  settings.stop = &stop;
  settings.on_step = [&](int n, double, const Vector&, const Vector&) { stop = n == 3; };
  RunResult partial;
  EXPECT_EQ(failure_of(slab(4, 8), settings, &partial).kind, FailureKind::interrupted);
  EXPECT_EQ(partial.steps, 3);
}

/// The start is told after the look at the flag before step 1.
TEST(Certificate, RunsAreInterruptedInTheMiddleOfAStep) {
  std::atomic<bool> stop = false;
  RunSettings settings;
  settings.stop = &stop;
  settings.on_start = [&](double, const Vector&) { stop = true; };
  RunResult partial;
  const auto failure = failure_of(slab(4, 8), settings, &partial);
  EXPECT_EQ(failure.kind, FailureKind::interrupted);
  EXPECT_STREQ(failure.what(), "interrupted before step 1");
  EXPECT_EQ(partial.steps, 0);
}

// The work is not thrown away: the result says what is not on the disk.
TEST(Output, AFolderThatCannotBeMadeIsToldWithTheResult) {
  const auto file = std::filesystem::path(testing::TempDir()) / "hvi_a_file";
  std::ofstream(file) << "x";
  RunSettings settings;
  settings.output_folder = (file / "below").string();
  std::string told;
  settings.warn = [&](const std::string& what) { told += what; };
  const auto result = solve(slab(4, 4), settings);
  EXPECT_TRUE(result.certificate.certified);
  ASSERT_TRUE(result.unwritten);
  EXPECT_NE(std::string(result.unwritten->what()).find("hvi_a_file"), std::string::npos)
      << result.unwritten->what();
  EXPECT_NE(told.find("hvi_a_file"), std::string::npos) << told;
}

} // namespace
} // namespace hvi::solver
