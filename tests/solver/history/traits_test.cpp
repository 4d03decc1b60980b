// What is found out about kernels: recognition however written, singularities, breaks, refusals,
// exact integrals and norms. References are closed forms (analytic).
#include "cases.hpp"
#include "solver/history/exponentials.hpp"
#include "solver/history/norm_proofs.hpp"
#include "solver/history/traits.hpp"
#include "solver/kernel/table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace hvi::solver::test {
namespace {

std::unique_ptr<History> made(const Expr& kernel, HistoryRoute route = HistoryRoute::automatic) {
  HistoryOptions options;
  options.route = route;
  options.horizon = 2;
  options.shortest_step = 1e-3;
  options.steps = 2000;
  return make_history({"q", {}, kernel}, 1, options);
}

FailureKind refusal(const Expr& kernel, HistoryRoute route = HistoryRoute::automatic) {
  try {
    made(kernel, route);
  } catch (const Failure& failure) {
    EXPECT_FALSE(failure.help.empty());
    return failure.kind;
  }
  ADD_FAILURE() << "accepted";
  return FailureKind::interrupted;
}

/// What a kernel answers over 40 steps of growing length: its weights and memories, and the route.
std::pair<std::vector<double>, std::string> answer(const KernelSpec& kernel) {
  HistoryOptions options;
  options.horizon = 2;
  options.steps = 40;
  const auto history = make_history(kernel, 1, options);
  std::vector<double> out;
  double t = 0, u = 1;
  history->start(t, {&u, 1});
  for (int n = 1; n <= options.steps; ++n) {
    t = 2.0 * n * n / 1600.0, u = std::cos(3 * t);
    double memory = 0;
    history->rhs(t, {&memory, 1});
    out.insert(out.end(), {memory, history->w0(t)});
    history->commit(t, {&u, 1});
  }
  const auto report = history->report();
  return {out, report.route + ": " + report.why};
}

/// A series that comes as one is computed with as the same sum that was recognised, bit for bit:
/// one term, equal times, a time twice, weights of both signs, zero weights, a constant.
TEST(Recognition, ASeriesThatCameAsOneHasTheSameAnswer) {
  for (const PronySeries& series :
       {PronySeries{0, {1}, {0.5}}, PronySeries{0.25, {-0.3, 0.7}, {0.1, 3}},
        PronySeries{0, {0.5, 0.25, 2}, {0.3, 7, 0.3}}, PronySeries{-1, {0, 0.1}, {0.2, 1e3}}}) {
    KernelSpec kernel{"q", {}, expression(series, lag()), {}};
    const auto recognised = answer(kernel);
    kernel.series = series;
    EXPECT_EQ(answer(kernel), recognised) << to_string(kernel.expression);
    EXPECT_EQ(recognised.second.substr(0, 9), "recursion");
  }
}

/// The list is what is read, not the expression: sums too long to be recognised are known as well.
TEST(Recognition, ALongSeriesIsKnownWithoutRecognition) {
  PronySeries series;
  for (int i = 0; i < 250; ++i)
    series.weights.push_back(1.0), series.times.push_back(0.01 * std::pow(1.04, i));
  KernelSpec kernel{"q", {}, expression(series, lag()), {}};
  EXPECT_FALSE(study_kernel(kernel, 2).traits.exponential_sum);
  kernel.series = series;
  EXPECT_TRUE(study_kernel(kernel, 2).traits.exponential_sum);
}

/// exp(-2 lag) in ten ways: one real exponential, one field.
TEST(Recognition, SeesOneExponentialHoweverWritten) {
  const Expr l = lag(), t = time(), s = source();
  const std::vector<Expr> ways{
      exp(Expr(-2.0) * l),
      exp(-l / Expr(0.5)),
      exp(-l) * exp(-l),
      pow(exp(-l), Expr(2.0)),
      sqrt(exp(Expr(-4.0) * l)),
      Expr(1.0) / exp(l + l),
      pow(Expr(4.0), -l / Expr(std::log(2.0))),
      call(Op::cosh, Expr(2.0) * l) - call(Op::sinh, Expr(2.0) * l),
      exp(-(t - s) * Expr(2.0)),
      exp(Expr(-2.0) * t) * exp(Expr(2.0) * s),
      exp(Expr(-2.0) * l) * (pow(call(Op::sin, l), Expr(2.0)) + pow(call(Op::cos, l), Expr(2.0)))};
  for (const Expr& way : ways) {
    const auto traits = kernel_traits(way, 2, 0);
    EXPECT_TRUE(traits.exponential_sum) << to_string(way);
    EXPECT_TRUE(traits.convolution) << to_string(way);
    EXPECT_EQ(traits.description, "1 real exponential") << to_string(way);
    const auto history = made(way);
    EXPECT_EQ(history->report().route, "recursion");
    EXPECT_EQ(history->report().fields, 2) << "one state and the last value";
  }
}

TEST(Recognition, SeesPairsPolynomialsAndProducts) {
  const Expr l = lag();
  const auto state_fields = [](const Expr& kernel) {
    const auto terms = exponential_terms(kernel);
    return terms ? ExponentialSum(*terms).state_fields() : 0;
  };
  EXPECT_EQ(state_fields(call(Op::cos, l) * call(Op::cos, Expr(3.0) * l)), 4u);
  EXPECT_EQ(state_fields(pow(l + Expr(1.0), Expr(3.0)) * exp(-l)), 4u);
  EXPECT_EQ(state_fields(l * call(Op::sin, l)), 4u);
  EXPECT_EQ(state_fields(Expr(3.0)), 1u);
  EXPECT_EQ(state_fields(time() * exp(-l) + exp(-l)), 1u);
  for (const Expr& kernel : {sqrt(l), Expr(1.0) / (Expr(1.0) + l), abs(l - Expr(1.0)),
                             call(Op::log, Expr(1.0) + l), exp(-l * l)}) {
    EXPECT_FALSE(exponential_terms(kernel).has_value()) << to_string(kernel);
  }
}

TEST(Traits, FindSingularitiesAndBreaks) {
  const Expr l = lag();
  EXPECT_DOUBLE_EQ(kernel_traits(pow(l, Expr(-0.25)) * exp(-l), 2, 0).singular_exponent, 0.25);
  EXPECT_NEAR(kernel_traits(Expr(1.0) / sqrt(l + l * l), 2, 0).singular_exponent, 0.5, 1e-9);
  EXPECT_EQ(kernel_traits(call(Op::log, l), 2, 0).singular_exponent, 0);
  const auto hat = kernel_traits(kernel_case("hat").expression, 20, 0);
  ASSERT_EQ(hat.breaks.size(), 3u);
  EXPECT_NEAR(hat.breaks[0], 0.2, 1e-12);
  EXPECT_NEAR(hat.breaks[1], 0.5, 1e-12);
  EXPECT_NEAR(hat.max_lag, 0.8, 1e-12);
}

TEST(Traits, KernelsWithoutAFiniteIntegralAreRefused) {
  const Expr l = lag();
  EXPECT_EQ(refusal(Expr(1.0) / l), FailureKind::bad_kernel);
  EXPECT_EQ(refusal(pow(l, Expr(-1.5))), FailureKind::bad_kernel);
  EXPECT_EQ(refusal(exp(Expr(1.0) / l)), FailureKind::bad_kernel);
  EXPECT_EQ(refusal(sqrt(l - Expr(1.0))), FailureKind::bad_kernel);
  const auto shorter = std::make_shared<const Table>(
      "short", std::vector<double>{0, 1}, std::vector<double>{1, 0}, Table::Interpolation::linear);
  EXPECT_EQ(refusal(Expr::tabulated(shorter, l)), FailureKind::bad_kernel);
  EXPECT_EQ(refusal(sqrt(l), HistoryRoute::recursion), FailureKind::bad_kernel);
}

/// int_low^high over the lag, closed forms; the singular first interval included.
TEST(Integral, AgreesWithClosedForms) {
  for (const double a : {0.1, 0.5, 0.9, 0.99}) {
    const Expr q = pow(lag(), Expr(-a));
    for (const double h : {1e-8, 1e-3, 2.0}) {
      const double zero = std::pow(h, 1 - a) / (1 - a), one = std::pow(h, 1 - a) / (2 - a);
      EXPECT_NEAR(interval_integral(q, 3, 0, h, 0), zero, 2e-14 * zero) << a;
      EXPECT_NEAR(interval_integral(q, 3, 0, h, 1), one, 2e-14 * one) << a;
    }
  }
  const double h = 0.3; // int log = h (log h - 1); int of x log = h (log h / 2 - 1/4)
  EXPECT_NEAR(interval_integral(call(Op::log, lag()), 3, 0, h, 0), h * (std::log(h) - 1), 1e-15);
  EXPECT_NEAR(interval_integral(call(Op::log, lag()), 3, 0, h, 1), h * (std::log(h) / 2 - 0.25),
              1e-15);
  const double r = std::sqrt(h); // int exp(-sqrt) = 2 (1 - (1 + r) e^-r)
  EXPECT_NEAR(interval_integral(exp(-sqrt(lag())), 3, 0, h, 0), 2 * (1 - (1 + r) * std::exp(-r)),
              1e-15);
  const Expr jump = select(less(lag(), Expr(0.123)), Expr(1.0), Expr(5.0));
  EXPECT_NEAR(interval_integral(jump, 3, 0.1, 0.2, 0), 0.023 + 5 * 0.077, 1e-15);
}

/// E_2(-x^2) = cos x: of Mittag-Leffler functions of alpha > 1 nothing is proved.
TEST(Integral, OfAFunctionThatNothingBounds) {
  const Expr q = Expr::make(Op::mittag_leffler, {2.0, 1.0, -pow(lag(), 2.0)});
  for (const auto& [low, high] : {std::pair(0.1, 0.2), std::pair(0.1, 2.0), std::pair(1e-3, 2.5)}) {
    const double zero = std::sin(high) - std::sin(low), length = high - low;
    const double one = // of (x - low) / length
        (length * std::sin(high) + std::cos(high) - std::cos(low)) / length;
    EXPECT_NEAR(interval_integral(q, 3, low, high, 0), zero, 1e-13) << low;
    EXPECT_NEAR(interval_integral(q, 3, low, high, 1), one, 1e-13) << low;
  }
}

/// E_r(z) = int_0^1 x^r e^{z x} dx: series for small z, closed form of r = 1 for large z.
TEST(Moments, DoNotCancelForSmallAndStiffSteps) {
  for (int r = 0; r <= 8; ++r) {
    for (const double z : {0.0, 1e-12, -1e-6, 1e-3}) {
      const double series = 1.0 / (r + 1) + z / (r + 2) + z * z / (2 * (r + 3)) +
                            z * z * z / (6 * (r + 4)) + z * z * z * z / (24 * (r + 5));
      EXPECT_NEAR(exponential_moment(r, z).real(), series, 1e-15) << r << " " << z;
    }
  }
  for (const double z : {-1.0, -19.9, -20.1, -500.0, -1e8}) {
    const double exact = (std::exp(z) * (z - 1) + 1) / (z * z);
    EXPECT_NEAR(exponential_moment(1, z).real(), exact, 4e-15 * exact) << z;
  }
  const Complex z(-3, 40), e = std::exp(z);
  EXPECT_LT(std::abs(exponential_moment(2, z) - ((z * z - 2.0 * z + 2.0) * e - 2.0) / (z * z * z)),
            1e-16);
}

TEST(Norms, OfAnExponentialAreExactAndOfOthersSampled) {
  const auto norms = kernel_norms(Expr(3.0) * exp(Expr(-2.0) * lag()), 0, 5);
  EXPECT_TRUE(norms.exact);
  EXPECT_DOUBLE_EQ(norms.sup, 3);
  EXPECT_DOUBLE_EQ(norms.lipschitz, 6);
  EXPECT_NEAR(norms.l1, 1.5 * (1 - std::exp(-10)), 1e-15);
  const auto singular = kernel_norms(pow(lag(), Expr(-0.5)), 0, 4);
  EXPECT_TRUE(std::isinf(singular.sup));
  EXPECT_TRUE(std::isinf(singular.lipschitz));
  EXPECT_NEAR(singular.l1, 4, 1e-12);
  const auto wave = kernel_norms(call(Op::cos, Expr(2 * M_PI) * lag()), 0, 3);
  EXPECT_NEAR(wave.l1, 6 / M_PI, 1e-12);
}

/// At fixed s a window in the lag or in t is entered and left by jumps, one in s never: no matter
/// where the run starts.
TEST(Norms, TheLipschitzConstantSeesJumpsInTheLagAndInTimeOnly) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  const auto window = [](const Expr& of, double low, double high) {
    return select(less(of, Expr(low)), 0.0, select(less(of, Expr(high)), 1.0, 0.0));
  };
  const Expr t = Expr::variable(slot::t), s = t - lag();
  for (const double t0 : {0.0, -3.0, 7.0}) {
    for (const double width : {1e-6, 1e-2, 0.3}) {
      const double low = 0.31, high = 0.31 + width;
      const auto lipschitz = [&](const Expr& q) { return kernel_norms(q, t0, t0 + 1).lipschitz; };
      EXPECT_EQ(lipschitz(window(lag(), low, high)), infinite) << t0 << ' ' << width;
      EXPECT_EQ(lipschitz(window(t, t0 + low, t0 + high)), infinite) << t0 << ' ' << width;
      EXPECT_EQ(lipschitz(exp(-lag()) * window(t, t0 + low, t0 + high)), infinite);
      EXPECT_EQ(lipschitz(window(s, t0 + low, t0 + high)), 0) << t0 << ' ' << width;
      EXPECT_EQ(lipschitz(window(t + s, 2 * t0 + low, 2 * t0 + high)), infinite);
    }
    // Within a window in s the slope in t is that of the other factor.
    const Expr inside = window(s, t0 + 0.2, t0 + 0.9);
    const double slope = kernel_norms(exp(Expr(-2.0) * lag()) * inside, t0, t0 + 1).lipschitz;
    EXPECT_GT(slope, 1.9) << t0;
    EXPECT_LE(slope, 2) << t0;
    EXPECT_EQ(kernel_norms(sqrt(lag()) * inside, t0, t0 + 1).lipschitz, infinite) << t0;
  }
}

/// The numbers of -.3 exp(-lag) + .1 exp(-3 lag) and of (1 + t) exp(-lag) by hand: the first has
/// one sign on [0, 4]; the second is largest at t = 4 and lag 0, its slope in t at fixed s, -t
/// exp(-lag), there, too; int = (1 + t) (1 - exp(-t)).
TEST(Norms, AreProvedByIntervals) {
  const auto proofs = [](const Expr& q) { return prove_norms(q, kernel_norms(q, 0, 4), 0, 4); };
  const Expr two = Expr(-0.3) * exp(-lag()) + Expr(0.1) * exp(Expr(-3.0) * lag());
  const auto sum = proofs(two);
  EXPECT_EQ(sum.sup.how(), Provenance::proved);
  // -.3 x + .1 x^3, x = exp(-lag): |.| grows to x = 1
  EXPECT_NEAR(sum.sup.high, 0.2, 1e-9);
  EXPECT_EQ(sum.l1.how(), Provenance::proved);
  const double area = 0.3 * (1 - std::exp(-4.0)) - 0.1 / 3.0 * (1 - std::exp(-12.0));
  EXPECT_LE(sum.l1.low, area * (1 + 1e-14));
  EXPECT_GE(sum.l1.high, area * (1 - 1e-14));
  EXPECT_EQ(sum.lipschitz.how(), Provenance::proved);
  EXPECT_NEAR(sum.lipschitz.high, 0.2 * std::sqrt(1.0 / 3.0), 1e-8); // .3 (x - x^3) at x^2 = 1/3
  const auto ageing = proofs((Expr(1.0) + Expr::variable(slot::t)) * exp(-lag()));
  EXPECT_EQ(ageing.sup.how(), Provenance::proved);
  EXPECT_NEAR(ageing.sup.high, 5.0, 1e-8);
  EXPECT_EQ(ageing.lipschitz.how(), Provenance::proved);
  EXPECT_NEAR(ageing.lipschitz.high, 4.0, 1e-7);
  EXPECT_EQ(ageing.l1.how(), Provenance::between);
  const double largest = 5.0 * (1 - std::exp(-4.0));
  EXPECT_LE(ageing.l1.low, largest * (1 + 1e-12));
  EXPECT_GE(ageing.l1.high, largest);
  EXPECT_LT(ageing.l1.high, 1.1 * largest);
  // of lags no longer than the time: lag / (1 + t) is largest at lag = t = 4, not at t = 0
  const auto triangle = proofs(lag() / (Expr(1.0) + Expr::variable(slot::t)));
  EXPECT_GE(triangle.sup.high, 0.8);
  EXPECT_LE(triangle.sup.high, 0.8 + 1e-3);
  // a jump is not seen by slopes: no proof of the Lipschitz constant
  const auto jump = proofs(select(less(lag(), Expr(1.0)), Expr(2.0), Expr(1.0)));
  EXPECT_TRUE(std::isinf(jump.lipschitz.high));
  EXPECT_NEAR(jump.l1.low, 5.0, 2e-2);
}

TEST(Norms, OfAPronySeriesAreThoseOfTheQuadrature) {
  const Expr series = Expr(-0.3) * exp(Expr(-2.0) * lag()) - Expr(0.1) * exp(Expr(-0.2) * lag()) -
                      Expr(0.05) * exp(Expr(0.4) * lag()) - Expr(0.01);
  const auto terms = verified_terms(series, 7);
  ASSERT_TRUE(terms);
  const auto exact = prony_integral(terms->terms, 7);
  ASSERT_TRUE(exact);
  EXPECT_NEAR(*exact, absolute_integral(series, 0, 7, 7), 1e-13);
  // Factors of two signs, an oscillation, a factor of time: |q| is no sum of exponentials.
  for (const Expr& other : {series + Expr(0.2) * exp(-lag()), exp(-lag()) * call(Op::cos, lag()),
                            exp(-lag()) * (Expr(1.0) + Expr::variable(slot::t))}) {
    const auto found = verified_terms(other, 7);
    ASSERT_TRUE(found);
    EXPECT_FALSE(prony_integral(found->terms, 7));
  }
}

/// int_0^1 |cos(w s)| ds, w from some turns to as many as samples of a piece are in phase with.
TEST(Norms, OfOscillationsInPhaseWithTheSamples) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> near(0.98, 1.02), decades(1.0, 7.0);
  for (int i = 0; i < 80; ++i) {
    const double in_phase = 64.0 * 64.0 * 2.0 * M_PI * (1 + i / 8);
    const double w = i % 2 == 0 ? in_phase * near(random) : std::pow(10.0, decades(random));
    const double halves = std::floor(w / M_PI + 0.5), rest = w - halves * M_PI;
    const double exact = (2.0 * halves + std::sin(rest)) / w; // from -pi/2 to pi/2 the sine adds
    const double found = absolute_integral(call(Op::cos, Expr(w) * lag()), 0, 1, 1);
    EXPECT_NEAR(found, exact, 3e-3 * exact) << w; // of a few thousand samples
  }
}

/// Ten steps read two fields each by the recursion, and all that came before by the direct sum.
TEST(Reads, AreCounted) {
  for (const auto& [route, reads] :
       {std::pair{HistoryRoute::recursion, 20}, std::pair{HistoryRoute::direct, 45}}) {
    const auto history = made(exp(-lag()), route);
    const double u = 1;
    double out = 0;
    history->start(0, {&u, 1});
    for (int n = 1; n <= 10; ++n) {
      history->rhs(0.1 * n, {&out, 1});
      history->commit(0.1 * n, {&u, 1});
    }
    EXPECT_EQ(history->report().reads, reads);
  }
}

} // namespace
} // namespace hvi::solver::test
