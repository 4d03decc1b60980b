// Fixed points of maps that need not contract.
#pragma once

#include "solver/linear/sparse.hpp"

#include <deque>
#include <utility>
#include <vector>

namespace hvi::solver {

/// Anderson's mixing (H. De Sterck, Y. He, O. A. Krzysik, Anderson Acceleration as a Krylov Method
/// with Application to Asymptotic Convergence Analysis, 2022, have it and its history from 1965):
/// of x_1, x_2, ... and their images g(x_i), the next argument is the image of the affine
/// combination of the last ones whose g(x) - x is the least. Of linear maps it finds the fixed
/// point in as many passes as there are unknowns, contraction or not. Where that takes long, as
/// with maps that are steep on a short range only, components stay between the last arguments
/// where g(x) - x was positive and negative; an end that is not found again for some passes is
/// forgotten, for the other components move the fixed point of one.
class Mixing {
public:
  /// `kinds`: of each component, from 0 on. Components of one kind are of one unit; gaps are
  /// measured by the sizes of their kinds.
  explicit Mixing(std::vector<int> kinds) : kinds_(std::move(kinds)) {}

  /// The argument after `x`, whose image is `image`.
  Vector next(const Vector& x, const Vector& image);

private:
  Vector mixed(const Vector& image, const Vector& gap);
  Vector by_size(const Vector& gap, const Vector& x, const Vector& image);
  void note_bracket(const Vector& x, const Vector& gap);
  void stay_inside(Vector& x) const;

  std::vector<int> kinds_;
  std::vector<double> sizes_; ///< of the kinds, from the first pass in which they are not zero
  int passes_ = 0;
  Vector low_, high_;          ///< g(x) - x was positive there, and negative
  std::vector<int> same_side_; ///< passes in a row with g(x) - x > 0; negative: below or at 0
  std::deque<Vector> changes_of_images_, changes_of_gaps_; ///< gaps by their sizes
  Vector last_image_, last_gap_;
};

} // namespace hvi::solver
