// Constants by proof: narrow features, growth, place and time; switches against a dense scan.
#include "laws.hpp"
#include "solver/law/known_constants.hpp"
#include "solver/law/law_failure.hpp"
#include "solver/law/reach.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace hvi::solver::test {
namespace {

const double inf = std::numeric_limits<double>::infinity();
Expr tanh_of(const Expr& e) { return Expr::make(Op::tanh, {e}); }
Expr log_of(const Expr& e) { return Expr::make(Op::log, {e}); }

void expect_proved(const Bracket& b, double value) {
  EXPECT_EQ(b.how(), Provenance::proved) << b.low << " " << b.high;
  EXPECT_LE(b.low, value * (1 + 1e-12));
  EXPECT_GE(b.high, value * (1 - 1e-12));
}

/// Analytic: sup -(exp(-z^2))' = sqrt(2 / e), scaled by the width.
TEST(KnownConstants, SeeDipsOfAnyWidth) {
  for (const double w : {1.0, 1e-3, 1e-6, 1e-9})
    for (const double at : {0.0, 0.37, -12.5}) {
      const Expr z = (arg() - Expr(at)) / Expr(w);
      const Law law = slope_law("dip", exp(-pow(z, 2.0)));
      expect_proved(known_constants(law, {}, 0.0).m, std::sqrt(2.0 / std::exp(1.0)) / w);
    }
}

/// Analytic: 5 - 2 / w at the middle of the step.
TEST(KnownConstants, SeeNarrowStepsThatGoDown) {
  for (const double w : {1e-2, 1e-4, 1e-7}) {
    const Expr step = Expr(1.0) - tanh_of((arg() - Expr(0.0487)) / Expr(w));
    const Law law = slope_law("step", Expr(5.0) * arg() + Expr(2.0) * step);
    expect_proved(known_constants(law, {}, 0.0).m, 2.0 / w - 5.0);
  }
}

/// Analytic: the slope of k erfc(z/w) falls by 2 k/(w sqrt(pi)) at 0, that of k erfcx(|z|/w)
/// likewise, on both sides of a jump of its slope.
TEST(KnownConstants, OfErrorFunctions) {
  for (const double w : {1.0, 1e-3, 1e-6}) {
    const Expr z = (arg() - Expr(0.37)) / Expr(w);
    const double steepest = 2.0 / (w * std::sqrt(M_PI));
    expect_proved(
        known_constants(slope_law("left", Expr(3.0) * Expr::make(Op::erfc, {z})), {}, 0.0).m,
        3.0 * steepest);
    expect_proved(
        known_constants(slope_law("scaled", Expr::make(Op::erfcx, {Expr(0.0), abs(z)})), {}, 0.0).m,
        steepest);
  }
  // exp(r^2) on the left: no finite number
  const KnownConstants left =
      known_constants(slope_law("left", Expr::make(Op::erfcx, {Expr(0.0), arg()})), {}, 0.0);
  EXPECT_EQ(left.m.low, inf);
  EXPECT_EQ(left.c.low, inf);
}

TEST(KnownConstants, TellSlowGrowthFromLinear) {
  const Expr r = arg();
  const auto growth = [](const Expr& e) { return known_constants(slope_law("g", e), {}, 0.0).c; };
  for (const Expr& e :
       {r * log_of(Expr(1.0) + abs(r)), r * pow(abs(r), 0.01), Expr::make(Op::sinh, {r})})
    EXPECT_EQ(growth(e).value(), inf) << to_string(e);
  EXPECT_EQ(growth(r * log_of(Expr(1.0) + abs(r))).low, inf);
  expect_proved(growth(Expr(3.0) * r + log_of(Expr(1.0) + pow(r, 2.0)) * Expr(0.0)), 3.0);
  const Bracket root = growth(Expr(2.0) * sqrt(Expr(1.0) + pow(r, 2.0))); // its limit at infinity
  EXPECT_LE(root.low, 2.0);
  EXPECT_GE(root.high, 2.0);
  EXPECT_LE(root.high, 2.001);
}

LawDomain floor_of(int cells) {
  LawDomain out;
  for (int i = 0; i < cells; ++i)
    out.part.push_back({{Point{double(i) / cells, 0, 0}, Point{(i + 1.0) / cells, 0, 0}}, 2});
  out.t_low = 0.0, out.t_high = 1.0;
  return out;
}

TEST(KnownConstants, HoldOverThePartAndAllTimes) {
  const Expr r = arg(), hat = max(Expr(0.0), Expr(1.0) - abs(x0() - Expr(0.5035)) / Expr(0.001));
  const Law peak = potential_law("peak", Expr(-500.0) * hat * r * r);
  expect_proved(known_constants(peak, floor_of(40)).m, 1000.0);
  const Expr on = select(less(time_(), Expr(0.3)), Expr(0.0),
                         select(less(time_(), Expr(0.35)), Expr(1.0), Expr(0.0)));
  const Law pulse = potential_law("pulse", Expr(-2.5) * on * r * r);
  expect_proved(known_constants(pulse, floor_of(1)).m, 5.0);
}

/// A part that is not the whole of its box: only its points count as seen.
TEST(KnownConstants, DoNotSeePlacesBesideThePart) {
  LawDomain two;
  two.part.push_back({{Point{0, 0, 0}, Point{0.2, 0, 0}}, 2});
  two.part.push_back({{Point{0.8, 0, 0}, Point{1, 0, 0}}, 2});
  const Law law = slope_law("between", -exp(-pow((x0() - Expr(0.5)) / Expr(0.1), 2.0)) * arg());
  expect_proved(known_constants(law, two).m, std::exp(-9.0));
}

TEST(KnownConstants, FindJumpsDownThatMoveOrHide) {
  const Expr r = arg(), hat = max(Expr(0.0), Expr(1.0) - abs(x0() - Expr(0.7123)) / Expr(0.001));
  const Law drops = slope_law("drops", select(less(r, x0()), r, r - hat));
  EXPECT_EQ(known_constants(drops, floor_of(4)).m.value(), inf);
  const Law rises = slope_law("rises", select(less(r, x0()), r, r + hat));
  expect_proved(known_constants(rises, floor_of(4)).m, 0.0);
  const Expr bound = Expr(0.1) + x0() + time_();
  const Law flat = slope_law("flat", select(less(r, bound), Expr(7.0) * r, Expr(7.0) * bound));
  expect_proved(known_constants(flat, floor_of(4)).m, 0.0);
  const Law kink = potential_law("kink", -abs(r - bound));
  EXPECT_EQ(known_constants(kink, floor_of(4)).m.low, inf);
}

/// What falls like a root, or like r log(r), has no m_J: it is infinite by proof, as is the ascent
/// of what rises so. Sampling sees numbers of 1e100.
TEST(KnownConstants, OfRootsAreInfinite) {
  const Expr r = arg();
  for (const double at : {0.0, 0.3, -7.1}) {
    const Expr x = r - Expr(at);
    const auto above = [&](const Expr& e) {
      return known_constants(slope_law("root", select(less_equal(x, Expr(0.0)), Expr(0.0), e)), {},
                             0.0);
    };
    const std::vector<Expr> falling{-sqrt(x), Expr(2.0) * x - pow(x, 0.9), x * log_of(x),
                                    sqrt(x) * log_of(x), -sqrt(x) / (Expr(1.0) + x)};
    for (const Expr& e : falling) {
      const KnownConstants k = above(e);
      EXPECT_EQ(k.m.low, inf) << to_string(e) << " at " << at;
      EXPECT_EQ(k.worst_at, at);
      EXPECT_FALSE(k.jumps_down);
      EXPECT_TRUE(k.clarke_regular);
    }
    const KnownConstants rises = above(sqrt(x));
    expect_proved(rises.m, 0.0);
    EXPECT_EQ(rises.steepest_ascent.low, inf);
    EXPECT_TRUE(std::isfinite(above(-pow(x, 1.5) / (Expr(1.0) + x)).m.value()));
  }
  const Law cube = slope_law("cube", -pow(r, 3.0)); // ever more steeply
  EXPECT_EQ(known_constants(cube, {}, 0.0).m.low, inf);
  EXPECT_FALSE(known_constants(cube, {}, 0.0).jumps_down);
  const Law drop = slope_law("drop", select(less(r, Expr(0.3)), r, Expr(0.0)));
  EXPECT_TRUE(known_constants(drop, {}, 0.0).jumps_down);
  // over a part and all times, where the end of the piece moves; and for a run
  const Expr moving = r - Expr(0.1) * x0() - time_();
  const Law law =
      slope_law("moving", select(less_equal(moving, Expr(0.0)), Expr(0.0), -sqrt(moving)));
  for (const KnownConstants& k :
       {known_constants(law, floor_of(4)), steepest_descent(law, floor_of(4))}) {
    EXPECT_EQ(k.m.low, inf);
    EXPECT_FALSE(k.jumps_down);
  }
  const Law still = slope_law("still", select(less_equal(r, Expr(0.0)), Expr(0.0), -sqrt(r)));
  EXPECT_EQ(steepest_descent(still, floor_of(4)).m.low, inf);
}

/// A wall that stands at 0 is no size of multipliers: beside 1e300 every error would be none.
TEST(KnownConstants, AWallIsNoScale) {
  const Expr r = arg();
  for (const double gap : {0.0, 0.5}) {
    const Law floor = slope_law("floor", select(less_equal(r, Expr(gap)), Expr(-1e300), Expr(3.0)));
    EXPECT_EQ(known_constants(floor, {}, 0.0).slope_scale, 3.0);
  }
}

/// Pieces that meet but for the rounding of terms far larger than their values do not jump.
TEST(KnownConstants, RoundingIsNoJump) {
  const Expr r = arg(), root = Expr(-1.462) * sqrt(Expr(0.0294) + pow(r, 2.0));
  const double here = -1.462 * std::sqrt(0.0294 + 0.148 * 0.148);
  const Law law =
      slope_law("seam", select(less(r, Expr(-0.148)), Expr(1e-17) * exp(r), root + Expr(-here)));
  EXPECT_LT(known_constants(law, {}, 0.0).m.value(), 10.0);
}

TEST(LawGraph, HasJumpsWhereOneArgumentHasManySlopes) {
  const Expr r = arg();
  const auto jumps = [&](const Expr& slope, bool radial = false) {
    return has_jumps(slope_law("a", slope, radial).graph({}, 0.0), radial);
  };
  EXPECT_TRUE(jumps(select(less(r, Expr(0.0)), Expr(0.0), Expr(1e-9))));
  EXPECT_TRUE(jumps(select(less(r, Expr(0.0)), Expr(2.0), Expr(1.0))));   // down
  EXPECT_TRUE(jumps(select(less(r, Expr(0.1)), Expr(0.0), Expr(1e300)))); // a wall
  EXPECT_FALSE(jumps(select(less(r, Expr(0.3)), Expr(0.1) * r, Expr(0.3) * r - Expr(0.06))));
  EXPECT_FALSE(jumps(Expr(3.0)));      // a force
  EXPECT_TRUE(jumps(Expr(3.0), true)); // friction
  EXPECT_FALSE(jumps(r, true));
}

/// Random sums of waves and powers, and the cases they choose: all changes of sign of a scan of
/// 100,000 points are breaks.
TEST(Switches, AreAllFound) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int scene = 0; scene < 20; ++scene) {
    const double a = 100.0 * any(random), b = 3.0 * any(random), c = 0.9 * any(random),
                 k = 300.0 * any(random);
    const Expr r = arg();
    const Expr f = Expr::make(Op::sin, {Expr(a) * r}) + Expr(b) * pow(r - Expr(c), 3.0) +
                   Expr(c) * Expr::make(Op::cos, {Expr(k) * r});
    const Law law =
        slope_law("waves", select(less(r, Expr(0.0)), Expr(0.0),
                                  select(less(Expr(1.0), r), Expr(0.0),
                                         select(less(f, Expr(0.0)), Expr(1.0), Expr(2.0)))));
    const auto breaks = law.graph({}, 0.0).breaks;
    const auto value = [&](double s) {
      return std::sin(a * s) + b * std::pow(s - c, 3) + c * std::cos(k * s);
    };
    const int n = 100000;
    int turns = 0;
    for (int i = 0; i < n; ++i) {
      const double p = double(i) / n, q = (i + 1.0) / n;
      if (!(value(p) * value(q) < 0.0)) continue;
      ++turns;
      EXPECT_TRUE(
          std::any_of(breaks.begin(), breaks.end(), [&](double s) { return s >= p && s <= q; }))
          << "scene " << scene << " at " << p;
    }
    EXPECT_LE(turns, static_cast<int>(breaks.size()));
    EXPECT_GE(turns + 2 + 4, static_cast<int>(breaks.size())) << "scene " << scene;
  }
}

TEST(Switches, ThatTurnForEverAreRefusedWithTheirPlace) {
  const Expr condition = less(Expr::make(Op::sin, {Expr(200.0) * arg()}), Expr(0.0));
  try {
    const Law law = slope_law("comb", select(condition, Expr(0.0), Expr(1.0)));
    FAIL() << "accepted";
  } catch (const LawFailure& failure) {
    ASSERT_TRUE(failure.condition);
    EXPECT_EQ(*failure.condition, condition);
    EXPECT_THAT(failure.what(), testing::HasSubstr("sin(200 * r)"));
  }
}

TEST(Cases, ThatNoArgumentReaches) {
  const Expr r = arg();
  using testing::ElementsAre;
  const auto below = [&](double b) { return less(r, Expr(b)); };
  EXPECT_THAT(unreached_cases({below(0.08), below(0.02)}, false), ElementsAre(1));
  EXPECT_THAT(unreached_cases({below(0.02), below(0.08)}, false), ElementsAre());
  EXPECT_THAT(unreached_cases({below(0.0), less_equal(r, Expr(0.0))}, false), ElementsAre());
  EXPECT_THAT(unreached_cases({less_equal(r, Expr(0.0)), below(0.0), below(1.0)}, false),
              ElementsAre(1));
  EXPECT_THAT(unreached_cases({below(0.0), below(1.0)}, true), ElementsAre(0));
  EXPECT_THAT(unreached_cases({below(4.0), less(r * r * r, Expr(8.0))}, false), ElementsAre(1));
  EXPECT_THAT(unreached_cases({below(1.0), less(r, x0())}, false), ElementsAre());
}

} // namespace
} // namespace hvi::solver::test
