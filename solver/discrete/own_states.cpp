// See own_states.hpp.
#include "solver/discrete/own_states.hpp"

#include <utility>

namespace hvi::solver {

OwnChangingForms::OwnChangingForms(std::unique_ptr<const OwnCells> cells,
                                   std::vector<ChangingTerm> terms, std::vector<SparseMatrix> made,
                                   int first)
    : cells_(std::move(cells)), terms_(std::move(terms)), matrices_(std::move(made)),
      first_(first) {
  for (const ChangingTerm& term : terms_)
    forms_.push_back(point_form(cells_->discretisation, term.form, term.reading));
}

void OwnChangingForms::take(std::span<const double> values, OwnRows& rows) {
  const StateLayout& layout = cells_->layout;
  const DofSelection dofs{layout.entry_of, layout.n_unknowns, layout.n_state};
  const double* next = values.data();
  for (std::size_t f = 0; f < terms_.size(); ++f) {
    const StateReading& reading = terms_[f].reading;
    std::vector<const double*> of_form;
    for (std::size_t k = 0; k < reading.states.size(); ++k) {
      of_form.push_back(next);
      next += reading.uniform ? 1 : forms_[f].points();
    }
    StateColumns read(reading, std::move(of_form), forms_[f].points());
    forms_[f].assemble(dofs, read.columns(), matrices_[f], read.time());
    rows.replace(first_ + static_cast<int>(f), matrices_[f]);
  }
}

} // namespace hvi::solver
