// Interval enclosures of expressions: proofs instead of samples, e.g. for the slope of a law.
#pragma once

#include "solver/kernel/expr.hpp"

#include <array>
#include <functional>
#include <limits>
#include <span>
#include <vector>

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

/// The same for many boxes: the walk over the expressions is prepared once.
class IntervalTape {
public:
  IntervalTape() = default;
  explicit IntervalTape(std::span<const Expr> outputs);

  const std::vector<Slot>& inputs() const { return inputs_; }
  /// Encloses the first out.size() outputs; one range per input, `work` is scratch. False: the
  /// first output may jump inside the box (a comparison or a sign is open there).
  bool operator()(std::span<const Bounds> box, std::span<Bounds> out,
                  std::vector<Bounds>& work) const;

private:
  struct Step {
    Expr node;
    std::array<int, 3> args;
    int input; ///< of a slot; -1: none
  };
  std::vector<Step> steps_;
  std::vector<Slot> inputs_;
  std::vector<int> outputs_;
  int of_first_ = 0; ///< so many steps make the first output
};

} // namespace hvi::solver
