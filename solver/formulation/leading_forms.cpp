// See leading_forms.hpp. Called where a run with u'' starts.
#include "solver/formulation/leading_forms.hpp"

#include "solver/discrete/operators.hpp"
#include "solver/plan/couplings.hpp"

namespace hvi::solver {

LeadingForms::LeadingForms(const Problem& problem, const Discretisation& discretisation,
                           const StateLayout& layout)
    : n_unknowns_(layout.n_unknowns) {
  const Space& space = discretisation.space;
  const std::vector<int> orders = orders_in_time(problem);
  for (const auto dof : layout.dof_of)
    order_of_.push_back(static_cast<std::int8_t>(
        orders[static_cast<std::size_t>(space.block_of(dof % space.components))]));
  for (int k = 0; k <= highest_derivative; ++k)
    forms_[static_cast<std::size_t>(k)] =
        restrict_rows(matrix_of_field(problem, discretisation, field_of_u(k)), layout);
}

SparseMatrix LeadingForms::matrix() const {
  SparseMatrix out(n_unknowns_, n_unknowns_);
  for (int k = 0; k <= highest_derivative; ++k) {
    SparseMatrix own = on_unknowns(forms_[static_cast<std::size_t>(k)], n_unknowns_);
    own.prune([&](Eigen::Index, Eigen::Index j, double) {
      return order_of_[static_cast<std::size_t>(j)] == k;
    });
    out = SparseMatrix(out + own);
  }
  return out;
}

Vector LeadingForms::leading(const std::array<Vector, 3>& derivatives) const {
  Vector out(std::ssize(order_of_));
  for (Eigen::Index i = 0; i < out.size(); ++i)
    out[i] = derivatives[static_cast<std::size_t>(order_of_[static_cast<std::size_t>(i)])][i];
  return out;
}

void LeadingForms::put(const Vector& y, int order, Vector& derivative) const {
  for (Eigen::Index i = 0; i < y.size(); ++i)
    if (order_of_[static_cast<std::size_t>(i)] == order) derivative[i] = y[i];
}

Vector LeadingForms::known(const std::array<Vector, 3>& derivatives) const {
  Vector out = Vector::Zero(n_unknowns_);
  for (int k = 0; k <= highest_derivative; ++k) {
    Vector state = derivatives[static_cast<std::size_t>(k)];
    for (Eigen::Index i = 0; i < state.size(); ++i) {
      const int order = order_of_[static_cast<std::size_t>(i)];
      if (k > order || (k == order && i < n_unknowns_)) state[i] = 0.0;
    }
    out += forms_[static_cast<std::size_t>(k)] * state;
  }
  return out;
}

} // namespace hvi::solver
