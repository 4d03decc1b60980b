// Did a step cross unstable states? Asked of an accepted step.
#pragma once

#include "solver/discrete/contact.hpp"

namespace hvi::solver {

/// Is the step's energy along its increment, s -> <K s d, s d>/2 + J(z_0 + s dz) - ..., concave
/// somewhere on [0, 1]? Then the old branch had ended and the step is a snap: no stable path of
/// states leads along it. `stiffness` = <K d, d>, z_0 = contact.problem.offset, dz = G c.
/// dz = G c is left there.
bool is_snap(const Contact& contact, const Vector& c, double stiffness, Vector& dz);

} // namespace hvi::solver
