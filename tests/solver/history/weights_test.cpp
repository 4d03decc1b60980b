// Weights where rules that compare two formulas are easily fooled, and memories that do not start
// at time 0. References: closed forms, and the brute-force sums of cases.hpp.
#include "cases.hpp"
#include "solver/history/fields.hpp"
#include "solver/history/kernel_function.hpp"
#include "solver/history/pole_fit.hpp"
#include "solver/history/proved_quadrature.hpp"
#include "solver/history/strip.hpp"
#include "solver/kernel/scalar.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace hvi::solver::test {
namespace {

HistoryOptions options_of(const std::vector<double>& times, HistoryRoute route, int order) {
  HistoryOptions o;
  o.route = route;
  o.order = order;
  o.horizon = times.back() - times.front();
  o.shortest_step = o.horizon;
  for (std::size_t n = 1; n < times.size(); ++n)
    o.shortest_step = std::min(o.shortest_step, times[n] - times[n - 1]);
  o.steps = static_cast<std::int64_t>(times.size()) - 1;
  o.times = times;
  return o;
}

/// Weight of u on (times[0], times[1]] at the last of the times.
double first_weight(const Expr& q, const std::vector<double>& times, HistoryRoute route) {
  const auto history = make_history({"q", {}, q}, 1, options_of(times, route, 0));
  const double zero = 0.0;
  history->start(times.front(), {&zero, 1});
  for (std::size_t n = 1; n + 1 < times.size(); ++n) {
    const double u = n == 1 ? 1.0 : 0.0;
    history->commit(times[n], {&u, 1});
  }
  double out = 0.0;
  history->rhs(times.back(), {&out, 1});
  return out;
}

/// The two rules of a panel agree to some digits long before both are right to rounding: whatever
/// the width of the bell, the weight is. (Closed form: arctangents.)
TEST(Weights, OfBellsOfAnyWidthAreExactToRounding) {
  for (double c = 1e-6; c < 30; c *= 1.17) {
    const Expr x = (lag() - Expr(2.4)) / Expr(c);
    const Expr bell = Expr(1.0) / (Expr(1.0) + x * x);
    const double exact = c * (std::atan(0.6 / c) + std::atan(0.4 / c));
    EXPECT_NEAR(first_weight(bell, {0, 1, 2, 3}, HistoryRoute::direct), exact,
                (2e-14 + 2e-15 / c) * exact) // the bell is as sharp as the rounding of its lags
        << c;
    const auto panels = integrate_smooth<1>(
        [&](double y) -> Values<1> { return {1 / (1 + (y - 2.4) * (y - 2.4) / (c * c))}; }, 2, 3);
    if (c > 1e-2) {
      EXPECT_NEAR(panels[0], exact, 1e-13 * exact) << c;
    }
  }
}

/// A kernel a million times as large is as well resolved by the same panels.
TEST(Weights, ResolvedPanelsDoNotDependOnTheUnitOfTheKernel) {
  const Expr x = (lag() - Expr(0.37)) / Expr(0.01);
  const Expr bell = Expr(1.0) / (Expr(1.0) + x * x);
  const auto edges = [&](double size) {
    std::vector<double> out;
    KernelFunction(Expr(size) * bell, {}).resolved_edges(1.0, 0.0, 1.0, out);
    return out;
  };
  const auto as_written = edges(1.0);
  EXPECT_GT(as_written.size(), 4U);
  for (const double size : {1e-6, 1e-3, 1e3, 1e6}) EXPECT_EQ(edges(size), as_written) << size;
}

/// Columns of weights times fields, against loops; also where there is nothing to add.
TEST(Weights, SumsOfColumnsAreTheDefinition) {
  for (const std::size_t n : {0U, 1U, 3U})
    for (const std::size_t count : {0U, 2U, 5U}) {
      constexpr std::size_t columns = 4;
      std::vector<double> weights, fields, out(n * columns, 0.5);
      for (std::size_t i = 0; i < columns * count; ++i)
        weights.push_back(std::sin(1.0 + static_cast<double>(i)));
      for (std::size_t i = 0; i < n * count; ++i)
        fields.push_back(std::cos(2.0 + static_cast<double>(i)));
      auto expected = out;
      for (std::size_t c = 0; c < columns; ++c)
        for (std::size_t k = 0; k < count; ++k)
          for (std::size_t i = 0; i < n; ++i)
            expected[c * n + i] += weights[c * count + k] * fields[k * n + i];
      add_columns(weights, fields.data(), count, n, out);
      for (std::size_t i = 0; i < out.size(); ++i) EXPECT_NEAR(out[i], expected[i], 1e-14);
    }
}

/// A ripple that two rules of few points see as much and as wrongly as each other. (Closed form.)
TEST(Weights, OfARippleOnAConstantHaveItsDigits) {
  for (const double size : {1e-9, 1e-8, 1e-7})
    for (double w = 4.0; w < 60.0; w *= 1.1) {
      const Expr ripple = Expr(1.0) + Expr(size) * cos(Expr(w) * lag());
      const double exact = 1.0 + size * (std::sin(3.0 * w) - std::sin(2.0 * w)) / w;
      EXPECT_NEAR(first_weight(ripple, {0, 1, 2, 3}, HistoryRoute::direct), exact, 1e-12) << w;
    }
}

TEST(Weights, OfPeaksBetweenAllPointsAreFound) {
  for (const double width : {1e-3, 1e-5, 1e-7}) {
    const Expr x = (lag() - Expr(2.1234567)) / Expr(width);
    const double exact = width * std::sqrt(M_PI);
    EXPECT_NEAR(first_weight(exp(-x * x), {0, 1, 2, 3}, HistoryRoute::direct), exact,
                (1e-12 + 2e-15 / width) * exact);
    const Expr window =
        select(less(x, Expr(1.0)), select(less(Expr(-1.0), x), Expr(1.0), Expr(0.0)), Expr(0.0));
    EXPECT_NEAR(first_weight(window, {0, 1, 2, 3}, HistoryRoute::direct), 2 * width, 1e-13);
  }
}

/// int_0^k e^(-lag) (1 + s/(s + a)) dlag at t = k: 1 + a layer that no panel of fixed points sees.
TEST(Weights, OfSeparableKernelsHoldForStepsOfAnyLength) {
  const Expr s = source();
  for (const double k : {1e-3, 1.0, 1e3, 1e6, 1e9, 1e12}) {
    for (const double a : {1e-3, 1e4}) {
      const Expr q = exp(s - time()) * (Expr(1.0) + s / (s + Expr(a)));
      double exact = 0; // midpoint rule in v with lag = min(k, 60) v^2
      const double reach = std::min(k, 60.0);
      constexpr int points = 400000;
      for (int i = 0; i < points; ++i) {
        const double v = (i + 0.5) / points, lag_here = reach * v * v;
        const double at = k - lag_here;
        exact += std::exp(-lag_here) * (1 + at / (at + a)) * reach * 2 * v / points;
      }
      for (const auto route : {HistoryRoute::recursion, HistoryRoute::direct}) {
        const std::vector<double> times{0, k};
        const auto history = make_history({"q", {}, q}, 1, options_of(times, route, 0));
        const double zero = 0.0;
        history->start(0, {&zero, 1});
        EXPECT_NEAR(history->w0(k), exact, 1e-8 * exact) << k << " " << a;
      }
    }
  }
}

/// (t^2 - s^2)^(-1/2): arcsines. As written, all digits cancel near lag 0.
TEST(Weights, OfDifferencesOfPowersAreIntegratedUpToTheDiagonal) {
  const Expr t = time(), s = source();
  const Expr q = pow(pow(t, Expr(2.0)) - pow(s, Expr(2.0)), Expr(-0.5));
  const auto history =
      make_history({"q", {}, q}, 1, options_of({0, 1, 2}, HistoryRoute::direct, 0));
  const double one = 1.0;
  history->start(0, {&one, 1});
  EXPECT_NEAR(history->w0(1), M_PI / 2, 1e-12);
  history->commit(1, {&one, 1});
  double past = 0.0;
  history->rhs(2, {&past, 1});
  EXPECT_NEAR(past, std::asin(0.5), 1e-13);
  EXPECT_NEAR(history->w0(2), M_PI / 2 - std::asin(0.5), 1e-12);
}

/// Every route for every kernel it serves, from times before and after 0.
TEST(Start, OtherThanZeroIsTheStart) {
  for (const double t0 : {-0.6, 5.3}) {
    std::vector<double> times;
    for (int n = 0; n <= 40; ++n) times.push_back(t0 + 2.0 * std::pow(n / 40.0, 1.5));
    for (const KernelCase& kernel : kernel_cases()) {
      if (kernel.name == "table" || kernel.singular > 0.5) continue; // reach to lag 2.0 only
      for (const auto route :
           {HistoryRoute::recursion, HistoryRoute::fit, HistoryRoute::tree, HistoryRoute::direct}) {
        if (route == HistoryRoute::recursion && !kernel.recursion) continue;
        if (route == HistoryRoute::fit && !kernel.fit) continue;
        for (const int order : {0, 1}) {
          const auto history = make_history({kernel.name, {}, kernel.expression}, field_size,
                                            options_of(times, route, order));
          history->start(t0, sample_field(t0));
          for (std::size_t n = 1; n < times.size(); ++n) {
            if (n == 1 || n == 17 || n == 40) {
              const BruteForce expected = brute_force(kernel, times, n, order);
              std::vector<double> rhs(field_size);
              history->rhs(times[n], rhs);
              for (std::size_t i = 0; i < field_size; ++i)
                EXPECT_NEAR(rhs[i], expected.rhs[i], 3e-8) << kernel.name << " " << n;
              EXPECT_NEAR(history->w0(times[n]), expected.w0, 1e-11) << kernel.name << " " << n;
            }
            history->commit(times[n], sample_field(times[n]));
          }
        }
      }
    }
  }
}

/// Bumps that come long after the blocks before them were made: the tree against the direct sum.
TEST(Tree, HoldsForWhatComesLater) {
  std::vector<double> times;
  for (int n = 0; n <= 600; ++n) times.push_back(n / 600.0);
  for (const double at : {0.45, 0.7, 0.83})
    for (const double width : {3e-3, 1e-2, 3e-2}) {
      const Expr x = (lag() - Expr(at)) / Expr(width);
      const Expr q = exp(-lag()) + exp(-x * x);
      const auto tree = make_history({"q", {}, q}, 1, options_of(times, HistoryRoute::tree, 0));
      const auto direct = make_history({"q", {}, q}, 1, options_of(times, HistoryRoute::direct, 0));
      const double zero = 0.0;
      for (const auto& h : {tree.get(), direct.get()}) h->start(0.0, {&zero, 1});
      double worst = 0.0;
      for (std::size_t n = 1; n < times.size(); ++n) {
        double found = 0.0, expected = 0.0;
        tree->rhs(times[n], {&found, 1});
        direct->rhs(times[n], {&expected, 1});
        worst = std::max(worst, std::abs(found - expected));
        const double u = std::cos(20.0 * times[n]);
        for (const auto& h : {tree.get(), direct.get()}) h->commit(times[n], {&u, 1});
      }
      EXPECT_LT(worst, 2e-8) << at << " " << width;
    }
}

TEST(PoleFit, CountsTheFieldsOfItsPoles) {
  EXPECT_EQ(fields_of({{1.0, 0.0}}), 1U);
  EXPECT_EQ(fields_of({{1.0, 0.0}, {2.0, 3.0}, {0.5, 0.0}}), 4U);
}

/// E_{a,b} is completely monotone for b >= a and 0 < a <= 1 only.
/// A narrow peak is resolved in any unit of time: the panels are the same parts of the range.
TEST(Panels, AreTheSameInEveryUnitOfTime) {
  std::vector<double> of_one;
  for (const double unit : {1.0, 1e-12, 1e-6, 1e6, 1e12}) {
    const Expr from_peak = (lag() / unit - Expr(0.3)) / 1e-9;
    const KernelFunction kernel(exp(-from_peak * from_peak) + exp(-lag() / unit), {});
    std::vector<double> edges;
    kernel.resolved_edges(unit, 0.0, unit, edges);
    for (double& edge : edges) edge /= unit;
    if (unit == 1.0) of_one = edges;
    ASSERT_EQ(edges.size(), of_one.size()) << unit;
    for (std::size_t i = 0; i < edges.size(); ++i) EXPECT_NEAR(edges[i], of_one[i], 1e-12);
  }
  const auto near = [](double edge) { return std::abs(edge - 0.3) < 2e-8; };
  EXPECT_GT(std::count_if(of_one.begin(), of_one.end(), near), 4);
  // A jump: panels become as narrow as rounding of the range, not narrower.
  for (const double unit : {1.0, 1e-9, 1e9}) {
    const KernelFunction jump(select(less(lag(), 0.3 * unit), 1.0, 2.0), {});
    std::vector<double> edges{0.0};
    jump.resolved_edges(unit, 0.0, unit, edges);
    double shortest = unit;
    for (std::size_t i = 1; i < edges.size(); ++i)
      shortest = std::min(shortest, edges[i] - edges[i - 1]);
    EXPECT_LE(shortest, 1e-14 * unit);
    EXPECT_GE(shortest, 0.4e-14 * unit);
  }
}

TEST(Strips, OfMittagLefflerFunctionsAreGivenWhereTheyAreProved) {
  const auto strip_of = [&](double a, double b) {
    const Expr e = Expr::make(Op::mittag_leffler, {Expr(a), Expr(b), -lag()});
    const Tape tape = compile(std::span<const Expr>(&e, 1));
    std::vector<Strip> registers;
    const Strip positive = around(1.0, 2.0);
    return enclose(tape, std::span<const Strip>(&positive, 1), registers);
  };
  for (const double a : {0.3, 0.7, 1.0}) EXPECT_EQ(strip_of(a, a).state, Strip::State::analytic);
  for (const auto& [a, b] : {std::pair{1.5, 1.5}, {1.2, 2.0}, {0.7, 0.5}})
    EXPECT_EQ(strip_of(a, b).state, Strip::State::unknown) << a << " " << b;
  for (const double a : {0.3, 0.7}) {
    const Strip found = strip_of(a, 1.0);
    for (const double x : {1.0, 1.3, 2.0}) {
      const double value = hvi::solver::mittag_leffler(a, 1.0, -x);
      EXPECT_LE(found.real_low, value * (1.0 + 1e-13)); // rounding is the caller's
      EXPECT_GE(found.real_high, value * (1.0 - 1e-13));
      EXPECT_LE(value, found.modulus());
    }
  }
}

/// exp(z^2) erfc(z) off the real line by its integral, 2/sqrt(pi) int_0^oo exp(-s^2 - 2 s z) ds.
std::complex<double> scaled_error_at(std::complex<double> z) {
  std::complex<double> sum = 0.0;
  const double h = 2e-3;
  for (int k = 0; k <= 5000; ++k) {
    const double s = h * k, weight = k == 0 ? 1.0 : k % 2 == 1 ? 4.0 : 2.0;
    sum += weight * std::exp(-s * s - 2.0 * s * z);
  }
  return 2.0 / std::sqrt(M_PI) * h / 3.0 * sum;
}

TEST(Strips, OfErrorFunctionsEncloseTheEllipse) {
  const auto strip_of = [](const Expr& e, double low, double high) {
    const Tape tape = compile(std::span<const Expr>(&e, 1));
    std::vector<Strip> registers;
    const Strip panel = around(low, high);
    return enclose(tape, std::span<const Strip>(&panel, 1), registers);
  };
  const Expr left = Expr::make(Op::erfc, {lag()}), scaled = Expr::make(Op::erfcx, {0.0, lag()});
  for (const auto& [low, high] : {std::pair{-2.5, -1.9}, {-0.3, 0.4}, {1.0, 1.5}, {4.0, 4.5}}) {
    const Strip a = strip_of(left, low, high), b = strip_of(scaled, low, high);
    ASSERT_EQ(a.state, Strip::State::analytic);
    ASSERT_EQ(b.state, Strip::State::analytic);
    const double middle = 0.5 * (low + high), half = 0.5 * (high - low);
    for (double angle = 0.0; angle < 6.3; angle += 0.1) {
      const std::complex<double> z{middle + 0.5 * (ellipse + 1 / ellipse) * half * std::cos(angle),
                                   0.5 * (ellipse - 1 / ellipse) * half * std::sin(angle)};
      const auto value = scaled_error_at(z);
      EXPECT_LE(std::abs(value), b.modulus() * (1 + 1e-9)) << z;
      EXPECT_LE(std::abs(value * std::exp(-z * z)), a.modulus() * (1 + 1e-9)) << z;
    }
    // not far above: a few times the largest value decide how a panel is cut
    EXPECT_LE(b.modulus(), 20 * erfcx(0.0, low));
    EXPECT_LE(a.modulus(), 100 * std::erfc(low));
    EXPECT_LE(a.real_low, std::erfc(high) * (1 + 1e-12));
    EXPECT_GE(a.real_high, std::erfc(low) * (1 - 1e-12));
  }
}

/// Points of the ellipse around a panel lie in the strip that is given for it.
TEST(Strips, EncloseTheEllipse) {
  const Strip s = around(1.0, 3.0);
  EXPECT_NEAR(s.low, 2 - 0.5 * (ellipse + 1 / ellipse), 1e-14);
  EXPECT_NEAR(s.imaginary, 0.5 * (ellipse - 1 / ellipse), 1e-14);
  const Expr e = exp(-lag()) / (Expr(1.0) + lag() * lag());
  const Tape tape = compile(std::span<const Expr>(&e, 1));
  std::vector<Strip> registers;
  const Strip small = around(1.0, 1.1);
  const Strip z = enclose(tape, std::span<const Strip>(&small, 1), registers);
  ASSERT_EQ(z.state, Strip::State::analytic);
  EXPECT_LE(z.low, std::exp(-1.1) / (1 + 1.21));
  EXPECT_GE(z.high, std::exp(-1.0) / 2);
  EXPECT_LT(z.modulus(), 0.4);
}

} // namespace
} // namespace hvi::solver::test
