// Algebraic multigrid of K: PETSc's GAMG, smoothed aggregation with the rigid motions of nodes
// (P. Vanek, J. Mandel, M. Brezina, Algebraic multigrid by smoothed aggregation for second and
// fourth order elliptic problems, Computing 56 (1996) 179-196), with what laws add on all levels.
#pragma once

#include "solver/linear/petsc/law_levels.hpp"

#include <memory>
#include <vector>

namespace hvi::petsc_module {

class Multigrid {
public:
  /// `motions`: a column for each, of this process's rows; K keeps them.
  Multigrid(Mat k, const std::vector<double>& motions, int n_motions);
  void set_up(); ///< for the entries that K has now
  /// Of K and the laws from now on: this process's rows of what they add, symmetric in its pattern.
  void set_laws(const Distribution& distribution, const HviPetscMatrix& h);
  /// Of K alone, until other laws are set; false: it was.
  bool leave_laws();
  PetscErrorCode apply(Vec r, Vec z) const { return PCApply(pc_.get(), r, z); }
  double bytes() const; ///< of all levels, on this process
  double seconds = 0.0;
  /// Of all processes, the finest one first.
  const std::vector<HviPetscLevel>& levels() const { return levels_; }

private:
  std::vector<PetscInt> block_sizes() const;
  void read_less();
  void spread_laws();
  void measure();

  Mat k_;
  std::vector<SingleLevel> single_; ///< the finest one first; what uses them ends before
  LawLevels laws_;
  Owned<Mat> coarsest_, coarsest_with_laws_;
  Owned<PC> pc_;
  std::vector<HviPetscLevel> levels_;
};

} // namespace hvi::petsc_module
