// Symbolic derivatives against complex steps (analytic functions: exact to rounding) and against
// extrapolated differences (the special functions).
#include "random_expr.hpp"
#include "solver/common/failure.hpp"
#include "solver/kernel/expr.hpp"
#include "solver/kernel/table.hpp"

#include <gtest/gtest.h>

#include <complex>

using namespace hvi::solver;
using namespace hvi::solver::test;

namespace {

using Complex = std::complex<double>;
const Expr x = Expr::variable(0), t = Expr::variable(slot::t);

Complex analytic(Op op, const std::vector<Complex>& a) {
  switch (op) {
  case Op::add:
    return a[0] + a[1];
  case Op::mul:
    return a[0] * a[1];
  case Op::div:
    return a[0] / a[1];
  case Op::neg:
    return -a[0];
  case Op::pow:
    return std::pow(a[0], static_cast<int>(a[1].real()));
  case Op::min:
    return a[0].real() < a[1].real() ? a[0] : a[1];
  case Op::max:
    return a[0].real() > a[1].real() ? a[0] : a[1];
  case Op::abs:
    return a[0].real() < 0.0 ? -a[0] : a[0];
  case Op::exp:
    return std::exp(a[0]);
  case Op::log:
    return std::log(a[0]);
  case Op::sqrt:
    return std::sqrt(a[0]);
  case Op::sin:
    return std::sin(a[0]);
  case Op::cos:
    return std::cos(a[0]);
  case Op::tan:
    return std::tan(a[0]);
  case Op::asin:
    return std::asin(a[0]);
  case Op::acos:
    return std::acos(a[0]);
  case Op::atan:
    return std::atan(a[0]);
  case Op::sinh:
    return std::sinh(a[0]);
  case Op::cosh:
    return std::cosh(a[0]);
  case Op::tanh:
    return std::tanh(a[0]);
  case Op::select:
    return a[0].real() != 0.0 ? a[1] : a[2];
  case Op::atan2: // arg(x + i y) continued analytically
    return std::atan2(a[0].real(), a[1].real()) +
           Complex(0.0, (a[0].imag() * a[1].real() - a[1].imag() * a[0].real()) /
                            (a[0].real() * a[0].real() + a[1].real() * a[1].real()));
  case Op::erf:
    return {std::erf(a[0].real()),
            a[0].imag() * 2.0 / std::sqrt(M_PI) * std::exp(-a[0].real() * a[0].real())};
  case Op::erfc:
    return {std::erfc(a[0].real()),
            a[0].imag() * -2.0 / std::sqrt(M_PI) * std::exp(-a[0].real() * a[0].real())};
  case Op::erfcx: { // (exp(x^2) F)' with F' = minus the one before
    const double n = a[0].real(), v = a[1].real(), value = erfcx(n, v);
    const double before = n == 0.0 ? 2.0 / std::sqrt(M_PI) : erfcx(n - 1.0, v);
    return {value, a[1].imag() * (2.0 * v * value - before)};
  }
  default:
    return apply(op, a[0].real(), a.size() > 1 ? a[1].real() : 0.0, 0.0);
  }
}

/// Near a point where the function or its slope jumps or is infinite, nothing is compared.
bool is_singular(Op op, const std::vector<Complex>& a) {
  const double v = a[0].real();
  switch (op) {
  case Op::log:
  case Op::sqrt:
    return std::abs(v) < 1e-6;
  case Op::asin:
  case Op::acos:
    return std::abs(1.0 - std::abs(v)) < 1e-6;
  case Op::atan2:
    return std::abs(v) < 1e-6 && a[1].real() < 1e-6; // the cut, where -0 is not 0
  default:
    return false;
  }
}

Complex step_value(const Tree& tree, std::span<const double> point, double& size) {
  Complex result = tree.value;
  if (tree.op == Op::slot) {
    result = {point[static_cast<std::size_t>(tree.slot)], tree.slot == 0 ? 1e-100 : 0.0};
  } else if (tree.op != Op::constant) {
    std::vector<Complex> args;
    for (const Tree& arg : tree.args) args.push_back(step_value(arg, point, size));
    result = analytic(tree.op, args);
    if (is_singular(tree.op, args)) size = HUGE_VAL;
  }
  const double magnitude = std::max(std::abs(result.real()), std::abs(result.imag()) * 1e100);
  size = std::isfinite(magnitude) ? std::max(size, magnitude) : HUGE_VAL;
  return result;
}

/// Ridders' extrapolation of central differences.
double difference(const Expr& e, double at) {
  const auto f = [&](double v) { return value_at(e, std::vector<double>(4, v)); };
  std::array<double, 6> row{};
  double h = 0.02, best = 0.0, error = HUGE_VAL;
  for (std::size_t i = 0; i < row.size(); ++i, h /= 2.0) {
    double previous = row[0];
    row[0] = (f(at + h) - f(at - h)) / (2.0 * h);
    double factor = 4.0;
    for (std::size_t k = 1; k <= i; ++k, factor *= 4.0) {
      const double next = row[k - 1] + (row[k - 1] - previous) / (factor - 1.0);
      previous = row[k];
      row[k] = next;
      if (std::abs(next - row[k - 1]) < error) {
        error = std::abs(next - row[k - 1]);
        best = next;
      }
    }
  }
  return best;
}

void expect_slope(const Expr& e, double at, double relative = 1e-9) {
  const double want = difference(e, at);
  const double got = value_at(derivative(e, 0), std::vector<double>(4, at));
  EXPECT_NEAR(got, want, relative * (1.0 + std::abs(want))) << to_string(e) << " at " << at;
}

} // namespace

TEST(Derivative, AgreesWithComplexSteps) {
  RandomTrees random(5, everything);
  int compared = 0;
  for (int i = 0; i < 8000; ++i) {
    const Tree tree = random.tree(1 + i % 4);
    const Expr slope = derivative(tree.expr(), 0);
    const auto p = random.point();
    double size = 1.0;
    const double want = step_value(tree, p, size).imag() * 1e100;
    if (size > 1e4) continue;
    ++compared;
    EXPECT_NEAR(value_at(slope, p), want, 1e-9 * size) << to_string(tree.expr());
  }
  EXPECT_GT(compared, 3000);
}

TEST(Derivative, OfSpecialFunctions) {
  for (const double at : {0.3, 1.1, 2.9}) {
    expect_slope(Expr::make(Op::gamma, {x}), at);
    expect_slope(derivative(Expr::make(Op::gamma, {x}), 0), at);
    expect_slope(Expr::make(Op::polygamma, {0.0, x}), at);
    expect_slope(Expr::make(Op::bessel_j, {0.0, 3.0 * x}), at);
    expect_slope(Expr::make(Op::bessel_j, {2.0, x}), at);
    expect_slope(Expr::make(Op::erfc, {x}), at);
    expect_slope(Expr::make(Op::erfcx, {0.0, x}), at);
    expect_slope(derivative(Expr::make(Op::erfcx, {0.0, 2.0 * x - 1.0}), 0), at);
    expect_slope(pow(x, 0.7), at);
    expect_slope(pow(1.3, x), at);
    expect_slope(pow(x, x), at);
  }
}

TEST(Derivative, OfMittagLeffler) {
  for (const double alpha : {0.4, 0.9, 1.6})
    for (const double beta : {1.0, alpha, 1.7})
      for (const double at : {-6.0, -1.2, -0.8, -1e-3, 0.0, 0.4, 1.2}) {
        const Expr e = Expr::make(Op::mittag_leffler, {alpha, beta, x});
        expect_slope(e, at, 1e-8);
        expect_slope(derivative(e, 0), at, 1e-8);
      }
}

TEST(Derivative, OfMittagLefflerFarOut) { // E ~ -1/(x Gamma(b-a)) - 1/(x^2 Gamma(b-2a)), analytic
  const double alpha = 0.6, beta = 1.3, far = -1e6;
  const double want = 1.0 / (far * far * std::tgamma(beta - alpha)) +
                      2.0 / (far * far * far * std::tgamma(beta - 2.0 * alpha));
  const Expr slope = derivative(Expr::make(Op::mittag_leffler, {alpha, beta, x}), 0);
  EXPECT_NEAR(value_at(slope, std::vector<double>(4, far)), want, 1e-11 * want);
}

TEST(Derivative, OfTables) {
  const std::vector<double> at{0.0, 1.0, 2.5, 4.0}, values{0.0, 2.0, 2.5, 5.0};
  for (const auto kind : {Table::Interpolation::linear, Table::Interpolation::monotone_cubic}) {
    const auto table = std::make_shared<Table>("f", at, values, kind);
    expect_slope(Expr::tabulated(table, pow(x, 2.0)), 1.3);
  }
}

TEST(Derivative, OfKinksIsTakenByBranches) {
  EXPECT_EQ(derivative(abs(x), 0), Expr::make(Op::sign, {x}));
  const Expr e = select(less(x, t), pow(x, 2.0), 3.0 * x);
  EXPECT_EQ(derivative(e, 0), select(less(x, t), 2.0 * x, 3.0));
  EXPECT_TRUE(derivative(Expr::make(Op::sign, {x}), 0).is(0.0));
}

TEST(Derivative, WithRespectToAnOrderIsRefused) {
  EXPECT_THROW(derivative(Expr::make(Op::bessel_j, {x, t}), 0), Failure);
  EXPECT_THROW(derivative(Expr::make(Op::erfcx, {x, t}), 0), Failure);
  EXPECT_THROW(derivative(Expr::make(Op::mittag_leffler, {x, 1.0, t}), 0), Failure);
  EXPECT_NO_THROW(derivative(Expr::make(Op::bessel_j, {x, t}), slot::t));
}
