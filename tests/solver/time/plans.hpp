// Plans for the tests of the run: written by hand, as a C++ user would.
#pragma once

#include "solver/assembly/assembly.hpp"
#include "solver/time/run.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace hvi::solver::testing_plans {

inline Expr var(Slot s) { return Expr::variable(s); }
inline Expr u_value(int i) { return var(slot::field(field_of_u(0), slot::value(i))); }

struct Lame {
  double lambda, mu;
};
inline Lame from_young(double young, double poisson) {
  return {young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))};
}

/// scale (lambda tr eps(field) tr eps(v) + 2 mu eps(field) : eps(v)) on a part.
inline FormTerm elastic(int dim, int part, int field, Lame m, double scale = 1.0) {
  FormTerm form;
  form.part = part;
  form.field = field;
  for (int i = 0; i < dim; ++i)
    for (int j = 0; j < dim; ++j) {
      const auto d = [](int a, int b) { return slot::gradient(a, b); };
      form.entries.push_back({d(i, i), d(j, j), scale * m.lambda});
      form.entries.push_back({d(i, j), d(i, j), scale * m.mu});
      form.entries.push_back({d(i, j), d(j, i), scale * m.mu});
    }
  return form;
}

/// scale grad(field) . grad(v), scalar.
inline FormTerm diffusion(int dim, int part, int field, Expr scale = 1.0) {
  FormTerm form;
  form.part = part;
  form.field = field;
  for (int j = 0; j < dim; ++j)
    form.entries.push_back({slot::gradient(0, j), slot::gradient(0, j), scale});
  return form;
}

inline LoadTerm force(int part, std::vector<Expr> components) {
  LoadTerm load;
  load.part = part;
  for (int i = 0; i < static_cast<int>(components.size()); ++i)
    load.entries.push_back({slot::value(i), components[i]});
  return load;
}

inline PartSpec all_cells(std::string name) { return {std::move(name), {}, {}}; }
inline PartSpec group(std::string name, std::string of) {
  PartSpec part{std::move(name), {}, {}};
  part.region.kind = RegionSpec::Kind::group;
  part.region.name = std::move(of);
  return part;
}
inline DirichletSpec clamp(int part, int component = -1, std::vector<Expr> value = {}) {
  return {{}, part, component, std::move(value)};
}

inline std::vector<double> uniform_grid(double end, int steps) {
  std::vector<double> out;
  for (int n = 0; n <= steps; ++n) out.push_back(end * n / steps);
  return out;
}

inline Probe at_point(std::string name, Expr e, Point p) {
  Probe probe;
  probe.name = std::move(name);
  probe.expression = std::move(e);
  probe.point = p;
  return probe;
}
inline Probe integral(std::string name, Expr e, int part) {
  Probe probe;
  probe.name = std::move(name);
  probe.kind = Probe::Kind::integral;
  probe.expression = std::move(e);
  probe.part = part;
  return probe;
}
inline Probe norm(std::string name) {
  Probe probe;
  probe.name = std::move(name);
  probe.kind = Probe::Kind::norm_v;
  return probe;
}

/// The argument sign u . nu of a law.
inline LawTerm normal_term(int law, int part, int dim = 2, double sign = 1.0) {
  LawTerm term;
  term.origin = {100 + law};
  term.name = "layer";
  term.law = law;
  term.part = part;
  LawTerm::Row row;
  for (int i = 0; i < dim; ++i) row.u[i] = sign * var(slot::normal(i));
  term.rows = {row};
  return term;
}

/// The tangential part u - (u . nu) nu, a row per component.
inline LawTerm tangential_term(int law, int part, int dim) {
  LawTerm term;
  term.origin = {100 + law};
  term.name = "slip";
  term.law = law;
  term.part = part;
  term.effect = Effect::friction;
  for (int i = 0; i < dim; ++i) {
    LawTerm::Row row;
    for (int j = 0; j < dim; ++j)
      row.u[j] = Expr(i == j ? 1.0 : 0.0) - var(slot::normal(i)) * var(slot::normal(j));
    term.rows.push_back(row);
  }
  return term;
}

/// The slab's normal law: 100 r up to .02, softening to .08, constant beyond.
inline LawSpec softening_layer() {
  const Expr r = var(slot::argument(0));
  LawSpec law;
  law.name = "layer";
  law.by_slope = true;
  law.expression =
      select(less(r, 0.0), 0.0,
             select(less(r, 0.02), 100.0 * r, select(less(r, 0.08), 2.0 - 15.0 * (r - 0.02), 1.1)));
  return law;
}

/// Friction whose bound falls with the slip: slope .5 + .2 exp(-20 |xi|).
inline LawSpec slip_weakening() {
  LawSpec law;
  law.name = "slip";
  law.radial = true;
  law.by_slope = true;
  law.expression = Expr(0.5) + 0.2 * exp(-20.0 * var(slot::argument(0)));
  return law;
}

inline KernelSpec exponential_kernel(double tau) {
  return {"C", {}, exp(-var(slot::lag) / Expr(tau))};
}

enum SlabPart { body, roof, flank, ground };

/// The slab of the reference cases in 2D or 3D (cells across the height n, steps N).
inline Plan slab(int n, int steps, int dim = 2, bool friction = false) {
  Plan plan;
  plan.problem.mesh.kind = dim == 2 ? MeshSpec::Kind::rectangle : MeshSpec::Kind::box;
  plan.problem.mesh.high = {2, 1, dim == 3 ? 1.0 : 0.0};
  plan.problem.mesh.cells = {2 * n, n, n};
  plan.problem.parts = {all_cells("slab"), group("roof", "top"), group("flank", "right"),
                        group("ground", "bottom")};
  plan.problem.space.dirichlet = {clamp(roof)};
  const auto b = from_young(70, 0.3);
  plan.problem.forms = {elastic(dim, body, field_of_u(1), {5, 10}),
                        elastic(dim, body, field_of_u(0), b),
                        elastic(dim, body, field_of_memory(0), b, -1.0)};
  plan.problem.histories = {{{}, exponential_kernel(0.5)}};
  plan.problem.laws = {softening_layer()};
  plan.problem.law_terms = {normal_term(0, ground, dim)};
  if (friction) {
    plan.problem.laws.push_back(slip_weakening());
    plan.problem.law_terms.push_back(tangential_term(1, ground, dim));
  }
  const Expr t = var(slot::t);
  plan.problem.loads = {force(body, {0.0, -10.0 * t}), force(flank, {3.0 * t})};
  plan.problem.time.is_static = false;
  plan.problem.time.grid = uniform_grid(1.0, steps);
  const double z = dim == 3 ? 0.5 : 0.0;
  plan.report.probes = {at_point("u_y", u_value(1), {1, 0, z}),
                        at_point("u_x", u_value(0), {2, 0, z}), norm("strain"),
                        integral("reaction", var(slot::multiplier(0, 0)), ground)};
  plan.report.tables = {{{}, {0, 1, 2, 3}, 1, false, ""}};
  return plan;
}

/// Two blocks, or rings, whose meshes do not match: the slab's laws, with friction, between them.
inline Plan two_blocks(int n, int steps, int dim, bool rings = false) {
  Plan plan = slab(n, steps, dim, true);
  Problem& problem = plan.problem;
  MeshSpec upper = std::exchange(problem.mesh, {});
  upper.axisymmetric = rings;
  MeshSpec lower = upper;
  upper.name = "upper", lower.name = "lower";
  lower.low[1] = -1, lower.high[1] = 0;
  lower.cells[0] += 1;
  problem.mesh.kind = MeshSpec::Kind::pieces;
  problem.mesh.axisymmetric = rings;
  problem.mesh.pieces = {upper, lower};
  RegionSpec seam;
  seam.kind = RegionSpec::Kind::pair;
  seam.children = {group("", "upper.bottom").region, group("", "lower.top").region};
  problem.parts = {all_cells("both"),
                   group("roof", "upper.top"),
                   group("flank", "upper.right"),
                   {"seam", {}, seam},
                   group("base", "lower.bottom")};
  problem.space.dirichlet.push_back(clamp(4));
  return plan;
}

/// Discretises and runs; mistakes of the plan fail the test.
inline RunResult solve(const Plan& plan, const RunSettings& settings = {}) {
  Discretisation d;
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  return run(plan, d, settings);
}

/// The sum of the forms on a field, on all dofs.
inline SparseMatrix matrix_of(const Problem& problem, const Discretisation& d, int field) {
  SparseMatrix out(d.space.n_dofs(), d.space.n_dofs());
  for (const auto& form : problem.forms)
    if (form.field == field)
      out = SparseMatrix(out + assemble_form(d.space, d.parts[form.part], form));
  return out;
}

inline void expect_relative(double value, double reference, double tolerance,
                            const std::string& what) {
  EXPECT_LE(std::abs(value - reference), tolerance * std::abs(reference))
      << what << ": " << value << " instead of " << reference;
}

} // namespace hvi::solver::testing_plans
