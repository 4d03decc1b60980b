#include "lang/check/inertia.hpp"

#include <algorithm>

namespace hvi::lang {

namespace slot = solver::slot;

bool has_acceleration(const ModelTerm& term) {
  constexpr int order = 2;
  return term.integrand.laws.empty() &&
         (term.factor * term.integrand.scalar())
             .depends_on_any(slot::field(solver::field_of_u(order), 0),
                             slot::field(solver::field_of_u(order) + 1, 0));
}

bool has_second_derivative(const Model& model) {
  return model.lacks_terms || std::ranges::any_of(model.terms, has_acceleration);
}

} // namespace hvi::lang
