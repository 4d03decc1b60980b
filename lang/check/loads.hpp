// Loads that read the solution: on the right, what is not linear in it.
#pragma once

#include "lang/check/model.hpp"

namespace hvi::lang {

/// Is what stands before a test function a sum of fields with coefficients that know none of them?
/// Seen from how it is written: x*x/x is not.
bool is_affine(const Symbol& against);

/// Does a term on the right depend on the solution in another way?
bool reads_solution(const ModelTerm& term);

} // namespace hvi::lang
