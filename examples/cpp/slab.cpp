// The viscoelastic slab on a softening layer, solved through hvi_solver alone (no script).
// Expected at n = 16, N = 64: u_y -0.026611454116, u_x 0.052631248258, strain 0.062880782102,
// reaction 3.6802143919 (independent: FreeFEM, GetDP and GetFEM agree).
#include "solver/plan/tensor_form.hpp"
#include "solver/time/run.hpp"

#include <fmt/format.h>

using namespace hvi::solver;

int main() {
  const int n = 16, steps = 64;
  const Expr t = Expr::variable(slot::t), lag = Expr::variable(slot::lag);
  const Expr r = Expr::variable(slot::argument(0)), nx = Expr::variable(slot::normal(0)),
             ny = Expr::variable(slot::normal(1)),
             u_y = Expr::variable(slot::field(field_of_u(0), 1));
  const Expr xi = Expr::variable(slot::multiplier(0, 0));
  const Expr soft = select(less(r, 0.08), 2 - 15 * (r - 0.02), 1.1);
  const Expr slope = select(less(r, 0), 0, select(less(r, 0.02), 100 * r, soft));
  const double lambda = 70 * 0.3 / (1.3 * 0.4), mu = 70 / 2.6;
  enum { slab, roof, flank, ground };
  Plan plan;
  plan.problem.mesh = {.name = "slab", .high = {2, 1, 0}, .cells = {2 * n, n, 1}};
  plan.problem.parts = {{"slab", {}, {.kind = RegionSpec::Kind::all_cells}},
                        {"roof", {}, {.kind = RegionSpec::Kind::group, .name = "top"}},
                        {"flank", {}, {.kind = RegionSpec::Kind::group, .name = "right"}},
                        {"ground", {}, {.kind = RegionSpec::Kind::group, .name = "bottom"}}};
  plan.problem.space.dirichlet = {{.part = roof}};
  constexpr auto isotropic = TensorSpec::Kind::isotropic; // lambda and mu
  plan.problem.tensors = {{"A", {}, isotropic, {5.0, 10.0}}, {"B", {}, isotropic, {lambda, mu}}};
  plan.problem.forms = {tensor_form(plan.problem, 2, field_of_u(1), {0}),
                        tensor_form(plan.problem, 2, field_of_u(0), {1}),
                        tensor_form(plan.problem, 2, field_of_memory(0), {1, -1.0})};
  plan.problem.histories = {{.kernel = {.name = "C", .expression = exp(-lag / 0.5)}}};
  plan.problem.laws = {{.name = "layer", .by_slope = true, .expression = slope}};
  plan.problem.law_terms = {
      {.name = "layer", .law = 0, .part = ground, .rows = {{.u = {nx, ny, 0.0}}}}};
  plan.problem.loads = {{.part = slab, .entries = {{slot::value(1), -10 * t}}},
                        {.part = flank, .entries = {{slot::value(0), 3 * t}}}};
  plan.problem.time.is_static = false;
  for (int i = 0; i <= steps; ++i) plan.problem.time.grid.push_back(i / double(steps));
  plan.report.probes = {
      {.name = "u_y", .expression = u_y, .point = {1, 0, 0}},
      {.name = "u_x",
       .expression = Expr::variable(slot::field(field_of_u(0), 0)),
       .point = {2, 0, 0}},
      {.name = "strain", .kind = Probe::Kind::norm_v},
      {.name = "reaction", .kind = Probe::Kind::integral, .expression = xi, .part = ground}};

  Discretisation discretisation;
  for (const auto& mistake : discretise(plan, discretisation)) throw mistake;
  const auto result = run(plan, discretisation, {});
  for (const auto& [name, value] : result.final) fmt::print("{} = {:.12g}\n", name, value);
  fmt::print("certified {}\n", result.certificate.certified);
}
