// Meshes that follow the solution: solve, estimate, mark, bisect, until so many cells are there.
// Between the generated mesh and `discretise`, for a mesh with MeshSpec::adapted.
//
// The indicator is the distance of the strain (scalar unknowns: the gradient) to its recovery, a
// continuous field of the same degree: O. C. Zienkiewicz, J. Z. Zhu, A simple error estimator and
// adaptive procedure for practical engineering analysis, Int. J. Numer. Methods Eng. 24 (1987)
// 337-357; reliable for averages of any kind: C. Carstensen, S. Bartels, Each averaging technique
// yields reliable a posteriori error control in FEM on unstructured grids, Math. Comp. 71 (2002).
// On intervals, whose lengths nothing binds to those of their neighbours, derivatives are recovered
// from the middles of cells, where they are most accurate (the superconvergent points of O. C.
// Zienkiewicz, J. Z. Zhu, The superconvergent patch recovery, Int. J. Numer. Methods Eng. 33 (1992)
// 1331-1364). Cells are marked by the bulk criterion of W. Doerfler, A convergent adaptive
// algorithm for Poisson's equation, SIAM J. Numer. Anal. 33 (1996) 1106-1124.
#pragma once

#include "solver/fem/space.hpp"
#include "solver/plan/plan.hpp"

#include <atomic>
#include <span>
#include <vector>

namespace hvi::solver {

/// By cell int_K |G - D u|^2, and int |D u|^2.
struct RecoveryIndicator {
  std::vector<double> cells;
  double size = 0.0;
};

/// For each cell int_K |G - D u|^2, D u the symmetric gradient of a vector, the gradient of a
/// scalar, G its average at each node over the cells of the same kind (1D: from their middles).
/// `kind`: cells of different numbers have different materials, where D u may jump; empty: all
/// alike. A cell without a neighbour of its kind has int_K |D u|^2: nothing is known of its error.
/// Of several unknowns: of this one.
RecoveryIndicator recovery_indicator(const Space& space, const Vector& u,
                                     std::span<const int> kind = {}, int unknown = 0);

/// The fewest cells whose indicators add up to `bulk` of the sum of all, largest first.
std::vector<std::int32_t> marked_cells(std::span<const double> indicators, double bulk);

/// The mesh of plan.problem.mesh (without `adapted`), bisected to at most plan.problem.mesh.adapted
/// cells where the problem's own solution on the mesh so far, at a few times, has its errors. Of
/// several unknowns the indicators relative to the size of D u are added up; a pressure without a
/// form of its own has none. Pieces side by side share the cells. Depends on neither the time grid
/// nor the scheme; meshes for fewer cells are coarser versions of those for more. Throws what the
/// problem throws on a coarse mesh, and Failure(interrupted).
Mesh adapted_mesh(const Plan& plan, const std::atomic<bool>* stop = nullptr);

/// What the adapted mesh depends on, as text: two plans with the same have the same mesh.
std::string adapted_key(const Plan& plan);

} // namespace hvi::solver
