// Tensors that vary in place, looked at on the mesh. Between discretise and the assembly, which
// would only say that a form is not coercive.
#pragma once

#include "lang/driver.hpp"

namespace hvi::lang {

/// E0504, with the place, for every tensor of the script that is not finite somewhere on the parts
/// where it is used, and for every material there that is not elliptic. Looks at the centre of each
/// cell, where the assembly of constant strains does.
void check_materials(Script& script, const solver::Discretisation& discretisation);

/// Mesh, parts and materials of a script; every mistake becomes a diagnostic. The exit code, which
/// is exit_ok when there are none. A Ctrl-C ends the adaptation of a mesh.
int discretise_script(Script& script, solver::Discretisation& out);

} // namespace hvi::lang
