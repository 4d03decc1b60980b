// The cases with numbers of other programs: slab (FreeFEM, GetDP, GetFEM), block and strip
// (published).
#include "tests/solver/time/plans.hpp"

namespace hvi::solver {
namespace {

using namespace testing_plans;

void expect_slab(const RunResult& result, double u_y, double u_x, double strain, double reaction) {
  expect_relative(result.final.at("u_y"), u_y, 1e-9, "u_y");
  expect_relative(result.final.at("u_x"), u_x, 1e-9, "u_x");
  expect_relative(result.final.at("strain"), strain, 1e-9, "strain");
  expect_relative(result.final.at("reaction"), reaction, 1e-9, "reaction");
  EXPECT_TRUE(result.certificate.certified);
  EXPECT_LE(result.certificate.equilibrium, 1e-10);
  EXPECT_LE(result.certificate.inclusion, 1e-10);
}

// Independent: three other programs agree to ten digits.
TEST(Slab, N16) {
  const auto result = solve(slab(16, 64));
  expect_slab(result, -0.026611454116, 0.052631248258, 0.062880782102, 3.6802143919);
  EXPECT_EQ(result.times.size(), 64u);
  EXPECT_EQ(result.work.factorisations, 1);
  EXPECT_EQ(result.work.matrices, 2); // A; B and its relaxation share one
}
TEST(Slab, N32) {
  expect_slab(solve(slab(32, 64)), -0.026611911811, 0.052931635790, 0.063035023988, 3.6810752795);
}
TEST(Slab, N32With256Steps) {
  expect_slab(solve(slab(32, 256)), -0.026465126013, 0.052615129917, 0.062700365613, 3.6840401869);
}

// Property: a tolerance that is asked for reaches the solver of every step; curved laws need one
// more Newton step for it.
TEST(Slab, SolvesToTheToleranceAskedFor) {
  int newton[2] = {};
  for (const bool fine : {false, true}) {
    auto plan = slab(4, 32, 2, true);
    // Curved, so that each Newton iteration only comes closer.
    plan.problem.laws[0].expression = 2.0 * (exp(50.0 * max(var(slot::argument(0)), 0.0)) - 1.0);
    plan.options.tolerance = fine ? 1e-13 : 1e-6;
    const auto result = solve(plan);
    EXPECT_TRUE(result.certificate.certified) << fine;
    EXPECT_LE(result.certificate.equilibrium, plan.options.tolerance);
    EXPECT_LE(result.certificate.inclusion, plan.options.tolerance);
    newton[fine] = result.work.newton;
  }
  EXPECT_LT(newton[0], newton[1]);
}

Plan block() {
  Plan plan;
  plan.problem.mesh.kind = MeshSpec::Kind::file;
  plan.problem.mesh.path = HVI_SOURCE_DIR "/tests/solver/time/cross_5x2.msh";
  plan.problem.parts = {group("body", "body"), group("left", "left"), group("bottom", "bottom")};
  plan.problem.space.dirichlet = {clamp(1)};
  plan.problem.forms = {elastic(2, 0, field_of_u(0), {4, 4})};
  LawSpec law;
  law.by_slope = true;
  law.expression = max(var(slot::argument(0)), 0.0);
  plan.problem.laws = {law};
  plan.problem.law_terms = {normal_term(0, 2)};
  plan.problem.law_terms[0].rule = Rule::midpoint;
  plan.problem.loads = {force(0, {-0.2, -0.2})};
  return plan;
}

// Published: regression data of the package conmech. Clamped left side and bottom share a node.
TEST(Block, MatchesThePublishedNodes) {
  auto plan = block();
  const double expected[][2] = {{.04843176, .04429129}, {.07642598, .08750102},
                                {.09064929, .13301396}, {.09615189, .17619656},
                                {.09566479, .21772099}, {.00962312, .22716041}};
  for (int i = 0; i < 6; ++i) {
    const Point p = i < 5 ? Point{0.5 * (i + 1), 0, 0} : Point{2.5, 1, 0};
    plan.report.probes.push_back(at_point("x" + std::to_string(i), u_value(0), p));
    plan.report.probes.push_back(at_point("y" + std::to_string(i), u_value(1), p));
  }
  const auto result = solve(plan);
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(-result.final.at("x" + std::to_string(i)), expected[i][0], 5e-9);
    EXPECT_NEAR(-result.final.at("y" + std::to_string(i)), expected[i][1], 5e-9);
  }
  EXPECT_TRUE(result.certificate.certified);
}

constexpr double scale = 4e-4;

LawSpec sawtooth() {
  const Expr r = var(slot::argument(0));
  const Expr s = scale;
  LawSpec law;
  law.name = "glue";
  law.expression =
      select(less(r, 0.0), 0.0,
             select(less(r, 5e-4), 30e9 * s * r * r,
                    select(less(r, 1e-3), 10e9 * s * r * r + 10e6 * scale * r,
                           select(less(r, 2e-3), 5e9 * s * r * r + 5e6 * scale * r + 4.0, 16.0))));
  return law;
}

Plan strip(int steps) {
  Plan plan;
  plan.problem.mesh.kind = MeshSpec::Kind::file;
  plan.problem.mesh.path = HVI_SOURCE_DIR "/tests/solver/time/zigzag_33x5.msh";
  plan.problem.parts = {group("body", "body"), group("left", "left"), group("bottom", "bottom"),
                        group("top", "top"), group("right", "right")};
  plan.problem.space.dirichlet = {clamp(1)};
  plan.problem.forms = {elastic(2, 0, field_of_u(0), from_young(1.378e11 * scale, 0.3))};
  plan.problem.laws = {sawtooth()};
  plan.problem.law_terms = {normal_term(0, 2, 2, -1.0)}; // r = u_y = -u . nu on the bottom
  plan.problem.law_terms[0].rule = Rule::midpoint;
  const Expr ramp = 26.2e6 * scale * var(slot::t);
  plan.problem.loads = {force(3, {0.0, ramp}),
                        force(4, {0.0, select(less(0.0099, var(slot::x(1))), ramp, 0.0)})};
  plan.problem.loads[0].rule = plan.problem.loads[1].rule = Rule::nodal;
  plan.problem.time.is_static = false;
  plan.problem.time.grid = uniform_grid(1.0, steps);
  plan.report.probes = {at_point("tip_x", u_value(0), {.08, 0, 0}),
                        at_point("tip_y", u_value(1), {.08, 0, 0})};
  return plan;
}

// Published (sawtooth benchmark): the bonded branch, which a ramped load reaches.
TEST(Strip, RampedLoadReachesTheBondedBranch) {
  for (const int steps : {4, 8}) {
    const auto result = solve(strip(steps));
    EXPECT_NEAR(result.final.at("tip_y"), .00099732, 1e-8) << steps << " steps";
    EXPECT_NEAR(result.final.at("tip_x"), .00006972, 1e-8) << steps << " steps";
    EXPECT_TRUE(result.certificate.certified);
  }
}

} // namespace
} // namespace hvi::solver
