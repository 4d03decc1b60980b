// The printed plan: every item of the plan shows, and the text is stable.
#include "solver/plan/plan.hpp"

#include <gmock/gmock.h>

namespace hvi::solver {
namespace {

using testing::HasSubstr;

Plan small_plan() {
  Plan plan;
  plan.problem.title = "bar";
  plan.problem.mesh.kind = MeshSpec::Kind::interval;
  plan.problem.mesh.name = "bar";
  PartSpec end{"end", {}, {}};
  end.region.kind = RegionSpec::Kind::group;
  end.region.name = "right";
  plan.problem.parts = {{"bar", {}, {}}, end};
  plan.problem.space.name = "V";
  plan.problem.space.dirichlet = {{{}, 1, -1, {}}};
  FormTerm form;
  form.effect = Effect::elasticity;
  form.entries = {{3, 3, 2.5}};
  plan.problem.forms = {form};
  LoadTerm load;
  load.entries = {{0, 2.0 * Expr::variable(slot::t)}};
  plan.problem.loads = {load};
  return plan;
}

TEST(PrintPlan, ReadsAsThePlan) {
  EXPECT_EQ(to_string(small_plan()),
            "plan `bar`\n"
            "mesh `bar` interval low [0, 0, 0] high [1, 1, 1] cells [1, 1, 1]\n"
            "part 0 `bar` = all\n"
            "part 1 `end` = group \"right\"\n"
            "space `V` vector P1\n"
            "  on `end` all components = 0\n"
            "form elasticity over `bar` on u, rule exact\n"
            "  2.5 du.x/dx * dv.x/dx\n"
            "load body force over `bar`, rule exact\n"
            "  " +
                to_string(2.0 * Expr::variable(slot::t)) +
                " * v.x\n"
                "static\n"
                "options tolerance 1e-10, memory 1e-08 (route automatic), branch continuing, "
                "solver direct if it fits, threads 1\n");
}

TEST(PrintPlan, SeveralUnknowns) {
  auto plan = small_plan();
  const auto second = [](int derivative) { return slot::of_unknown(1, derivative); };
  plan.problem.forms[0].entries = {{second(slot::gradient(0, 1)), slot::value(1), 2.5},
                                   {slot::of_unknown(2, slot::hoop), second(slot::value(0)), 3.0}};
  plan.problem.loads[0].entries = {{second(slot::gradient(0, 2)), 1.0}};
  const std::string text = to_string(plan);
  EXPECT_THAT(text, HasSubstr("  2.5 u.y * dv[1].x/dy\n"));
  EXPECT_THAT(text, HasSubstr("  3 u[1].x * dv[2].z/dz\n"));
  EXPECT_THAT(text, HasSubstr("  1 * dv[1].x/dz\n"));
}

TEST(PrintPlan, LawsMemoryTimeAndReport) {
  auto plan = small_plan();
  plan.problem.histories = {{{}, {"C", {}, exp(-Expr::variable(slot::lag))}}};
  plan.problem.laws = {{"layer", {}, true, true, Expr::variable(slot::argument(0))}};
  LawTerm term;
  term.name = "layer";
  term.part = 1;
  term.rows.resize(1);
  plan.problem.law_terms = {term};
  plan.problem.time.is_static = false;
  plan.problem.time.scheme = Scheme::bdf2;
  for (int n = 0; n <= 20; ++n) plan.problem.time.grid.push_back(n);
  Probe norm;
  norm.name = "size";
  norm.kind = Probe::Kind::norm_v;
  norm.time = 0.5;
  plan.report.probes = {norm};
  plan.report.tables = {{{}, {0}, 4, false, "t.csv"}};
  plan.problem.effects = {{"memory", EffectNote::State::dropped, {}, "the kernel is zero"}};
  const auto text = to_string(plan);
  for (const char* line :
       {"history w0 kernel `C`", "law 0 `layer` radial slope", "law term 0 1 * `layer` over `end`",
        "time bdf2", "grid 0 ... 20, 20 steps", "probe 0 `size` = norm of u at t = 0.5",
        "table [0] every 4 to \"t.csv\"", "effect memory: dropped (the kernel is zero)"})
    EXPECT_THAT(text, HasSubstr(line));
}

TEST(PrintPlan, ASeriesShowsBelowItsKernel) {
  auto plan = small_plan();
  const PronySeries series{0.5, {1.0, 2.0}, {3.0, 4.0}};
  plan.problem.histories = {{{}, {"C", {}, expression(series, Expr::variable(slot::lag)), series}}};
  EXPECT_THAT(to_string(plan),
              HasSubstr("\n  Prony series: constant 0.5, weights [1, 2], times [3, 4]\n"));
}

} // namespace
} // namespace hvi::solver
