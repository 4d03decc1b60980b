// The columns of --monitors against their formulas: every sum from the states alone, with the
// layer's closed form, the force of the memory from what equilibrium leaves for it.
#include "tests/solver/time/plans.hpp"

#include <algorithm>
#include <cmath>

namespace hvi::solver {
namespace {

using namespace testing_plans;

/// softening_layer(): its slope and its potential.
double slope(double r) {
  return r < 0 ? 0.0 : r < 0.02 ? 100 * r : r < 0.08 ? 2 - 15 * (r - 0.02) : 1.1;
}
double potential(double r) {
  const double a = std::min(r, 0.02), b = std::min(r, 0.08) - 0.02;
  if (r <= 0) return 0.0;
  return 50 * a * a + (b > 0 ? b * (2 - 7.5 * b) : 0.0) + (r > 0.08 ? 1.1 * (r - 0.08) : 0.0);
}

/// The ground of slab(): its nodes' vertical dofs with the weights of the trapezoidal rule.
struct Ground {
  std::vector<std::pair<int, double>> nodes;
  Ground(const Discretisation& d, int n) {
    for (int v = 0; v < static_cast<int>(d.mesh.nodes.size()); ++v)
      if (const auto& x = d.mesh.nodes[static_cast<std::size_t>(v)]; x[1] == 0.0)
        nodes.emplace_back(d.space.dof(v, 1), (x[0] == 0 || x[0] == 2 ? 0.5 : 1.0) / n);
  }
  double energy(const Vector& u) const {
    double sum = 0;
    for (const auto& [dof, weight] : nodes) sum += weight * potential(-u[dof]);
    return sum;
  }
  Vector force(const Vector& u) const {
    Vector out = Vector::Zero(u.size());
    for (const auto& [dof, weight] : nodes) out[dof] = -weight * slope(-u[dof]);
    return out;
  }
  /// ||xi|| in L2 of the ground.
  double size(const Vector& u) const {
    double sum = 0;
    for (const auto& [dof, weight] : nodes) sum += weight * std::pow(slope(-u[dof]), 2);
    return std::sqrt(sum);
  }
};

struct Case {
  bool proportional;
  LoadSampling sampling;
};

class Energies : public testing::TestWithParam<Case> {};

TEST_P(Energies, AreThoseOfTheFormulas) {
  constexpr int n = 3, steps = 7;
  Plan plan = slab(n, steps);
  for (double& t : plan.problem.time.grid) t = t * (1 + t) / 2;
  plan.problem.loads[0] = force(body, {0.0, -12.0 * var(slot::t)});
  plan.options.proportional_path = GetParam().proportional;
  plan.problem.time.sampling = GetParam().sampling;
  Discretisation d;
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  std::vector<Vector> states{Vector::Zero(d.space.n_dofs())};
  RunSettings settings;
  settings.monitors = true;
  settings.on_step = [&](int, double, const Vector& u, const Vector&) { states.push_back(u); };
  const auto table = run(plan, d, settings).monitors.value();
  const auto column = [&](const std::string& name) {
    const auto at = std::find(table.names.begin(), table.names.end(), name);
    return table.columns.at(static_cast<std::size_t>(at - table.names.begin()));
  };

  const auto a = matrix_of(plan.problem, d, field_of_u(1)),
             b = matrix_of(plan.problem, d, field_of_u(0));
  const Ground ground(d, n);
  LoadAssembler loads(d.space, d.parts, plan.problem.loads);
  // ||u||_V squared is the integral of eps(u) : eps(u)
  const auto strains =
      assemble_form(d.space, d.parts[body], elastic(2, body, field_of_u(0), {0.0, 0.5}));
  const auto norm = [&](const Vector& u) { return std::sqrt(u.dot(strains * u)); };
  double work = 0, viscous = 0, memory = 0, lost = 0, jumps = 0, rates = 0, most = 0, most_xi = 0;
  double elastic = 0, contact = 0;
  for (int m = 1; m <= steps; ++m) {
    const auto i = static_cast<std::size_t>(m), row = i - 1;
    const double before = plan.problem.time.grid[i - 1], now = plan.problem.time.grid[i],
                 k = now - before;
    const Vector &u = states[i], du = u - states[i - 1];
    Vector f = Vector::Zero(u.size()); // linear in t: its mean is its value half way
    loads.add(GetParam().sampling == LoadSampling::average ? (before + now) / 2 : now, f);
    const double of_viscosity = du.dot(a * du) / k;
    const double of_memory = (f - b * u - ground.force(u)).dot(du) - of_viscosity;
    const double new_elastic = 0.5 * u.dot(b * u), new_contact = ground.energy(u);
    work += f.dot(du), viscous += of_viscosity, memory += of_memory;
    lost +=
        f.dot(du) - of_viscosity - of_memory - (new_elastic - elastic) - (new_contact - contact);
    elastic = new_elastic, contact = new_contact;
    jumps += std::pow(norm(du), 2), rates += std::pow(norm(du), 2) / k;
    most = std::max(most, norm(u)), most_xi = std::max(most_xi, ground.size(u));
    const auto is = [&](const std::string& name, double value, double size) {
      EXPECT_NEAR(column(name)[row], value, 1e-9 * size) << name << " after step " << m;
    };
    is("energy", elastic + contact - f.dot(u), elastic);
    is("elastic", elastic, elastic);
    is("contact", contact, elastic);
    is("work", work, work);
    is("viscous", viscous, work);
    is("memory", memory, work);
    is("lost", lost, work);
    is("lemma_u", most, most);
    is("lemma_jumps", jumps, jumps);
    is("lemma_rate", rates, rates);
    is("lemma_xi", most_xi, most_xi);
    EXPECT_LT(column("inclusion")[row], 1e-9);
    EXPECT_EQ(column("snap")[row], 0.0);
  }
  EXPECT_EQ(table.times,
            std::vector<double>(plan.problem.time.grid.begin() + 1, plan.problem.time.grid.end()));
  EXPECT_GT(contact, 1e-3); // the layer is pressed, the memory works
  EXPECT_LT(memory, -1e-3);
  EXPECT_LT(table.balance_error, 1e-10);
}

INSTANTIATE_TEST_SUITE_P(Paths, Energies,
                         testing::Values(Case{true, LoadSampling::endpoint},
                                         Case{false, LoadSampling::endpoint},
                                         Case{true, LoadSampling::average},
                                         Case{false, LoadSampling::average}),
                         [](const auto& path) {
                           return std::string(path.param.proportional ? "ContactUnknowns" : "All") +
                                  (path.param.sampling == LoadSampling::average ? "Mean" : "End");
                         });

/// Where the roof moves the work is that of its reactions.
TEST(Energies, OfAMovingRoofAreTheWorkOfItsReactions) {
  Plan plan = slab(2, 4);
  plan.problem.space.dirichlet = {
      clamp(roof, -1, {0.0, 0.1 * var(slot::t) * var(slot::x(0)) * var(slot::x(0))})};
  plan.problem.histories.clear(), plan.problem.forms.pop_back();
  plan.problem.loads.clear();
  plan.problem.law_terms.clear(), plan.problem.laws.clear();
  plan.report = {};
  RunSettings settings;
  settings.monitors = true;
  std::vector<Vector> states;
  Discretisation d;
  for (const auto& mistake : discretise(plan, d)) throw mistake;
  states.push_back(Vector::Zero(d.space.n_dofs()));
  settings.on_step = [&](int, double, const Vector& u, const Vector&) { states.push_back(u); };
  const auto table = run(plan, d, settings).monitors.value();
  const auto a = matrix_of(plan.problem, d, field_of_u(1)),
             b = matrix_of(plan.problem, d, field_of_u(0));
  double work = 0;
  for (std::size_t m = 1; m < states.size(); ++m) {
    const Vector du = states[m] - states[m - 1];
    work += du.dot(a * du) / 0.25 + du.dot(b * states[m]); // all forces there are
    EXPECT_NEAR(table.columns[3][m - 1], work, 1e-9 * work);
  }
  EXPECT_GT(work, 0.0);
}

} // namespace
} // namespace hvi::solver
