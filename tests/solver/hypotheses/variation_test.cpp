// Lipschitz constants of expressions, in any units.
#include "solver/common/numbers.hpp"
#include "solver/hypotheses/variation.hpp"
#include "solver/kernel/algebra.hpp"
#include "solver/kernel/slot.hpp"

#include <gtest/gtest.h>

namespace hvi::solver {
namespace {

Variation of(const Expr& f) {
  const auto up_to = [](Slot, double reach) { return Bounds{-reach, reach}; };
  return VariationSearch(up_to, 2).of(f, {slot::argument(0), slot::argument(1)});
}

const Expr x = Expr::variable(slot::argument(0)), y = Expr::variable(slot::argument(1));

TEST(Variation, WhatGrowsWithoutEndIsSeenWhateverItsSize) {
  for (const double size : {1e-20, 1e-9, 1.0, 1e12})
    EXPECT_EQ(of(size * x * y).everywhere.low, infinity) << size;
}

TEST(Variation, WhatIsBoundedFarOutIsFoundWhateverItsReach) {
  for (const double reach : {1e-9, 1.0, 1e6})
    for (const double size : {1e-20, 1.0, 1e12})
      EXPECT_NEAR(of(size * min(abs(x), Expr(reach))).everywhere.low, size, 1e-6 * size) << reach;
}

} // namespace
} // namespace hvi::solver
