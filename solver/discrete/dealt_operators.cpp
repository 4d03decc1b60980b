// See dealt_operators.hpp.
#include "solver/discrete/dealt_operators.hpp"

#include "solver/discrete/body_states.hpp"
#include "solver/discrete/contact_states.hpp"
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

/// Those that read states, each once, and their weights.
DistinctTerms changing_terms(const Problem& problem) {
  return distinct_terms(problem, count_fields(problem), reads_states);
}

} // namespace

DealtForms forms_to_deal(const Problem& problem, const Discretisation& d,
                         const StateLayout& layout) {
  DealtForms out;
  out.n_fields = count_fields(problem);
  out.couplings = couplings_of(problem);
  const bool plain_inertia = !takes_mass_off_contact(problem);
  auto distinct = distinct_terms(problem, out.n_fields, [&](const FormTerm& form) {
    return (plain_inertia || form.field != field_of_u(2)) && !reads_states(form);
  });
  for (const FormTerm* const term : distinct.terms) out.terms.push_back(*term);
  out.weights = std::move(distinct.weights);
  if (!plain_inertia) {
    for (const FormTerm& form : problem.forms)
      if (form.field == field_of_u(2)) out.inertia.push_back(form);
    out.moved = moved_mass(problem, d, layout);
  }
  auto changing = changing_terms(problem);
  for (const FormTerm* const form : changing.terms)
    out.changing.push_back(
        {*form, at_initial_states(problem, *form), reading_of(problem, d, *form)});
  out.weights_of_changing = std::move(changing.weights);
  return out;
}

Operators deal_operators(const Problem& problem, const Discretisation& d, const StateLayout& layout,
                         int processes) {
  const DealtForms forms = forms_to_deal(problem, d, layout);
  const auto changing = changing_terms(problem).terms;
  if (!changing.empty()) check_initial_states(problem, d);
  auto unknowns = nodes_of_unknowns(d, layout);
  Operators out;
  out.n_unknowns = layout.n_unknowns;
  out.dealt = std::make_shared<DealtMatrices>(d, layout, forms, processes, *unknowns);
  out.iterative = std::move(unknowns);
  const auto& weights = out.dealt->weights();
  out.weights.resize(forms.n_fields, static_cast<Eigen::Index>(weights.size()));
  for (std::size_t b = 0; b < weights.size(); ++b)
    out.weights.col(static_cast<Eigen::Index>(b)) = weights[b];
  out.bases.resize(weights.size());
  const int constant = out.n_bases() - static_cast<int>(changing.size());
  for (std::size_t k = 0; k < changing.size(); ++k)
    out.changing.emplace_back(constant + static_cast<int>(k), changing[k]);
  const auto is_known = [&](const FormTerm& form) { return is_known_symmetric(problem, form); };
  const bool known = forms.inertia.empty() && std::ranges::all_of(forms.terms, is_known);
  out.coupled = couples_unknowns(forms.couplings);
  out.symmetric = !out.coupled && std::ranges::all_of(changing, [&](const FormTerm* form) {
    return is_known(*form);
  });
  for (int b = 0; b < constant && !known; ++b)
    out.symmetric = out.symmetric && out.dealt->is_symmetric(b);
  return out;
}

} // namespace hvi::solver
