// The size of an unknown without a form of its own.
#pragma once

#include "solver/discrete/discretisation.hpp"
#include "solver/discrete/state.hpp"

#include <vector>

namespace hvi::solver {

/// |p| in L2, of a pressure say. Where no other unknown sees the constants on a piece of its
/// domain, and imposed values fix them (a pressure at a point of a closed vessel), |p - mean of p|
/// there: then p is what is left of L2 without the constants, and where they are fixed says nothing
/// of how well the others see it.
class MultiplierNorm {
public:
  MultiplierNorm(const Problem& problem, const Discretisation& discretisation,
                 const StateLayout& layout, int unknown);
  /// M p, |p|^2 = p . M p, of all unknowns; p is 0 in those of others.
  Vector times(const Vector& p) const;
  /// Of M, with the means.
  Vector diagonal() const { return l2_.diagonal(); }
  bool leaves_out_means() const { return !means_.empty(); }

private:
  struct Mean {
    Vector integral; ///< int p is its product with p
    double measure = 0.0;
  };
  SparseMatrix l2_;
  std::vector<Mean> means_;
};

} // namespace hvi::solver
