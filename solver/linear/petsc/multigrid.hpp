// Algebraic multigrid of K: PETSc's GAMG, smoothed aggregation with the rigid motions of nodes
// (P. Vanek, J. Mandel, M. Brezina, Algebraic multigrid by smoothed aggregation for second and
// fourth order elliptic problems, Computing 56 (1996) 179-196).
#pragma once

#include "solver/linear/petsc/bridge.h"
#include "solver/linear/petsc/session.hpp"
#include "solver/linear/petsc/single_precision.hpp"

#include <memory>
#include <vector>

namespace hvi::petsc_module {

class Multigrid {
public:
  /// `motions`: a column for each, of this process's rows; K keeps them.
  Multigrid(Mat k, const std::vector<double>& motions, int n_motions);
  void set_up(); ///< for the entries that K has now
  PetscErrorCode apply(Vec r, Vec z) const { return PCApply(pc_.get(), r, z); }
  double bytes() const; ///< of all levels, on this process
  double seconds = 0.0;
  /// Of all processes, the finest one first.
  const std::vector<HviPetscLevel>& levels() const { return levels_; }

private:
  std::vector<PetscInt> block_sizes() const;
  void read_less();
  void measure();

  Mat k_;
  std::vector<std::unique_ptr<SingleMatrix>> single_; ///< of the levels; before what uses them ends
  Owned<PC> pc_;
  std::vector<HviPetscLevel> levels_;
};

} // namespace hvi::petsc_module
