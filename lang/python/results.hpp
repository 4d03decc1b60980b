// What a run has found out, taken from its session.
#pragma once

#include "lang/python/answer.hpp"

namespace hvi::python {

/// Parameters with values, ranges and comments; names of unknowns and columns; the study's ladders.
nlohmann::ordered_json description_of(const lang::Script& script);
/// The unknowns at a step, behind those that were kept before.
void keep(const solver::Space& space, double t, const solver::Vector& u, Answer& answer);
/// Table, fields, energies and the result as JSON (hvi-result/1); of a run that failed, as far as
/// it went. Pictures from `own_pictures` on are fields (fields.hpp).
void add_results(const lang::Session& session, const solver::Discretisation& discretisation,
                 std::size_t own_pictures, Answer& answer);

} // namespace hvi::python
