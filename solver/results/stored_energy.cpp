// See stored_energy.hpp.
#include "solver/results/stored_energy.hpp"

#include "solver/discrete/inertia.hpp"
#include "solver/discrete/operators.hpp"
#include "solver/formulation/halved_bases.hpp"
#include "solver/results/released_energy.hpp"

#include <algorithm>

namespace hvi::solver {

namespace {

/// Do base matrices act on all of a state and keep all of what it makes, so that products give
/// energies?
bool products_are_whole(const Formulation& formulation) {
  const Operators& operators = formulation.operators();
  return !operators.halves.empty() ||
         (operators.dealt && operators.symmetric && !formulation.imposed());
}

} // namespace

StoredEnergy::StoredEnergy(const Problem& problem, const Discretisation& d, const RunState& run,
                           bool own)
    : problem_(problem), d_(d), own_(own || !products_are_whole(*run.formulation)),
      elastic_(own_ ? matrix_of_field(problem, d, field_of_u(0)) : SparseMatrix()),
      load_transfer_(load_transfer(problem, d)), loads_(d.space, d.parts, problem.loads),
      state_loads_(problem, d, run.contact(), nullptr), symmetric_(symmetric_to_rounding(elastic_)),
      moves_(in_motion(problem)) {
  potentials_ = std::ranges::all_of(problem.law_terms, [&](const LawTerm& term) {
    const LawSpec& law = problem.laws[static_cast<std::size_t>(term.law)];
    return law.coupled.empty() && law.readings.empty() && term.seen.empty();
  });
  take_states(run);
}

void StoredEnergy::take_states(const RunState& run) {
  if (run.formulation->changes_forms())
    elastic_ = matrix_of_field(problem_, d_, field_of_u(0), run.contact(), run.states());
}

double StoredEnergy::energy(const RunState& run) {
  Vector u = Vector::Zero(d_.space.n_dofs()), force = u;
  run.formulation->scatter(run.evolution.u(), u);
  load(run, force);
  const double elastic_energy = own_ ? elastic(u) : elastic_by_products(run);
  return elastic_energy + contact(run, u) - force.dot(u);
}

double StoredEnergy::elastic_by_products(const RunState& run) {
  const Operators& operators = run.formulation->operators();
  const Vector& u = run.evolution.u();
  Vector forces;
  double sum = 0.0;
  for (int b = 0; b < operators.n_bases(); ++b) {
    const double weight = operators.weights(field_of_u(0), b);
    if (weight == 0.0) continue;
    if (operators.dealt) {
      product_of_base(operators, b, u, forces);
      sum += weight * u.dot(forces);
    } else {
      sum += weight * operators.halves[static_cast<std::size_t>(b)].energy(u);
    }
  }
  return 0.5 * sum;
}

double StoredEnergy::contact(const RunState& run, const Vector& u) {
  const Contact& contact = run.contact();
  z_ = contact.offset;
  double sum = 0;
  for (const auto& term : contact.terms) {
    if (term.field != field_of_u(0)) continue;
    z_.segment(term.first_row, term.n_rows()) += term.points.g * u;
    for (int p = 0; p < term.n_points(); ++p) {
      const auto& point = contact.problem.points[term.first_point + p];
      const auto& graph = contact.problem.graphs[point.graph];
      const auto z = z_.segment(point.first_row, point.rows);
      const Law& law = *contact.laws[point.law];
      sum += point.weight * potential_at(law, graph, law.spec().radial ? z.norm() : z[0]);
    }
  }
  return sum;
}

void StoredEnergy::load(const RunState& run, Vector& out) const {
  const auto& grid = run.evolution.grid();
  const int n = run.evolution.step();
  out.setZero();
  if (problem_.time.sampling == LoadSampling::average && !grid.is_static() && n > 0)
    loads_.add_mean(grid.t(n - 1), grid.t(n), out);
  else
    loads_.add(grid.t(n), out);
  if (load_transfer_.nonZeros() > 0) out = load_transfer_ * out;
  state_loads_.add(grid.t(n), run.states(), 1.0, out);
}

} // namespace hvi::solver
