// Points of a report at which two sides meet.
#pragma once

#include "lang/script.hpp"
#include "solver/discrete/discretisation.hpp"

namespace hvi::lang {

/// W0613 at columns of points where a value is that of one side of several: pieces that touch, a
/// crack.
void report_several_values(Script& script, const solver::Discretisation& discretisation);

} // namespace hvi::lang
