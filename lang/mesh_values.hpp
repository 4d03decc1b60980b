// Tensors that vary in place, looked at on the mesh. Between discretise and the assembly, which
// would only say that a form is not coercive.
#pragma once

#include "lang/script.hpp"
#include "solver/time/run.hpp"

namespace hvi::lang {

/// E0504, with the place, for every tensor of the script that is not finite somewhere on the parts
/// where it is used, and for every material there that is not elliptic. Looks at the centre of each
/// cell, where the assembly of constant strains does.
void check_materials(Script& script, const solver::Discretisation& discretisation);

} // namespace hvi::lang
