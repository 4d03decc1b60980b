// Iterations behind the interface of a factor, where nothing is condensed.
#pragma once

#include "solver/linear/factorisation.hpp"
#include "solver/linear/iterative_solver.hpp"
#include "solver/linear/matrix_rows.hpp"

namespace hvi::solver {

/// All unknowns are interior: `forward` leaves the right-hand side as it is, `back` solves. `k`:
/// the solver's matrix. Keeps references. `factor` asks whether it has an answer at all, whatever
/// it is given; throws NotFactorable.
std::unique_ptr<Factorisation> iterative_factorisation(IterativeSolver& solver,
                                                       const MatrixRows& k);

} // namespace hvi::solver
