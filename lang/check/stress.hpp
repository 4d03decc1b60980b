// `sigma` of a report.
#pragma once

#include "lang/check/mistakes.hpp"
#include "lang/check/unknowns.hpp"

namespace hvi::lang {

/// The stress, the sum of all that is contracted with eps(v): sigma_ij = d integrand / d
/// (dv_i/dx_j), symmetrised, on cells; axisymmetric: 3 x 3, zz along the circles. Of the first
/// unknown that is a vector, else of the first.
Field stress(const Model& model, const Unknowns& unknowns);

/// W0111 at the first `sigma` of a script that reads no multiplier of a law which adds to the
/// stress inside a body.
void tell_stress_of_laws(const ast::Program& script, const Model& model, const Unknowns& unknowns,
                         Mistakes& mistakes);

} // namespace hvi::lang
