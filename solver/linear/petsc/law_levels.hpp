// What laws add to a matrix, on the levels of its multigrid.
//
// No cycle of K knows where contact is closed or sticks: bodies that are held there move on all
// levels as if they were free. With H of the finest level (no stiffer than a part of the body:
// cycle.hpp) and P the interpolations, the levels have H, P^T H P, ... beside K, P^T K P, ...
// Entries are in few rows of each, those that interpolate from the rows where laws act.
#pragma once

#include "solver/linear/petsc/distribution.hpp"
#include "solver/linear/petsc/single_precision.hpp"

#include <memory>
#include <utility>
#include <vector>

namespace hvi::petsc_module {

/// A level's matrix and its interpolation from the next one.
struct SingleLevel {
  std::unique_ptr<SingleMatrix> matrix, interpolation;
};

class LawLevels {
public:
  /// This process's rows of H, symmetric in its pattern.
  void set(const Distribution& distribution, const HviPetscMatrix& h);
  /// Nothing is added any more until others are set; false: nothing was.
  bool leave() { return std::exchange(any_, false); }
  /// The levels will have other interpolations.
  void forget_levels() { levels_.clear(); }
  /// Adds to each of the levels, the finest one first, what it has of H. Returns what the coarsest
  /// one has, which is not among them; null: nothing.
  Mat spread(const std::vector<SingleLevel>& levels);
  double bytes() const; ///< of this process

private:
  /// What is kept while H has the same pattern.
  struct Level {
    std::vector<int> rows;          ///< of this process, with entries
    Owned<Mat> interpolation, next; ///< of these rows; H on the next level
    void make(Mat h, const SingleLevel& of);
    void refresh(Mat h);
  };

  bool any_ = false; ///< has any process an entry?
  Rows own_;
  Owned<Mat> finest_;
  std::vector<Level> levels_;
};

} // namespace hvi::petsc_module
