// Enclosures of an expression towards infinity: how fast it grows or dies.
#pragma once

#include "solver/kernel/interval.hpp"

namespace hvi::solver {

/// The ray r >= from (sign 1) or r <= -from (sign -1) of one slot; the others run through `box`.
struct Ray {
  Slot slot = 0;
  double sign = 1.0, from = 1.0; ///< from >= 3
};

/// Values a |r|^power (ln |r|)^log_power with a in `coefficient`, for every r of a ray. What grows
/// faster than every power (exp) has a large power and a coefficient without upper end; what dies
/// faster a large negative power.
struct Tail {
  Bounds coefficient;
  double power = 0.0, log_power = 0.0;

  /// Does it tend to infinity, if its coefficient has one sign?
  bool grows() const { return power > 0.0 || (power == 0.0 && log_power > 0.0); }
};

/// Encloses e on a ray by rules for sums, products, powers, exp and log of such values; functions
/// of a bounded range by intervals. Certain, not sharp: an unknown value has the coefficient
/// (-inf, inf) and power 0.
Tail tail_of(const Expr& e, const Ray& ray, const std::function<Bounds(Slot)>& box);

/// All values of a tail on its ray.
Bounds range_of(const Tail& tail, const Ray& ray);

} // namespace hvi::solver
