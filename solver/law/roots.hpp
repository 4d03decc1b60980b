// Real roots of a smooth function of the law's argument at a point of space and time.
#pragma once

#include "solver/law/point_tape.hpp"

#include <vector>

namespace hvi::solver {

/// Solves f(r; x, t) = target. Affine in r: closed form -b/a, exact. Otherwise a scan of f and f'
/// over sixteen points a decade from 1e-30 to 1e15 on both sides of 0 brackets simple roots, close
/// pairs and double roots, and TOMS 748 takes each to the last bit.
class RootFinder {
public:
  explicit RootFinder(const Expr& f);
  /// Appends the roots inside the open interval (low, high).
  void find(const Point& x, LawTime t, double target, double low, double high,
            std::vector<double>& roots) const;

private:
  void scan(const Point& x, LawTime t, double target, double low, double high,
            std::vector<double>& roots) const;
  bool affine_ = false;
  PointTape tape_; ///< affine: the coefficients a, b; else f, f'
};

} // namespace hvi::solver
