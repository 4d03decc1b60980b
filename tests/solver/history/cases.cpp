// The kernels of the conformance suite, each written twice: as an expression and in C++.
#include "cases.hpp"

#include "solver/kernel/table.hpp"

#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/special_functions/erf.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace hvi::solver::test {

namespace {

/// E_{1/2}(-sqrt(l)) = exp(l) erfc(sqrt(l)).
double half_mittag_leffler(double l) {
  return l < 100 ? std::exp(l) * boost::math::erfc(std::sqrt(l)) : 1 / std::sqrt(M_PI * l);
}

void add_exponentials(std::vector<KernelCase>& cases) {
  const Expr l = lag();
  cases.push_back({.name = "exponential",
                   .expression = exp(-l / Expr(0.5)),
                   .value = [](double, double x) { return std::exp(-2 * x); },
                   .recursion = true,
                   .fit = true});
  cases.push_back(
      {.name = "prony",
       .expression = Expr(0.3) + Expr(0.5) * exp(-l) * exp(Expr(-2.0) * l) +
                     Expr(0.2) * pow(Expr(2.0), Expr(-40.0) * l),
       .value = [](double,
                   double x) { return 0.3 + 0.5 * std::exp(-3 * x) + 0.2 * std::exp2(-40 * x); },
       .recursion = true,
       .fit = true});
  cases.push_back(
      {.name = "stiff",
       .expression = exp(Expr(-5000.0) * l) + exp(Expr(-1e-7) * l),
       .value = [](double, double x) { return std::exp(-5000 * x) + std::exp(-1e-7 * x); },
       .recursion = true});
  cases.push_back({.name = "oscillating",
                   .expression = exp(-l) * call(Op::cos, Expr(20.0) * l),
                   .value = [](double, double x) { return std::exp(-x) * std::cos(20 * x); },
                   .recursion = true,
                   .fit = true});
  cases.push_back({.name = "lag_power_exponential",
                   .expression = pow(l, Expr(2.0)) * exp(Expr(-3.0) * l) + l,
                   .value = [](double, double x) { return x * x * std::exp(-3 * x) + x; },
                   .recursion = true});
  cases.push_back(
      {.name = "squared_sum",
       .expression = pow(exp(-l) + call(Op::sin, Expr(3.0) * l), Expr(2.0)) / call(Op::exp, l),
       .value =
           [](double, double x) {
             const double s = std::exp(-x) + std::sin(3 * x);
             return s * s * std::exp(-x);
           },
       .recursion = true});
  cases.push_back({.name = "growing",
                   .expression = call(Op::cosh, l),
                   .value = [](double, double x) { return std::cosh(x); },
                   .recursion = true});
}

void add_separable(std::vector<KernelCase>& cases) {
  const Expr l = lag(), t = time(), s = source();
  cases.push_back({.name = "times_of_time",
                   .expression = exp(-l) / (Expr(1.0) + t),
                   .value = [](double time, double x) { return std::exp(-x) / (1 + time); },
                   .recursion = true});
  cases.push_back(
      {.name = "times_of_source",
       .expression = (Expr(1.0) + Expr(0.5) * call(Op::sin, s)) * exp(-l),
       .value = [](double time, double x) { return (1 + 0.5 * std::sin(time - x)) * std::exp(-x); },
       .recursion = true});
  cases.push_back(
      {.name = "rational_source",
       .expression = exp(-l) / (Expr(1.0) + s) + s * t,
       .value = [](double time,
                   double x) { return std::exp(-x) / (1 + time - x) + (time - x) * time; },
       .recursion = true});
  cases.push_back({.name = "two_exponents",
                   .expression = exp(-t) * exp(s),
                   .value = [](double, double x) { return std::exp(-x); },
                   .recursion = true});
}

void add_smooth(std::vector<KernelCase>& cases) {
  const Expr l = lag();
  cases.push_back({.name = "stretched",
                   .expression = exp(-sqrt(l)),
                   .value = [](double, double x) { return std::exp(-std::sqrt(x)); },
                   .fit = true});
  cases.push_back({.name = "rational",
                   .expression = Expr(1.0) / (Expr(1.0) + l * l),
                   .value = [](double, double x) { return 1 / (1 + x * x); },
                   .fit = true});
  cases.push_back({.name = "mittag_leffler",
                   .expression = call(Op::mittag_leffler, Expr(0.5), Expr(1.0), -sqrt(l)),
                   .value = [](double, double x) { return half_mittag_leffler(x); },
                   .fit = true});
  cases.push_back({.name = "erfcx",
                   .expression = call(Op::erfcx, Expr(0.0), sqrt(l)),
                   .value = [](double, double x) { return half_mittag_leffler(x); },
                   .fit = true});
  cases.push_back({.name = "erfc",
                   .expression = call(Op::erfc, Expr(3.0) * l - Expr(1.0)),
                   .value = [](double, double x) { return boost::math::erfc(3 * x - 1); },
                   .fit = true});
  cases.push_back({.name = "logarithm",
                   .expression = call(Op::log, l),
                   .value = [](double, double x) { return std::log(x); },
                   .fit = true});
  cases.push_back({.name = "log_one_plus",
                   .expression = call(Op::log, Expr(1.0) + l),
                   .value = [](double, double x) { return std::log1p(x); },
                   .fit = true});
  cases.push_back({.name = "bessel",
                   .expression = call(Op::bessel_j, Expr(0.0), Expr(10.0) * l),
                   .value = [](double, double x) { return boost::math::cyl_bessel_j(0, 10 * x); },
                   .fit = true});
}

void add_powers(std::vector<KernelCase>& cases) {
  for (const double a : {0.1, 0.3, 0.5, 0.7, 0.9, 0.99}) {
    cases.push_back({.name = "power_" + std::to_string(static_cast<int>(std::round(100 * a))),
                     .expression = pow(lag(), Expr(-a)),
                     .value = [a](double, double x) { return std::pow(x, -a); },
                     .singular = a,
                     .fit = true});
  }
}

void add_piecewise(std::vector<KernelCase>& cases) {
  const Expr l = lag();
  std::vector<double> x, y;
  for (int i = 0; i <= 25; ++i) {
    x.push_back(0.1 * i);
    y.push_back(std::exp(-x.back()));
  }
  const auto table =
      std::make_shared<const Table>("relaxation", x, y, Table::Interpolation::linear);
  cases.push_back({.name = "table",
                   .expression = Expr::tabulated(table, l),
                   .value =
                       [x, y](double, double v) {
                         const auto i =
                             std::min<std::size_t>(24, static_cast<std::size_t>(v / 0.1));
                         return y[i] + (y[i + 1] - y[i]) * (v - x[i]) / (x[i + 1] - x[i]);
                       },
                   .breaks = std::vector<double>(x.begin() + 1, x.end() - 1)});
  cases.push_back({.name = "delay",
                   .expression = select(less(l, Expr(0.35)), exp(-l), Expr(0.0)),
                   .value = [](double, double v) { return v < 0.35 ? std::exp(-v) : 0.0; },
                   .breaks = {0.35}});
  cases.push_back(
      {.name = "hat",
       .expression = max(Expr(0.0), Expr(1.0) - abs(l - Expr(0.5)) / Expr(0.3)),
       .value = [](double, double v) { return std::max(0.0, 1 - std::abs(v - 0.5) / 0.3); },
       .breaks = {0.2, 0.5, 0.8}});
  cases.push_back({.name = "kink",
                   .expression = exp(-abs(l - Expr(0.3))),
                   .value = [](double, double v) { return std::exp(-std::abs(v - 0.3)); },
                   .breaks = {0.3}});
}

void add_aging(std::vector<KernelCase>& cases) {
  const Expr l = lag(), t = time(), s = source();
  cases.push_back({.name = "aging",
                   .expression = Expr(1.0) / (Expr(1.0) + t + l),
                   .value = [](double time, double x) { return 1 / (1 + time + x); }});
  cases.push_back({.name = "aging_singular",
                   .expression = pow(l, Expr(-0.5)) / (Expr(1.0) + s * s * l),
                   .value =
                       [](double time, double x) {
                         const double v = time - x;
                         return std::pow(x, -0.5) / (1 + v * v * x);
                       },
                   .singular = 0.5});
}

} // namespace

const std::vector<KernelCase>& kernel_cases() {
  static const std::vector<KernelCase> cases = [] {
    std::vector<KernelCase> list;
    add_exponentials(list);
    add_separable(list);
    add_smooth(list);
    add_powers(list);
    add_piecewise(list);
    add_aging(list);
    return list;
  }();
  return cases;
}

const KernelCase& kernel_case(const std::string& name) {
  for (const KernelCase& c : kernel_cases()) {
    if (c.name == name) return c;
  }
  throw std::invalid_argument("no kernel case " + name);
}

std::vector<double> grid(Grid kind, int steps, double end) {
  std::vector<double> times{0.0};
  if (kind == Grid::listed) {
    const double lengths[] = {1, 0.5, 3, 0.02, 2, 2, 0.7, 0.05};
    for (int n = 0; n < steps; ++n) times.push_back(times.back() + lengths[n % 8]);
    for (double& t : times) t *= end / times.back();
    times.back() = end;
    return times;
  }
  for (int n = 1; n <= steps; ++n) {
    const double x = static_cast<double>(n) / steps;
    times.push_back(kind == Grid::uniform ? end * x : end * x * x);
  }
  return times;
}

double shortest_step(const std::vector<double>& times) {
  double shortest = times.back();
  for (std::size_t i = 1; i < times.size(); ++i) {
    shortest = std::min(shortest, times[i] - times[i - 1]);
  }
  return shortest;
}

std::vector<double> sample_field(double t) {
  return {1.0, std::sin(3 * t), std::exp(-t) + t, t < 0.7 ? -1.0 : 0.5};
}

double reference_integral(const KernelCase& kernel, double t, double low, double high, int moment) {
  using Rule = boost::math::quadrature::gauss<double, 40>;
  const auto smooth = [&](double a, double b, const auto& f) { return Rule::integrate(f, a, b); };
  std::vector<double> ends{low};
  for (const double b : kernel.breaks) {
    if (b > low && b < high) ends.push_back(b);
  }
  ends.push_back(high);
  const auto weight = [&](double x) { return moment == 0 ? 1.0 : (x - low) / (high - low); };
  double sum = 0;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    const double a = ends[i], b = ends[i + 1];
    if (a > 0) {
      // Singularities sit at lag 0 only: panels no longer than their distance to it.
      for (double from = a; from < b;) {
        const double to = std::min(b, 2 * from);
        sum += smooth(from, to, [&](double x) { return kernel.value(t, x) * weight(x); });
        from = to;
      }
      continue;
    }
    // x = b v^p turns lag^-e and roots smooth enough; panels halve towards v = 0 for logarithms.
    const double p = 2 / (1 - kernel.singular);
    const auto f = [&](double v) {
      // value * x^e is bounded and at its limit where x would underflow.
      const double e = kernel.singular, x = std::max(b * std::pow(v, p), 1e-290);
      const double bounded = kernel.value(t, x) * std::pow(x, e);
      return bounded * weight(x) * std::pow(b, 1 - e) * p * v; // p (1 - e) - 1 = 1
    };
    for (int j = 0; j < 50; ++j) sum += smooth(std::ldexp(1, -j - 1), std::ldexp(1, -j), f);
  }
  return sum;
}

BruteForce brute_force(const KernelCase& kernel, const std::vector<double>& times, std::size_t n,
                       int order) {
  BruteForce out{std::vector<double>(field_size, 0.0), 0.0};
  const double t = times[n];
  const auto add = [&](double weight, std::size_t j) {
    const auto u = sample_field(times[j]);
    for (std::size_t i = 0; i < field_size; ++i) out.rhs[i] += weight * u[i];
  };
  for (std::size_t j = 1; j <= n; ++j) {
    const double low = t - times[j], high = t - times[j - 1];
    const double zero = reference_integral(kernel, t, low, high, 0);
    const double one = order == 1 ? reference_integral(kernel, t, low, high, 1) : 0.0;
    if (order == 1) add(one, j - 1);
    if (j < n) add(zero - one, j);
    if (j == n) out.w0 = zero - one;
  }
  return out;
}

} // namespace hvi::solver::test
