// See state_loads.hpp. Used by the balance of a step, and by reactions and energies.
#include "solver/discrete/state_loads.hpp"

#include "solver/discrete/body_states.hpp"

#include <cmath>

namespace hvi::solver {
namespace {

std::vector<Expr> values_of(const LoadTerm& load) {
  std::vector<Expr> out;
  for (const LoadTerm::Entry& entry : load.entries) out.push_back(entry.value);
  return out;
}

} // namespace

StateLoads::StateLoads(const Problem& problem, const Discretisation& d, const Contact& contact,
                       const StateLayout* layout)
    : dim_(d.mesh.dim), first_state_(contact.first_state) {
  for (const LoadTerm& load : problem.state_loads) {
    const StateGroup& group = body_group(problem, contact, load.part, load.origin, "a load");
    Part part{load.origin, as_block(group.body->points), {}, Pointwise(values_of(load))};
    for (const LoadTerm::Entry& entry : load.entries) {
      const SparseMatrix rows = derivative_rows(d.space, part.points, entry.test, load.origin);
      if (layout == nullptr)
        part.test.push_back(rows);
      else
        part.test.emplace_back(restrict_columns(rows, *layout).leftCols(layout->n_unknowns));
    }
    parts_.push_back(std::move(part));
  }
}

void StateLoads::add(double t, const Vector& states, double factor, Vector& out) const {
  if (factor == 0.0) return;
  const auto column = [&](Slot s) -> const double* {
    return slot::is_state(s)
               ? states.data() + first_state_[static_cast<std::size_t>(s - slot::first_state)]
               : nullptr;
  };
  std::vector<double> values;
  for (const Part& part : parts_) {
    const std::size_t n = part.points.size();
    values.resize(n * part.test.size());
    part.values.evaluate(part.points, t, part.origin, values, column);
    for (std::size_t e = 0; e < part.test.size(); ++e) {
      Vector forces(static_cast<Eigen::Index>(n));
      for (std::size_t p = 0; p < n; ++p) {
        const double value = values[e * n + p];
        if (!std::isfinite(value))
          throw_not_finite(part.origin, "a load that reads a state", value, part.points.point(p),
                           dim_, &t);
        forces[static_cast<Eigen::Index>(p)] = factor * part.points.weight[p] * value;
      }
      out.noalias() += part.test[e].transpose() * forces;
    }
  }
}

} // namespace hvi::solver
