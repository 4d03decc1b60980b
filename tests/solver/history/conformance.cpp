// The conformance suite: one set of checks that every route passes for every kernel it accepts, on
// every kind of grid, for both orders. Reference: brute-force sums (independent).
#include "cases.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <tuple>

namespace hvi::solver::test {
namespace {

struct ConformanceCase {
  std::string kernel;
  HistoryRoute route;
  Grid grid;
  int order;
};

std::string name_of(const ConformanceCase& c) {
  const char* routes[] = {"automatic", "recursion", "fit", "tree", "direct"};
  const char* grids[] = {"uniform", "graded", "listed"};
  return c.kernel + "_" + routes[static_cast<int>(c.route)] + "_" +
         grids[static_cast<int>(c.grid)] + "_order" + std::to_string(c.order);
}
std::ostream& operator<<(std::ostream& out, const ConformanceCase& c) { return out << name_of(c); }

bool accepts(HistoryRoute route, const KernelCase& kernel) {
  switch (route) {
  case HistoryRoute::recursion:
    return kernel.recursion;
  case HistoryRoute::fit:
    return kernel.fit;
  default:
    return true;
  }
}

std::vector<ConformanceCase> all_conformance_cases() {
  std::vector<ConformanceCase> cases;
  for (const KernelCase& kernel : kernel_cases()) {
    for (const HistoryRoute route :
         {HistoryRoute::recursion, HistoryRoute::fit, HistoryRoute::tree, HistoryRoute::direct}) {
      if (!accepts(route, kernel)) continue;
      for (const Grid g : {Grid::uniform, Grid::graded, Grid::listed}) {
        for (const int order : {0, 1}) cases.push_back({kernel.name, route, g, order});
      }
    }
  }
  return cases;
}

constexpr double wanted_error = 1e-8;

class Conformance : public testing::TestWithParam<ConformanceCase> {
protected:
  const KernelCase& kernel() const { return kernel_case(GetParam().kernel); }
  std::unique_ptr<History> make(const std::vector<double>& times) const {
    HistoryOptions options;
    options.route = GetParam().route;
    options.order = GetParam().order;
    options.tolerance = wanted_error;
    options.horizon = times.back();
    options.shortest_step = shortest_step(times);
    options.steps = static_cast<std::int64_t>(times.size()) - 1;
    options.times = times;
    return make_history({kernel().name, {}, kernel().expression}, field_size, options);
  }
  /// Relative to ||q||_L1 max|u|; exact routes to rounding.
  double allowed() const {
    const double l1 = std::max(1e-3, std::abs(reference_integral(kernel(), 2.0, 0, 2.0, 0)));
    const bool exact =
        GetParam().route == HistoryRoute::recursion || GetParam().route == HistoryRoute::direct;
    return l1 * 3.0 * (exact ? 2e-12 : wanted_error);
  }
};

std::vector<double> rhs_of(History& history, double t) {
  std::vector<double> out(field_size, -7.0);
  history.rhs(t, out);
  return out;
}

TEST_P(Conformance, AgreesWithTheDefinition) {
  const auto times = grid(GetParam().grid, 60);
  const auto history = make(times);
  history->start(0, sample_field(0));
  for (std::size_t n = 1; n < times.size(); ++n) {
    const auto rhs = rhs_of(*history, times[n]);
    const double w0 = history->w0(times[n]);
    if (n < 5 || n % 11 == 0 || n + 1 == times.size()) {
      const BruteForce expected = brute_force(kernel(), times, n, GetParam().order);
      for (std::size_t i = 0; i < field_size; ++i) {
        EXPECT_NEAR(rhs[i], expected.rhs[i], allowed()) << "step " << n << " component " << i;
      }
      EXPECT_NEAR(w0, expected.w0, 1e-12 * (std::abs(expected.w0) + 1e-3)) << "step " << n;
    }
    history->commit(times[n], sample_field(times[n]));
  }
}

/// A step tried with other times and given up changes no bit of what follows.
TEST_P(Conformance, RejectedStepsLeaveNoTrace) {
  const auto times = grid(GetParam().grid, 40);
  const auto plain = make(times), disturbed = make(times);
  plain->start(0, sample_field(0));
  disturbed->start(0, sample_field(0));
  for (std::size_t n = 1; n < times.size(); ++n) {
    const double t = times[n], k = t - times[n - 1];
    for (const double other : {std::min(t + k, times.back()), t - 0.5 * k, t}) {
      rhs_of(*disturbed, other);
      disturbed->w0(other);
    }
    ASSERT_EQ(rhs_of(*plain, t), rhs_of(*disturbed, t)) << "step " << n;
    ASSERT_EQ(plain->w0(t), disturbed->w0(t));
    plain->commit(t, sample_field(t));
    disturbed->commit(t, sample_field(t));
  }
}

TEST_P(Conformance, ARestoredHistoryContinuesWithTheSameBits) {
  const auto times = grid(GetParam().grid, 40);
  const auto original = make(times);
  original->start(0, sample_field(0));
  for (std::size_t n = 1; n <= 20; ++n) {
    rhs_of(*original, times[n]);
    original->commit(times[n], sample_field(times[n]));
  }
  std::stringstream state;
  original->save(state);
  const auto restored = make(times);
  restored->restore(state);
  for (std::size_t n = 21; n < times.size(); ++n) {
    ASSERT_EQ(rhs_of(*original, times[n]), rhs_of(*restored, times[n])) << "step " << n;
    ASSERT_EQ(original->w0(times[n]), restored->w0(times[n]));
    original->commit(times[n], sample_field(times[n]));
    restored->commit(times[n], sample_field(times[n]));
  }
  EXPECT_EQ(original->report().fields, restored->report().fields);
}

TEST_P(Conformance, ATruncatedStateIsAnError) {
  const auto times = grid(GetParam().grid, 10);
  const auto history = make(times);
  history->start(0, sample_field(0));
  history->commit(times[1], sample_field(times[1]));
  std::stringstream state;
  history->save(state);
  std::stringstream half(state.str().substr(0, state.str().size() / 2));
  EXPECT_THROW(history->restore(half), Failure);
}

INSTANTIATE_TEST_SUITE_P(Routes, Conformance, testing::ValuesIn(all_conformance_cases()),
                         [](const auto& param) { return name_of(param.param); });

} // namespace
} // namespace hvi::solver::test
