// In which order several unknowns u, theta, ... are solved for, and what those before it leave of
// each of them.
//
// An unknown that does not read another one comes before it. Of those that read each other vectors
// come before scalars: what the elimination of a displacement leaves of a pressure is all but a
// mass, whatever the mesh, while a pressure leaves next to nothing of displacements that keep their
// volume (M. Benzi, G. Golub, J. Liesen, Numerical solution of saddle point problems, Acta Numerica
// 14 (2005) 1-137). Scalars whose form has more of a mass come later, for the same reason.
//
// What is eliminated is taken for diagonal: S_b = K_bb - diag(sum_a K_ba D_a^-1 K_ab), a the
// unknowns before b, D_a the diagonal of S_a. Of a pore pressure it is the fixed-stress split.
#pragma once

#include "solver/linear/petsc/matrix_part.hpp"

#include <vector>

namespace hvi::petsc_module {

/// Which rows are of which unknown.
struct UnknownRows {
  /// Of each row the unknown's place in the order; -1: of none. Of this process's rows, and of the
  /// whole, of the first process.
  std::vector<int> turn, turn_of_whole;
  std::vector<int> components; ///< of each unknown, in the order; of the first process
  int count = 0;               ///< of unknowns
};

/// `first_component`: of each unknown as they are given, and the number of all components, of the
/// first process.
UnknownRows order_of_unknowns(const Distribution& distribution, Mat k, const Numbering& numbering,
                              const std::vector<int>& first_component);

/// By row of this process, the diagonals of all S_b.
std::vector<double> eliminate(const Distribution& distribution, Mat k, const UnknownRows& unknowns);

} // namespace hvi::petsc_module
