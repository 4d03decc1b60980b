// See step_load.hpp. Used by Balance and by the energies that check it.
#include "solver/step/step_load.hpp"

#include "solver/discrete/inertia.hpp"

#include <vector>

namespace hvi::solver {

void add_step_load(const LoadAssembler& loads, const TimeSpec& time, const TimeScheme& scheme,
                   int n, Vector& out) {
  const TimeGrid& grid = scheme.grid();
  const bool mean = time.sampling == LoadSampling::average && !grid.is_static();
  const auto add_sample = [&](int m, Vector& to) {
    if (mean && m > 0)
      loads.add_mean(grid.t(m - 1), grid.t(m), to);
    else
      loads.add(grid.t(m), to);
  };
  if (!scheme.looks_back() || (mean && time.scheme == Scheme::midpoint)) return add_sample(n, out);
  Vector now = Vector::Zero(out.size()), before = Vector::Zero(out.size());
  add_sample(n, now);
  add_sample(n - 1, before);
  out += scheme.present(0) * now + scheme.past(0) * before;
}

StepLoad::StepLoad(const Problem& problem, const Discretisation& discretisation,
                   const Formulation& formulation, const TimeScheme& scheme)
    : problem_(problem), formulation_(formulation), scheme_(scheme) {
  const auto& layout = formulation.layout();
  SparseMatrix transfer = load_transfer(problem, discretisation);
  std::vector<char> repeats(static_cast<std::size_t>(transfer.cols()), 0);
  for (const DofLink& link : layout.links)
    if (transfer.cols() > 0) repeats[static_cast<std::size_t>(link.dof)] = 1;
  // The loads of dofs that are one are added up before.
  transfer.prune([&](Eigen::Index, Eigen::Index column, double) {
    return repeats[static_cast<std::size_t>(column)] == 0;
  });
  if (transfer.nonZeros() > 0)
    transfer_ = restrict_rows(transfer, layout).leftCols(layout.n_unknowns);
}

bool StepLoad::keeps_reactions() const {
  return scheme_.past_of_laws() != 0.0 && !formulation_.contact().none();
}

void StepLoad::find(int n, Vector& out) const {
  out.setZero(formulation_.layout().n_unknowns);
  add_step_load(formulation_.loads(), problem_.time, scheme_, n, out);
  if (transfer_.nonZeros() > 0) out = transfer_ * out;
  add_state_loads(n, scheme_.present(0), out); // inner stresses act where those of forms do
  if (last_state_load_.size() > 0) out += last_state_load_;
  if (last_forces_.size() > 0) out -= last_forces_;
  if (keeps_reactions()) out -= scheme_.past_of_laws() * last_reaction_;
}

void StepLoad::add_state_loads(int n, double factor, Vector& out) const {
  formulation_.state_loads().add(scheme_.grid().t(n), formulation_.contact().state_values, factor,
                                 out);
}

void StepLoad::note_state_loads(int n) {
  if (formulation_.state_loads().none()) return;
  last_state_load_.setZero(formulation_.layout().n_unknowns);
  add_state_loads(n - 1, scheme_.past(0), last_state_load_);
}

void StepLoad::note_multipliers(const Vector& xi) {
  if (keeps_reactions()) last_reaction_ = formulation_.contact().force * xi;
}

} // namespace hvi::solver
