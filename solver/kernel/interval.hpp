// Interval enclosures of expressions: proofs instead of samples, e.g. for the slope of a law.
#pragma once

#include "solver/kernel/expr.hpp"

#include <functional>
#include <limits>

namespace hvi::solver {

/// An enclosure [low, high]. Values where something is undefined (NaN, a pole) are not enclosed:
/// `defined` says whether there may be such points.
struct Bounds {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool known = true;   ///< false: an operation had no rule; infinite ends then prove nothing
  bool defined = true; ///< false: undefined at some points, perhaps

  bool contains(double v) const { return low <= v && v <= high; }
};

/// Encloses all values of `e` while each slot runs through box(slot), independently of the others.
/// Rounded outwards, also for what the library's functions may be off. Each occurrence of a
/// slot counts as independent, so that bounds are certain, not sharp.
Bounds bounds(const Expr& e, const std::function<Bounds(Slot)>& box);

} // namespace hvi::solver
