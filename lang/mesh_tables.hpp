// Tables of places that are finer than the mesh which reads them.
#pragma once

#include "lang/script.hpp"
#include "solver/discrete/discretisation.hpp"

namespace hvi::lang {

/// W0612 at integrals of the problem and of the report that read a table of x, y, z whose mean over
/// a cell or side is another one than its points see: an integral knows a table at the points of
/// its rule only. Of a table on a part once.
void report_fine_tables(Script& script, const solver::Discretisation& discretisation);

} // namespace hvi::lang
