// The mass matrix of a run.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/discrete/state.hpp"
#include "solver/plan/problem.hpp"

#include <cstdint>
#include <vector>

namespace hvi::solver {

/// The sum of the forms in u'' on all dofs, integrated exactly. With the scheme `midpoint`, nodes
/// that laws with a unilateral part touch are without mass:
///
///   M_r = P^T M P,   (P v)_i = v_i,   at a node c of these laws (P v)_c = sum_j w_cj v_j,
///
/// j the nodes around it that are not of these laws, w_cj the shortest weights that are exact for
/// affine functions. So M_r is symmetric, positive on the others, has the kinetic energy of every
/// rigid motion, and turns with the scene. Of several unknowns those with mass lose it at laws of
/// their own. Why nodes in contact should have none: F. Dabaghi, A. Petrov, J. Pousin, Y. Renard,
/// Convergence of mass redistribution method for the one-dimensional wave equation with a
/// unilateral constraint at the boundary, ESAIM Math. Model. Numer. Anal. 48 (2014) no. 4; D.
/// Doyen, A. Ern, Analysis of the modified mass method for the dynamic Signorini problem with
/// Coulomb friction, SIAM J. Numer. Anal. 49 (2011) 2039-2056.
SparseMatrix inertia_matrix(const Problem& problem, const Discretisation& discretisation);

/// The rows of that matrix which are others than those of the forms: of nodes that lose their mass,
/// of those that get it, and of their neighbours.
struct MovedMass {
  std::vector<std::int32_t> rows; ///< unknowns, in order
  SparseMatrix matrix;            ///< unknowns x state; other rows are empty
};
/// From the cells around these nodes alone.
MovedMass moved_mass(const Problem& problem, const Discretisation& discretisation,
                     const StateLayout& layout);

/// P^T on all dofs, by which loads go where the mass is, so that a body falls as a whole: forces
/// and moments stay. Imposed dofs keep theirs. Without entries where no node loses its mass.
SparseMatrix load_transfer(const Problem& problem, const Discretisation& discretisation);

/// Does inertia_matrix take mass off any node?
bool takes_mass_off_contact(const Problem& problem);

} // namespace hvi::solver
