// N = 2,000 steps: every route against the direct sum, on uniform and graded grids; what it stores;
// horizons extended; long runs against closed forms.
#include "cases.hpp"
#include "solver/common/stream.hpp"
#include "solver/history/independent.hpp"
#include "solver/history/prepared.hpp"

#include <boost/math/special_functions/erf.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <sstream>

namespace hvi::solver::test {
namespace {

constexpr double tolerance = 1e-8;

HistoryOptions options_for(const std::vector<double>& times, HistoryRoute route, int order) {
  HistoryOptions options;
  options.route = route;
  options.order = order;
  options.tolerance = tolerance;
  options.horizon = times.back();
  options.shortest_step = shortest_step(times);
  options.steps = static_cast<std::int64_t>(times.size()) - 1;
  options.times = times;
  return options;
}

struct Case {
  std::string kernel;
  Grid grid;
};
std::string name_of(const Case& c) {
  return c.kernel + (c.grid == Grid::uniform ? "_uniform" : "_graded");
}
std::ostream& operator<<(std::ostream& out, const Case& c) { return out << name_of(c); }

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const KernelCase& kernel : kernel_cases()) {
    for (const Grid g : {Grid::uniform, Grid::graded}) cases.push_back({kernel.name, g});
  }
  return cases;
}

class ManySteps : public testing::TestWithParam<Case> {};

/// Reference: the direct route (independent of the others; itself checked against brute force).
TEST_P(ManySteps, AgreesWithTheDirectSum) {
  const KernelCase& kernel = kernel_case(GetParam().kernel);
  const auto times = grid(GetParam().grid, 2000);
  const int order = GetParam().grid == Grid::uniform ? 0 : 1;
  const KernelSpec spec{kernel.name, {}, kernel.expression};
  const double l1 = kernel_norms(kernel.expression, 0, times.back()).l1;
  std::vector<std::unique_ptr<History>> routes;
  routes.push_back(make_history(spec, field_size, options_for(times, HistoryRoute::direct, order)));
  routes.push_back(
      make_history(spec, field_size, options_for(times, HistoryRoute::automatic, order)));
  routes.push_back(make_history(spec, field_size, options_for(times, HistoryRoute::tree, order)));
  for (auto& route : routes) route->start(0, sample_field(0));
  std::vector<double> expected(field_size), found(field_size);
  for (std::size_t n = 1; n < times.size(); ++n) {
    // The direct sum is asked at some steps only: it is what takes the time.
    const bool compare = n < 20 || n % 97 == 0 || n + 1 == times.size();
    if (compare) routes[0]->rhs(times[n], expected);
    for (std::size_t r = 1; r < routes.size() && (compare || n % 3 == 0); ++r) {
      routes[r]->rhs(times[n], found);
      if (!compare) continue;
      for (std::size_t i = 0; i < field_size; ++i) {
        ASSERT_NEAR(found[i], expected[i], tolerance * l1 * 2.2)
            << routes[r]->report().route << ", step " << n << ", component " << i;
      }
      ASSERT_NEAR(routes[r]->w0(times[n]), routes[0]->w0(times[n]), 1e-13 * l1);
      const double bound = 2.2 * l1 * (routes[r]->report().error + 1e-11); // with rounding
      for (std::size_t i = 0; i < field_size; ++i) ASSERT_NEAR(found[i], expected[i], bound);
    }
    for (auto& route : routes) route->commit(times[n], sample_field(times[n]));
  }
  EXPECT_LE(routes[1]->report().error, tolerance);
  EXPECT_LE(routes[2]->report().error, 2 * tolerance);
}

INSTANTIATE_TEST_SUITE_P(Kernels, ManySteps, testing::ValuesIn(all_cases()),
                         [](const auto& param) { return name_of(param.param); });

HistoryReport report_after(const std::string& kernel, HistoryRoute route, int steps) {
  const auto times = grid(Grid::uniform, steps, 20.0);
  const auto history =
      make_history({kernel, {}, kernel_case(kernel).expression}, 1, options_for(times, route, 0));
  history->start(0, std::vector<double>{0.0});
  for (std::size_t n = 1; n < times.size(); ++n) {
    history->commit(times[n], std::vector<double>{std::sin(times[n])});
  }
  return history->report();
}

TEST(Storage, TheFittedRouteStoresAFewFields) {
  for (const char* kernel : {"power_50", "mittag_leffler", "stretched", "power_90"}) {
    const auto report = report_after(kernel, HistoryRoute::automatic, 20000);
    EXPECT_EQ(report.route, "fit") << kernel;
    EXPECT_LT(report.fields, 45) << kernel;
    EXPECT_TRUE(report.verified);
  }
}

TEST(Storage, TheTreeStoresLessThanThreeHundredFields) {
  for (const char* kernel : {"power_50", "aging", "aging_singular", "logarithm"}) {
    const auto report = report_after(kernel, HistoryRoute::tree, 10000);
    EXPECT_LT(report.fields, 300) << kernel;
    EXPECT_FALSE(report.verified);
  }
  EXPECT_LT(report_after("oscillating", HistoryRoute::tree, 10000).fields, 1200);
}

TEST(Storage, ADelayKeepsOnlyItsWindow) {
  const auto report = report_after("delay", HistoryRoute::automatic, 4000);
  EXPECT_EQ(report.route, "direct");
  EXPECT_LE(report.fields, 0.35 / 0.005 + 2);
}

/// Blocks beyond the last kink can be joined; those it still has to pass cannot.
TEST(Storage, ATreeJoinsBlocksBeyondAKink) {
  EXPECT_LT(report_after("kink", HistoryRoute::tree, 4000).fields, 1000);
}

/// What --profile shows as fields read.
TEST(Storage, AReadingOfTheFittedRouteReadsWhatIsStored) {
  const auto times = grid(Grid::uniform, 200, 20.0);
  const auto history = make_history({"power_50", {}, kernel_case("power_50").expression}, 1,
                                    options_for(times, HistoryRoute::fit, 0));
  double u = 0.0, past = 0.0;
  history->start(0, {&u, 1});
  for (std::size_t n = 1; n < times.size(); ++n) {
    const auto before = history->report().reads;
    history->rhs(times[n], {&past, 1});
    const auto after = history->report();
    EXPECT_NEAR(static_cast<double>(after.reads - before), static_cast<double>(after.fields), 2.0);
    history->commit(times[n], {&u, 1});
  }
}

TEST(Storage, AKinkKeepsItsWindowRawAndFitsTheRest) {
  const auto report = report_after("kink", HistoryRoute::automatic, 4000);
  EXPECT_EQ(report.route, "fit");
  EXPECT_LE(report.fields, 0.3 / 0.005 + 30);
}

/// Beyond the fitted horizon: either still within the tolerance, or an end that says so.
TEST(Horizon, IsExtendedOrRefused) {
  const auto times = grid(Grid::uniform, 500, 2.0);
  for (const HistoryRoute route : {HistoryRoute::fit, HistoryRoute::tree}) {
    for (const char* name : {"power_50", "rational", "stretched"}) {
      const KernelCase& kernel = kernel_case(name);
      const KernelSpec spec{name, {}, kernel.expression};
      const auto history = make_history(spec, field_size, options_for(times, route, 0));
      const auto direct =
          make_history(spec, field_size, options_for(times, HistoryRoute::direct, 0));
      history->start(0, sample_field(0));
      direct->start(0, sample_field(0));
      std::vector<double> a(field_size), b(field_size);
      const double l1 = kernel_norms(kernel.expression, 0, 6.0).l1;
      for (int n = 1; n <= 1500 && history->ended() == nullptr; ++n) {
        const double t = 2.0 * n / 500;
        history->rhs(t, a);
        if (n % 50 == 0 && history->ended() == nullptr) {
          direct->rhs(t, b);
          for (std::size_t i = 0; i < field_size; ++i) {
            ASSERT_NEAR(a[i], b[i], 7 * 2 * tolerance * l1) << name << " t = " << t;
          }
        }
        history->commit(t, sample_field(t));
        direct->commit(t, sample_field(t));
      }
      if (history->ended() != nullptr) {
        EXPECT_FALSE(history->ended()->help.empty());
      }
    }
  }
}

/// Blocks that were made for the planned time meet a bump of the kernel beyond it, which is small
/// beside the kernel and large beside the tolerance.
TEST(Horizon, OfATreeEndsWhereItsBlocksAreTooCoarse) {
  const auto times = grid(Grid::uniform, 500, 2.0);
  const Expr lag = Expr::variable(slot::lag);
  const Expr late = (lag - 3.0) / 0.1;
  const KernelSpec spec{"late", {}, 1.0 / (1.0 + lag) + 1e-4 * exp(-late * late)};
  const auto history = make_history(spec, field_size, options_for(times, HistoryRoute::tree, 0));
  const auto direct = make_history(spec, field_size, options_for(times, HistoryRoute::direct, 0));
  history->start(0, sample_field(0));
  direct->start(0, sample_field(0));
  std::vector<double> a(field_size), b(field_size);
  for (int n = 1; n <= 1500 && history->ended() == nullptr; ++n) {
    const double t = 2.0 * n / 500;
    history->rhs(t, a);
    direct->rhs(t, b);
    for (std::size_t i = 0; i < field_size; ++i) ASSERT_NEAR(a[i], b[i], 1e-7) << "t = " << t;
    history->commit(t, sample_field(t));
    direct->commit(t, sample_field(t));
  }
  EXPECT_NE(history->ended(), nullptr);
}

/// A field with one value for each step, which is 1 there and 0 elsewhere, gets the weights of the
/// steps: how far they are from the exact ones in all bounds the error of any field.
TEST(Storage, TheErrorOfATreeBoundsThatOfAnyField) {
  constexpr std::size_t steps = 600;
  const auto times = grid(Grid::uniform, steps, 6.0);
  for (const char* name : {"power_50", "aging", "logarithm", "oscillating"}) {
    auto options = options_for(times, HistoryRoute::tree, 0);
    options.tolerance = 1e-4;
    const KernelSpec spec{name, {}, kernel_case(name).expression};
    const auto tree = make_history(spec, steps, options);
    const auto direct = make_history(spec, steps, options_for(times, HistoryRoute::direct, 0));
    std::vector<double> u(steps, 0.0), a(steps), b(steps);
    tree->start(0, u);
    direct->start(0, u);
    double worst = 0.0;
    const double l1 = memory_norm(spec.expression, kernel_traits(spec, 6.0), 0, 6.0);
    for (std::size_t n = 1; n <= steps; ++n) {
      tree->rhs(times[n], a);
      direct->rhs(times[n], b);
      double off = 0.0;
      for (std::size_t i = 0; i < steps; ++i) off += std::abs(a[i] - b[i]);
      worst = std::max(worst, off / l1);
      std::fill(u.begin(), u.end(), 0.0);
      u[n - 1] = 1.0;
      tree->commit(times[n], u);
      direct->commit(times[n], u);
    }
    EXPECT_LE(worst, tree->report().error) << name;
    EXPECT_GT(worst, 1e-3 * options.tolerance) << name;
  }
}

/// An unknown horizon leaves the tree, which grows with the run.
TEST(Horizon, MayBeUnknown) {
  const KernelCase& kernel = kernel_case("power_50");
  const auto history = make_history({"q", {}, kernel.expression}, field_size, {});
  EXPECT_EQ(history->report().route, "tree");
  const auto direct =
      make_history({"q", {}, kernel.expression}, field_size, {.route = HistoryRoute::direct});
  history->start(0, sample_field(0));
  direct->start(0, sample_field(0));
  std::vector<double> a(field_size), b(field_size);
  for (int n = 1; n <= 3000; ++n) {
    const double t = 1e-3 * n;
    history->rhs(t, a);
    if (n % 100 == 0) {
      direct->rhs(t, b);
      for (std::size_t i = 0; i < field_size; ++i) {
        ASSERT_NEAR(a[i], b[i], 3.2 * 2e-8 * 2 * std::sqrt(t));
      }
    }
    history->commit(t, sample_field(t));
    direct->commit(t, sample_field(t));
  }
  EXPECT_LT(history->report().fields, 250);
}

TEST(Audit, FindsTheDifferenceToTheDirectSum) {
  const auto times = grid(Grid::uniform, 2000);
  const KernelSpec spec{"q", {}, kernel_case("power_50").expression};
  for (const double tol : {1e-3, 1e-8}) {
    auto options = options_for(times, HistoryRoute::fit, 0);
    options.tolerance = tol;
    const auto history = make_audited_history(spec, field_size, options);
    history->start(0, sample_field(0));
    std::vector<double> out(field_size);
    for (std::size_t n = 1; n < times.size(); ++n) {
      history->rhs(times[n], out);
      history->commit(times[n], sample_field(times[n]));
    }
    const auto report = history->report();
    EXPECT_GT(report.audits, 40);
    EXPECT_LT(report.audit, 2 * tol);
    // A coarse fit differs by about its error: an audit that saw nothing would not look.
    EXPECT_GT(report.audit, 1e-5 * tol);
    EXPECT_LT(report.error, tol);
  }
}

/// Step by step: the largest difference, by the norm of the kernel, 2 sqrt(T) for 1/sqrt(lag),
/// and by the largest value that the field has had.
TEST(Audit, IsTheLargestDifferenceBesideKernelAndField) {
  const auto times = grid(Grid::uniform, 16);
  const KernelSpec spec{"q", {}, kernel_case("power_50").expression};
  auto options = options_for(times, HistoryRoute::fit, 0);
  options.tolerance = 1e-3;
  const auto history = make_audited_history(spec, field_size, options, field_size);
  const auto direct = make_history(spec, field_size, options_for(times, HistoryRoute::direct, 0));
  history->start(0, sample_field(0)), direct->start(0, sample_field(0));
  std::vector<double> a(field_size), b(field_size);
  const double norm = 2.0 * std::sqrt(times.back());
  double worst = 0.0, largest = 0.0;
  for (std::size_t n = 1; n < times.size(); ++n) {
    history->rhs(times[n], a), direct->rhs(times[n], b);
    double off = 0.0;
    for (std::size_t i = 0; i < field_size; ++i) off = std::max(off, std::abs(a[i] - b[i]));
    if (largest > 0.0) worst = std::max(worst, off / (norm * largest));
    const auto u = sample_field(times[n]);
    for (const double value : u) largest = std::max(largest, std::abs(value));
    history->commit(times[n], u), direct->commit(times[n], u);
  }
  EXPECT_GT(worst, 1e-8);
  EXPECT_NEAR(history->report().audit, worst, 1e-6 * worst);
}

/// Saved anywhere: sums and audits of each later step are those of the run that was not
/// interrupted, bit for bit, though it found the weights of its audits step by step.
void expect_the_same_after_restart(const Expr& kernel, HistoryRoute route, int order,
                                   const std::vector<double>& times, std::size_t stop) {
  const auto options = options_for(times, route, order);
  const KernelSpec spec{"q", {}, kernel};
  const auto one = make_audited_history(spec, field_size, options, 2);
  const auto two = make_audited_history(spec, field_size, options, 2);
  one->start(0, sample_field(0));
  std::vector<double> a(field_size), b(field_size);
  for (std::size_t n = 1; n < times.size(); ++n) {
    const double t = times[n];
    one->rhs(t, a);
    one->commit(t, sample_field(t));
    if (n == stop) {
      std::stringstream state;
      one->save(state);
      two->restore(state);
    }
    if (n <= stop) continue;
    two->rhs(t, b);
    two->commit(t, sample_field(t));
    ASSERT_EQ(a, b);
    ASSERT_EQ(one->audited(), two->audited()) << n;
  }
  EXPECT_EQ(one->report().audits, two->report().audits);
}

TEST(Audit, SurvivesSaveAndRestore) {
  std::mt19937 random(11);
  for (const Case& c : all_cases()) {
    SCOPED_TRACE(name_of(c));
    const auto order = static_cast<int>(random() % 2);
    expect_the_same_after_restart(kernel_case(c.kernel).expression, HistoryRoute::automatic, order,
                                  grid(c.grid, 150), 1 + random() % 100);
  }
}

/// The weights that an audit found step by step are those that it finds all at once after a
/// restart: where the proof cuts a kernel must not depend on the lags asked for together.
TEST(Audit, SumsAreTheSameAfterRestart) {
  const auto times = grid(Grid::uniform, 400, 1.0);
  const auto options = options_for(times, HistoryRoute::fit, 0);
  for (const double power : {0.0, 0.3, 0.5, 0.8}) {
    const Expr q = call(Op::exp, -lag() / Expr(0.5)) * call(Op::pow, lag(), Expr(-power));
    const auto kernel = prepare_kernel({"q", {}, q}, options);
    IndependentSum one(kernel, field_size, 0, times[1]);
    one.start(0, sample_field(0));
    std::vector<double> a(field_size), b(field_size);
    for (std::size_t n = 1; n < times.size(); ++n) {
      if (n % 7 == 0) {
        std::stringstream state;
        StateWriter writer(state);
        one.save(writer);
        IndependentSum two(kernel, field_size, 0, times[1]);
        two.start(0, sample_field(0));
        StateReader reader(state, {});
        two.restore(reader);
        one.sum(times[n], a);
        two.sum(times[n], b);
        ASSERT_EQ(a, b) << n;
      }
      one.commit(times[n], sample_field(times[n]));
    }
  }
}

/// The first step has no past; the direct sum needs no audit by itself.
TEST(Audit, BeginsWithTheSecondStep) {
  const KernelSpec spec{"q", {}, kernel_case("stretched").expression};
  const auto times = grid(Grid::uniform, 30);
  for (const HistoryRoute route : {HistoryRoute::fit, HistoryRoute::direct}) {
    const auto history = make_audited_history(spec, field_size, options_for(times, route, 1), 2);
    history->start(0, sample_field(0));
    std::vector<double> out(field_size);
    for (int n = 1; n <= 12; ++n) {
      history->rhs(times[n], out);
      history->commit(times[n], sample_field(times[n]));
      const auto report = history->report();
      EXPECT_EQ(report.audits, route == HistoryRoute::direct ? 0 : n - 1) << n;
      EXPECT_EQ(report.audited_until, route == HistoryRoute::direct || n == 1 ? 0 : n);
    }
  }
}

/// Nothing absolute decides how far the pieces are halved.
TEST(Audit, IntegralsAreTheSameInEveryUnit) {
  for (const char* name : {"stretched", "power_50"}) {
    const Expr q = kernel_case(name).expression;
    const auto of = [&](double unit) {
      return independent_integral(prepare_kernel({"q", {}, Expr(unit) * q}, {}), 3.0, 2.0);
    };
    const Moments one = of(1.0);
    for (const double unit : {1e-14, 1e-6, 1e8}) {
      EXPECT_NEAR(of(unit).zero / unit, one.zero, 1e-13 * std::abs(one.zero)) << name;
      EXPECT_NEAR(of(unit).one / unit, one.one, 1e-13 * std::abs(one.one)) << name;
    }
    EXPECT_NEAR(one.zero, absolute_integral(q, name[0] == 'p' ? 0.5 : 0.0, 3.0, 2.0),
                1e-10 * one.zero);
  }
}

/// A record that no run can have written is refused.
TEST(Audit, RefusesARecordThatCannotBe) {
  const KernelSpec spec{"q", {}, kernel_case("stretched").expression};
  const std::vector<double> times = grid(Grid::uniform, 30);
  const auto options = options_for(times, HistoryRoute::fit, 1);
  const double begin = 3.0; // not 0: the time that has gone by is not the time
  const auto one = make_audited_history(spec, field_size, options, 2);
  one->start(begin, sample_field(0));
  std::vector<double> out(field_size);
  for (int n = 1; n <= 20; ++n) {
    one->rhs(begin + 0.01 * n, out);
    one->commit(begin + 0.01 * n, sample_field(0.01 * n));
  }
  std::ostringstream saved;
  one->save(saved);
  const auto restores = [&](std::size_t at, auto value) {
    const auto two = make_audited_history(spec, field_size, options, 2);
    two->start(begin, sample_field(0));
    std::string bytes = saved.str();
    if (at > 0) std::memcpy(bytes.data() + at, &value, sizeof value);
    std::istringstream in(bytes);
    try {
      two->restore(in);
    } catch (const Failure&) {
      return false;
    }
    return true;
  };
  // A mark, then t0, the largest values, the worst difference, the norm and where it ends, a step;
  // then how many steps and audits there were, and the last and the next of these.
  constexpr std::size_t numbers = 4, counts = numbers + 7 * 8;
  EXPECT_TRUE(restores(0, 0));
  for (std::size_t k = 0; k < 4; ++k) EXPECT_FALSE(restores(counts + 8 * k, std::int64_t{-1})) << k;
  for (std::size_t k = 1; k < 5; ++k) EXPECT_FALSE(restores(numbers + 8 * k, std::nan(""))) << k;
  EXPECT_FALSE(restores(numbers, 2.0)); // another first time
  EXPECT_FALSE(restores(numbers + 8 * 5, -1.0));
  // A norm over more than twice the time there is.
  EXPECT_FALSE(restores(numbers + 8 * 5, 2.1 * std::max(options.horizon, 0.2)));
}

/// u' = -int_0^t u' ds ... as the equation y(t) + int_0^t lag^{-1/2}/Gamma(1/2) y ds = 1 has the
/// solution E_{1/2}(-sqrt t) = e^t erfc(sqrt t): fractional relaxation (analytic). Order 1 weights.
TEST(LongRun, FractionalRelaxationFollowsMittagLeffler) {
  const Expr kernel = pow(lag(), Expr(-0.5)) / Expr(std::sqrt(M_PI));
  const int steps = 200000;
  const double end = 200, k = end / steps;
  HistoryOptions options;
  options.order = 1;
  options.horizon = end;
  options.shortest_step = k;
  options.steps = steps;
  const auto history = make_history({"q", {}, kernel}, 1, options);
  EXPECT_EQ(history->report().route, "fit");
  std::vector<double> y{1.0}, past(1);
  history->start(0, y);
  double worst_late = 0;
  for (int n = 1; n <= steps; ++n) {
    const double t = n * k;
    history->rhs(t, past);
    y[0] = (1 - past[0]) / (1 + history->w0(t));
    history->commit(t, y);
    if (t < 1) continue;
    const double exact =
        t < 50 ? std::exp(t) * boost::math::erfc(std::sqrt(t))
               : (1 - 0.5 / t + 0.75 / (t * t) - 1.875 / (t * t * t)) / std::sqrt(M_PI * t);
    worst_late = std::max(worst_late, std::abs(y[0] - exact));
  }
  EXPECT_LT(worst_late, 3e-6); // the scheme's own error at t = 1, O(k^{3/2})
  EXPECT_LT(history->report().fields, 50);
}

/// A million steps: the standard linear solid, sigma = u - int e^{-lag} u ds held at 1, has
/// u = 1 + t (analytic); order 1 is exact for affine u, so what is left is rounding.
TEST(LongRun, AMillionStepsOfTheStandardLinearSolidDoNotDrift) {
  const int steps = 1000000;
  const double k = 1e-4;
  HistoryOptions options;
  options.order = 1;
  options.horizon = steps * k;
  options.shortest_step = k;
  options.steps = steps;
  const auto history = make_history({"q", {}, exp(-lag())}, 1, options);
  std::vector<double> u{1.0}, past(1);
  history->start(0, u);
  for (int n = 1; n <= steps; ++n) {
    history->rhs(n * k, past);
    u[0] = (1 + past[0]) / (1 - history->w0(n * k));
    history->commit(n * k, u);
  }
  EXPECT_NEAR(u[0], 1 + steps * k, 1e-9 * (1 + steps * k));
  EXPECT_EQ(history->report().fields, 3);
}

} // namespace
} // namespace hvi::solver::test
