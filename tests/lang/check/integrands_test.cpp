// What the checker makes of integrands, against the same formulas computed by hand at random
// points: tensors of the library, expressions of numbers, cases.
#include "tests/lang/scripts.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

namespace hvi::lang {
namespace {

using namespace testing_scripts;
namespace slot = solver::slot;

/// The integrand of the first term with its factor, at the values.
double integrand(const Model& model, Values& values) {
  const auto& term = model.terms.front();
  return values.of(term.factor * term.integrand.scalar());
}

TEST(Integrands, IsotropicTensorsAreHookesLaw) {
  std::mt19937 random(1);
  for (int k = 0; k < 200; ++k) {
    const int dim = 2 + k % 2;
    const double young = drawn(random, 0.1, 200), poisson = drawn(random, -0.9, 0.49);
    const auto text = problem(
        dim, fmt::format("tensor B = isotropic(young = {}, poisson = {})\n", young, poisson),
        "integral(body, B : eps(u) : eps(v))", "integral(body, v.y)");
    const auto script = checked(text);
    ASSERT_TRUE(script.model) << text;
    Values at(random);
    const double lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
    const double mu = young / (2 * (1 + poisson));
    double trace_u = 0, trace_v = 0, product = 0, size = 0;
    for (int i = 0; i < dim; ++i) {
      trace_u += at.strain_of_u(i, i);
      trace_v += at.strain_of_v(i, i);
      for (int j = 0; j < dim; ++j) {
        product += at.strain_of_u(i, j) * at.strain_of_v(i, j);
        size += std::abs(at.strain_of_u(i, j) * at.strain_of_v(i, j));
      }
    }
    EXPECT_NEAR(integrand(*script.model, at), lambda * trace_u * trace_v + 2 * mu * product,
                1e-12 * young * size * 100)
        << text;
  }
}

/// A random expression of x, y and numbers: its text, and its value at (x, y).
struct Formula {
  std::string text;
  std::function<double(double, double)> value;
};

Formula formula(std::mt19937& random, int depth) {
  const auto pick = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  if (depth == 0) {
    if (const int which = pick(3); which < 2)
      return which == 0 ? Formula{"x", [](double x, double) { return x; }}
                        : Formula{"y", [](double, double y) { return y; }};
    const double number = drawn(random, 0.0, 3.0);
    return {fmt::format("{}", number), [number](double, double) { return number; }};
  }
  const Formula a = formula(random, depth - 1), b = formula(random, pick(depth));
  const auto f = a.value, g = b.value;
  switch (pick(9)) {
  case 0:
    return {"(" + a.text + " + " + b.text + ")",
            [f, g](double x, double y) { return f(x, y) + g(x, y); }};
  case 1:
    return {"(" + a.text + " - " + b.text + ")",
            [f, g](double x, double y) { return f(x, y) - g(x, y); }};
  case 2:
    return {a.text + "*" + b.text, [f, g](double x, double y) { return f(x, y) * g(x, y); }};
  case 3:
    return {a.text + "/(2 + sin(" + b.text + "))",
            [f, g](double x, double y) { return f(x, y) / (2 + std::sin(g(x, y))); }};
  case 4:
    return {"cos(" + a.text + ")^2",
            [f](double x, double y) { return std::pow(std::cos(f(x, y)), 2); }};
  case 5:
    return {"max(" + a.text + ", " + b.text + ")",
            [f, g](double x, double y) { return std::max(f(x, y), g(x, y)); }};
  case 6:
    return {"sqrt(abs(" + a.text + "))",
            [f](double x, double y) { return std::sqrt(std::abs(f(x, y))); }};
  case 7:
    return {"(| " + a.text + " < " + b.text + " -> " + b.text + " | otherwise -> 2)",
            [f, g](double x, double y) { return f(x, y) < g(x, y) ? g(x, y) : 2.0; }};
  default:
    return {"(-" + a.text + ")", [f](double x, double y) { return -f(x, y); }};
  }
}

TEST(Integrands, RandomExpressionsHaveTheirValues) {
  std::mt19937 random(2);
  for (int k = 0; k < 400; ++k) {
    const Formula load = formula(random, 1 + k % 4);
    const auto text =
        problem(2, "tensor B = isotropic(lambda = 1, mu = 1)\n",
                "integral(body, B : eps(u) : eps(v))", "integral(body, " + load.text + "*v.y)");
    const auto script = checked(text);
    ASSERT_TRUE(script.model) << text;
    Values at(random);
    const auto& term = script.model->terms.back();
    const double here = at.of(term.factor * term.integrand.scalar());
    const double wanted =
        load.value(at(slot::x(0)), at(slot::x(1))) * at(slot::test(slot::value(1)));
    EXPECT_NEAR(here, wanted, 1e-12 * (1 + std::abs(wanted))) << load.text;
  }
}

// By the definition of the engineering constants: the strain of a stress along i is 1/E_i along i
// and -nu_ij/E_i along j, in the frame of the axes.
TEST(Integrands, OrthotropicTensorsInvertTheirComplianceInAnyFrame) {
  std::mt19937 random(3);
  for (int k = 0; k < 100; ++k) {
    const double e[3] = {drawn(random, 10, 20), drawn(random, 10, 20), drawn(random, 10, 20)};
    const double nu[3] = {drawn(random, 0, 0.2), drawn(random, 0, 0.2), drawn(random, 0, 0.2)};
    const double g[3] = {drawn(random, 3, 9), drawn(random, 3, 9), drawn(random, 3, 9)};
    const double angle = drawn(random, -3, 3), tilt = drawn(random, -1.5, 1.5);
    const double c = std::cos(angle), s = std::sin(angle), p = std::cos(tilt), q = std::sin(tilt);
    const double axes[3][3] = {{c, s, 0}, {-s * p, c * p, q}, {s * q, -c * q, p}};
    std::string rows;
    for (const auto& row : axes)
      rows += fmt::format("{}[{:.17g}, {:.17g}, {:.17g}]", rows.empty() ? "" : ", ", row[0], row[1],
                          row[2]);
    const auto script = checked(problem(
        3,
        fmt::format("tensor B = orthotropic(young = [{}, {}, {}], poisson = [{}, {}, {}], shear = "
                    "[{}, {}, {}], axes = [{}])\n",
                    e[0], e[1], e[2], nu[0], nu[1], nu[2], g[0], g[1], g[2], rows),
        "integral(body, B : eps(u) : eps(v))", "integral(body, v.y)"));
    ASSERT_TRUE(script.model);
    // A stress in the frame of the axes, its strain by the compliance, both turned into the
    // script's frame: B : strain must be the stress.
    double stress[3][3] = {};
    for (auto& row : stress)
      for (double& value : row) value = drawn(random, -1, 1);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < i; ++j) stress[i][j] = stress[j][i];
    double strain[3][3] = {};
    const double cross[3][3] = {{0, nu[0] / e[0], nu[2] / e[0]},
                                {nu[0] / e[0], 0, nu[1] / e[1]},
                                {nu[2] / e[0], nu[1] / e[1], 0}};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        if (i != j) strain[i][j] = stress[i][j] / (2 * g[i + j == 1 ? 0 : i + j == 3 ? 1 : 2]);
        strain[i][i] += i == j ? stress[i][i] / e[i] : -cross[i][j] * stress[j][j];
      }
    const auto turned = [&](const double(&m)[3][3], int i, int j) {
      double sum = 0;
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) sum += axes[a][i] * axes[b][j] * m[a][b];
      return sum;
    };
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const auto value_of = [&](solver::Slot asked) {
          for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) {
              if (asked == slot::field(solver::field_of_u(0), slot::gradient(a, b)))
                return turned(strain, a, b);
              if (asked == slot::test(slot::gradient(a, b))) return a == i && b == j ? 1.0 : 0.0;
            }
          return std::nan("");
        };
        const auto& term = script.model->terms.front();
        EXPECT_NEAR(evaluate(term.factor * term.integrand.scalar(), value_of), turned(stress, i, j),
                    1e-12);
      }
  }
}

} // namespace
} // namespace hvi::lang
