// Zeros of a function of one variable, isolated by interval arithmetic: where the sides of a
// comparison meet, where an absolute value has its kink.
#pragma once

#include "solver/kernel/expr.hpp"

#include <vector>

namespace hvi::solver {

struct Zeros {
  std::vector<double> at; ///< sorted
  /// Every point that is not named is proved to be none, but for zeros closer together than 1e-8 of
  /// the interval. False: the work allowed was used up, or a function has no interval rule; what is
  /// named is then what sign changes on the parts that were left show.
  bool complete = true;
};

/// The zeros of `f` in [low, high]: parts where the bounds of f exclude 0 are dropped, parts where
/// those of f' do are bisected, others are halved (Moore, Kearfott and Cloud, "Introduction to
/// Interval Analysis", 2009, section 8.1). Double zeros are found where f' changes sign. Stretches
/// on which f vanishes have none. `f` depends on `variable` only.
Zeros zeros(const Expr& f, Slot variable, double low, double high);

} // namespace hvi::solver
