// The form  factor * C : eps(field) : eps(v)  of a tensor of the problem.
#pragma once

#include "solver/plan/problem.hpp"

namespace hvi::solver {

/// Its entries, in a problem of this dimension; the origin and the part are the caller's.
FormTerm tensor_form(const Problem& problem, int dim, int field, const FormTerm::Tensor& tensor);

/// Are the entries of the form those of the tensor that comes with it? Coefficients of place and of
/// states are compared at a few values of these.
bool has_entries_of_its_tensor(const Problem& problem, int dim, const FormTerm& form);

} // namespace hvi::solver
