// What data do in time, against formulas whose breaks and scales are known; and the grids made of
// it.
#include "solver/plan/problem.hpp"
#include "solver/study/time_base.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace hvi::solver {
namespace {

const Expr t = Expr::variable(slot::t);
const Expr x = Expr::variable(slot::x(0));

Problem loaded(const Expr& f, double first = 0.0, double last = 1.0) {
  Problem problem;
  problem.mesh.kind = MeshSpec::Kind::interval;
  problem.time.is_static = false;
  for (int n = 0; n <= 8; ++n) problem.time.grid.push_back(first + (last - first) * n / 8);
  problem.loads.push_back({});
  problem.loads.back().entries.push_back({0, f});
  return problem;
}

Expr pulse(double a, double length) {
  return select(less(t, Expr(a)), Expr(0.0),
                select(less(t, Expr(a + length)), Expr(1.0), Expr(0.0)));
}

double shortest_around(const DataTimes& data, double at) {
  for (std::size_t i = 0; i + 1 < data.pieces.size(); ++i)
    if (data.pieces[i] <= at && at <= data.pieces[i + 1])
      return data.pieces[i + 1] - data.pieces[i];
  return 0.0;
}

TEST(DataTimes, RandomPulsesHoweverShort) {
  std::mt19937_64 random(1706);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int k = 0; k < 100; ++k) {
    const double scale = std::pow(10.0, 6 * unit(random) - 3), start = scale * (unit(random) - 0.5);
    const double a = start + scale * (0.1 + 0.7 * unit(random));
    const double length = scale * std::pow(10.0, -1 - 5 * unit(random));
    const auto data = data_times(loaded(pulse(a, length) * sin(x), start, start + scale), 1e-4);
    EXPECT_TRUE(data.complete);
    ASSERT_EQ(data.breaks.size(), 2U);
    EXPECT_NEAR(data.breaks[0].t, a, 1e-12 * scale);
    EXPECT_NEAR(data.breaks[1].t, a + length, 1e-12 * scale);
    EXPECT_TRUE(data.breaks[0].jump && data.breaks[1].jump);
  }
}

TEST(DataTimes, KinksAndJumpsAreToldApart) {
  const auto kink = data_times(loaded(abs(t - Expr(0.337))), 1e-4);
  ASSERT_EQ(kink.breaks.size(), 1U);
  EXPECT_FALSE(kink.breaks[0].jump);
  EXPECT_NEAR(kink.breaks[0].t, 0.337, 1e-15);
  const auto steep = data_times(loaded(Expr::make(Op::tanh, {(t - Expr(0.4)) / Expr(1e-6)})), 1e-4);
  EXPECT_TRUE(steep.breaks.empty()); // steep, but no jump
  EXPECT_LT(shortest_around(steep, 0.4), 4e-6);
  // min and max that choose the same formula on both sides, or that of a line through itself.
  EXPECT_TRUE(data_times(loaded(max(t, t * Expr(1.0) + abs(t) - t)), 1e-4).breaks.empty());
}

TEST(DataTimes, PiecesFollowWavesLayersAndPeaks) {
  const auto wave = data_times(loaded(sin(Expr(40.0) * t)), 1e-4);
  EXPECT_TRUE(wave.breaks.empty());
  for (std::size_t i = 0; i + 1 < wave.pieces.size(); ++i)
    EXPECT_LE(wave.pieces[i + 1] - wave.pieces[i], 2 * M_PI / 40.0 / 2);
  const auto layer = data_times(loaded(exp(Expr(-2e4) * t)), 1e-4);
  EXPECT_LT(shortest_around(layer, 0.0), 2e-4);
  EXPECT_LT(layer.pieces.size(), 30U);
  const Expr peak = exp(-pow((t - Expr(0.7123)) / Expr(1e-6), Expr(2.0)));
  const auto narrow = data_times(loaded(Expr(0.1) + peak), 1e-4);
  EXPECT_LT(shortest_around(narrow, 0.7123), 1e-5);
  EXPECT_LT(narrow.pieces.size(), 80U);
  // Without rules for intervals: what is sampled, not how large it is.
  const Expr relaxed = Expr(100.0) + Expr::make(Op::mittag_leffler, {Expr(1.5), Expr(1.0), -t});
  const auto smooth = data_times(loaded(relaxed), 1e-4);
  EXPECT_LT(smooth.pieces.size(), 30U);
  const auto line = data_times(loaded(Expr(3.0) * t - Expr(1.0)), 1e-4);
  EXPECT_EQ(line.pieces.size(), 3U);
}

TEST(DataTimes, SmallPartsAndMovingBreaksAreLeftOut) {
  const Expr noise = Expr(1e-9) * sin(Expr(1e4) * t);
  EXPECT_LT(data_times(loaded(t + x * noise), 1e-4).pieces.size(), 6U);
  // A pulse that travels has no time of its own; one whose height varies in space has.
  EXPECT_TRUE(data_times(loaded(select(less(t, x), Expr(0.0), Expr(1.0))), 1e-4).breaks.empty());
  const Expr standing = exp(x * t) * pulse(0.31, 0.02);
  EXPECT_EQ(data_times(loaded(standing), 1e-4).breaks.size(), 2U);
}

TEST(DataTimes, ImposedValuesOffsetsLawsAndKernels) {
  Problem problem = loaded(Expr(1.0));
  problem.space.dirichlet.push_back({});
  problem.space.dirichlet.back().value = {abs(t - Expr(0.2))};
  problem.law_terms.push_back({});
  problem.law_terms.back().rows.push_back({});
  problem.law_terms.back().rows.back().offset = pulse(0.4, 0.05);
  problem.laws.push_back({});
  problem.laws.back().expression = Expr::variable(slot::argument(0)) * pulse(0.6, 0.03);
  problem.histories.push_back({});
  problem.histories.back().kernel.expression =
      select(less(Expr::variable(slot::lag), Expr(0.25)), Expr(1.0), Expr(0.0));
  const auto data = data_times(problem, 1e-4);
  std::vector<double> times;
  for (const auto& b : data.breaks) times.push_back(b.t);
  for (const double b : {0.2, 0.4, 0.45, 0.6, 0.63, 0.25, 0.85, 0.88})
    EXPECT_TRUE(std::any_of(times.begin(), times.end(), [&](double v) {
      return std::abs(v - b) < 1e-12;
    })) << b;
  EXPECT_TRUE(data.breaks.front().imposed);
}

TEST(DataTimes, ABreakOfAnImposedValueStaysOneWhereAnotherMeetsIt) {
  Problem problem = loaded(Expr(1.0));
  problem.space.dirichlet.push_back({});
  problem.space.dirichlet.back().value = {abs(t - Expr(0.25)) + abs(t - Expr(0.5))};
  problem.histories.push_back({}); // passes the first on to the second
  problem.histories.back().kernel.expression =
      select(less(Expr::variable(slot::lag), Expr(0.25)), Expr(1.0), Expr(0.0));
  const auto data = data_times(problem, 1e-4);
  ASSERT_EQ(data.breaks.size(), 3U); // .25, .5, and .75 from it
  EXPECT_TRUE(data.breaks[0].imposed && data.breaks[1].imposed);
  EXPECT_FALSE(data.breaks[2].imposed);
}

TEST(DataTimes, NothingHappensInNoTime) {
  Problem problem = loaded(t);
  problem.time.grid.resize(1);
  EXPECT_TRUE(data_times(problem, 1e-4).pieces.empty());
  problem = loaded(t);
  problem.time.is_static = true;
  EXPECT_TRUE(data_times(problem, 1e-4).pieces.empty());
}

TEST(TimeBase, AGridHasBothSidesOfAJumpAndNeighboursWithinAFactorTwo) {
  const Problem problem = loaded(pulse(0.4, 1e-3));
  const auto base = data_base(problem.time, data_times(problem, 1e-4));
  EXPECT_EQ(base.power, 0.0);
  for (const double jump : {0.4, 0.401}) {
    const auto after = std::upper_bound(base.grid.begin(), base.grid.end(), jump);
    EXPECT_NEAR(*after, jump, 3e-9);
    EXPECT_NEAR(*(after - 1), jump, 3e-9);
    EXPECT_TRUE(is_jump(base, static_cast<std::size_t>(after - base.grid.begin()) - 1));
  }
  double before = 0.0;
  for (std::size_t i = 0; i + 1 < base.grid.size(); ++i) {
    const double length = base.grid[i + 1] - base.grid[i];
    if (before > 0.0 && !is_jump(base, i)) {
      EXPECT_LT(std::max(length / before, before / length), 2.2);
    }
    before = is_jump(base, i) ? 0.0 : length;
  }
}

TEST(TimeBase, SmoothDataLeaveAUniformGrid) {
  const Problem problem = loaded(sin(Expr(2.5) * t) * x);
  const auto base = data_base(problem.time, data_times(problem, 1e-4));
  EXPECT_EQ(base.power, 1.0);
  EXPECT_EQ(base.coarsest, 4);
  const Problem fast = loaded(sin(Expr(40.0) * t) * x);
  EXPECT_GE(data_base(fast.time, data_times(fast, 1e-4)).coarsest, 16);
}

TEST(TimeBase, RefiningKeepsTheTimesThereAre) {
  const Problem problem = loaded(pulse(0.4, 0.1));
  const auto base = data_base(problem.time, data_times(problem, 1e-4));
  std::vector<int> cut(base.grid.size() - 1, 0);
  cut.front() = 2;
  const auto finer = refined_base(base, cut);
  for (const double v : base.grid)
    EXPECT_TRUE(std::binary_search(finer.grid.begin(), finer.grid.end(), v));
  EXPECT_GE(finer.grid.size(), base.grid.size() + 3);
}

} // namespace
} // namespace hvi::solver
