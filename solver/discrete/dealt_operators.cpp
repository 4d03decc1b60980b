// See dealt_operators.hpp.
#include "solver/discrete/dealt_operators.hpp"

#include "solver/discrete/body_states.hpp"
#include "solver/discrete/dealt_matrices.hpp"
#include "solver/discrete/distinct_forms.hpp"
#include "solver/discrete/inertia.hpp"
#include "solver/discrete/nodes_of_unknowns.hpp"

#include <algorithm>
#include <utility>

namespace hvi::solver {
namespace {

bool is_known_symmetric(const Problem& problem, const FormTerm& form) {
  return has_symmetric_tensor(problem, form) || stays_mirrored(form);
}

} // namespace

bool may_be_dealt(const Problem& problem, const Discretisation& d) {
  return !problem.forms.empty() && !takes_mass_off_contact(problem) &&
         std::ranges::none_of(problem.forms, [&](const FormTerm& form) {
           return reads_states(form) || d.parts[static_cast<std::size_t>(form.part)].is_pair();
         });
}

Operators deal_operators(const Problem& problem, const Discretisation& d, const StateLayout& layout,
                         int processes) {
  const int n_fields = count_fields(problem);
  const auto distinct = distinct_terms(problem, n_fields, [](const FormTerm&) { return true; });
  DistinctForms forms{{}, distinct.weights, couplings_of(problem)};
  for (const FormTerm* const term : distinct.terms) forms.terms.push_back(*term);
  auto unknowns = nodes_of_unknowns(d, layout);
  Operators out;
  out.n_unknowns = layout.n_unknowns;
  out.dealt = std::make_shared<DealtMatrices>(d, layout, forms, processes, *unknowns);
  out.iterative = std::move(unknowns);
  const auto& weights = out.dealt->weights();
  out.weights.resize(n_fields, static_cast<Eigen::Index>(weights.size()));
  for (std::size_t b = 0; b < weights.size(); ++b)
    out.weights.col(static_cast<Eigen::Index>(b)) = weights[b];
  out.bases.resize(weights.size());
  const bool known = std::ranges::all_of(
      problem.forms, [&](const FormTerm& form) { return is_known_symmetric(problem, form); });
  out.coupled = couples_unknowns(forms.couplings);
  out.symmetric = !out.coupled;
  for (int b = 0; b < out.n_bases() && !known; ++b)
    out.symmetric = out.symmetric && out.dealt->is_symmetric(b);
  return out;
}

} // namespace hvi::solver
