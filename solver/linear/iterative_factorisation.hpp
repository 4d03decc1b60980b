// Iterations behind the interface of a factor, where nothing is condensed.
#pragma once

#include "solver/linear/factorisation.hpp"
#include "solver/linear/iterative_solver.hpp"

namespace hvi::solver {

/// All n unknowns are interior: `forward` leaves the right-hand side as it is, `back` solves. Keeps
/// a reference. `factor` asks whether the solver's matrix has an answer at all; throws
/// NotFactorable.
std::unique_ptr<Factorisation> iterative_factorisation(IterativeSolver& solver, int n);

} // namespace hvi::solver
