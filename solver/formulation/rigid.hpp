// Why a matrix has no factor, in the user's words.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/discrete/time_grid.hpp"
#include "solver/formulation/formulation.hpp"

namespace hvi::solver {

/// Which step a matrix belongs to.
struct MatrixOf {
  const Formulation& formulation;
  const TimeGrid& grid;
  int step;
};

/// matrix.factor(gamma); when there is no factor, throws Failure(not_coercive) that names the rigid
/// motions that no law sees (held_by_laws.hpp), or without laws those that no form resists ("the
/// body moves along x"), or else the degree of freedom where the elimination broke down, or says
/// that without memories there would be one. Where K is positive but for rounding, and its softest
/// motion strains cells, the script is right and double precision too short:
/// Failure(mostly_rounding).
void factor_or_explain(StepMatrix& matrix, const Vector& gamma, const MatrixOf& of,
                       const Problem& problem, const Discretisation& discretisation);

/// The rigid motions of each unknown that the imposed values allow and K, or else its transpose,
/// does not resist, each in words.
std::vector<std::string> free_motions(const SparseMatrix& k, const Discretisation& discretisation,
                                      const StateLayout& layout);

} // namespace hvi::solver
