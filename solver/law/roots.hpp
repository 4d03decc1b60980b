// Real roots of a smooth function of the law's argument at a point of space and time.
#pragma once

#include "solver/kernel/interval.hpp"
#include "solver/law/point_tape.hpp"

#include <vector>

namespace hvi::solver {

/// Solves f(r; x, t) = target. Affine in r: closed form -b/a, exact. Otherwise intervals isolate
/// the roots with |r| <= 1e15: an interval is dropped when the enclosure of f there excludes the
/// target, cut in monotone parts where the enclosure of f' or f'' has one sign, halved where
/// nothing is certain; TOMS 748 takes each root to the last bit. Roots closer than 1e-9 of their
/// size count as one.
class RootFinder {
public:
  explicit RootFinder(const Expr& f);
  bool affine() const { return affine_; }
  /// Appends the roots inside the open interval (low, high). `crossings`: only those where f
  /// changes its sign are wanted. False: there are more than `most_roots`, or they cannot be
  /// isolated.
  bool find(const Point& x, LawTime t, double target, double low, double high, bool crossings,
            std::vector<double>& roots) const;

  static constexpr std::size_t most_roots = 1000;

private:
  friend class RootIsolation;
  bool affine_ = false;
  PointTape tape_;         ///< affine: the coefficients a, b; else f, f'
  IntervalTape intervals_; ///< f, f', f''
};

} // namespace hvi::solver
