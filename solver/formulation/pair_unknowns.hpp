// Jumps across pairs as unknowns.
//
// A law on the jump [u] of a pair sees nodes of both sides, and points next to each other share
// those of the second one. With dual multipliers row i of [u] has one node of the first side in it,
// its own: [u]_i = J_ii u_i + sum_m J_im u_m, m on the second side. So u_i may be replaced by what
// the laws see of [u]_i (rows A, completed by parts of u_i that nobody sees), u = T x: every point
// has unknowns of its own, as on one body, and the nodes of the second side are no contact unknowns
// any more. T^T K T is the matrix of two bodies that are joined where x is 0. (B. I. Wohlmuth,
// Variationally consistent discretization schemes and numerical algorithms for contact problems,
// Acta Numerica 20 (2011); J. Youett, O. Sander, R. Kornhuber, A globally convergent filter-trust-
// region method for large deformation contact problems, arXiv:1708.01455 (2017), where such a
// transformation decouples the constraints of two bodies.)
//
// The change is made inside the direct solver and the reduced problem. States, loads, memories,
// certificates and results stay those of u.
#pragma once

#include "solver/discrete/contact.hpp"
#include "solver/discrete/held_by_laws.hpp"

namespace hvi::solver {

struct JumpUnknowns {
  std::shared_ptr<const BasisChange> change; ///< null: no point has a node to itself
  std::vector<int> rows;                     ///< of G, that became unknowns
};

/// T for those points of pairs that have a node to themselves. Points whose node other laws see as
/// well, or a mean, those on creases, and P2 in 3D stay as they are.
JumpUnknowns jumps_as_unknowns(const Problem& problem, const Space& space,
                               const StateLayout& layout, const Contact& contact);

/// Do all motions that forms leave free make jumps in these rows of G? Else T^T K T would leave the
/// joined bodies free.
bool all_make_jumps(const FreeBody& free, const Contact& contact, const std::vector<int>& rows);

} // namespace hvi::solver
