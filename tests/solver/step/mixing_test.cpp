// Fixed points of maps between numbers of several units.
#include "solver/step/mixing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace hvi::solver {
namespace {

/// x -> b + A x on components of kinds whose sizes are decades apart, A not contracting: Anderson's
/// mixing finds the fixed point in about as many passes as there are components.
TEST(Mixing, ComparesGapsByTheSizesOfTheirKinds) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int k = 0; k < 300; ++k) {
    const int n = 2 + static_cast<int>(random() % 5), n_kinds = 1 + static_cast<int>(random() % 3);
    std::vector<int> kinds;
    Vector size(n);
    std::vector<double> size_of_kind;
    for (int kind = 0; kind < n_kinds; ++kind)
      size_of_kind.push_back(std::pow(10.0, 8.0 * uniform(random)));
    DenseMatrix a(n, n);
    for (int i = 0; i < n; ++i) {
      kinds.push_back(static_cast<int>(random() % static_cast<unsigned>(n_kinds)));
      size[i] = size_of_kind[static_cast<std::size_t>(kinds.back())];
    }
    Vector fixed(n);
    for (int i = 0; i < n; ++i) {
      fixed[i] = size[i] * (1.0 + 0.5 * uniform(random));
      for (int j = 0; j < n; ++j) a(i, j) = 0.8 * uniform(random) * size[i] / size[j];
    }
    const Vector b = fixed - a * fixed;
    Mixing mixing(kinds);
    Vector x = fixed + size;
    if (k % 3 == 0) // readings that begin at rounding, with some of the others
      for (int i = 0; i < n; ++i)
        if (kinds[static_cast<std::size_t>(i)] == 0) x[i] = 1e-15 * fixed[i];
    double left = 1.0;
    for (int pass = 0; pass < 2 * n + 4 && left > 1e-10; ++pass) {
      x = mixing.next(x, b + a * x);
      left = (x - fixed).cwiseQuotient(size).lpNorm<Eigen::Infinity>();
    }
    EXPECT_LE(left, 1e-10) << k;
  }
}

/// A component that falls steeply at a place which another one moves late: between the ends that
/// were found before there is no fixed point any more.
TEST(Mixing, FindsFixedPointsThatOtherComponentsHaveMoved) {
  for (const double late : {0.02, -0.02, 0.3, -0.3}) {
    double place = 0.5;
    const auto map = [&](double x) { return place - std::tanh((x - place) / 1e-3); };
    Mixing mixing({0});
    Vector x = Vector::Constant(1, 0.9);
    for (int pass = 0; pass < 90; ++pass) {
      if (pass == 40) place += late;
      x = mixing.next(x, Vector::Constant(1, map(x[0])));
    }
    EXPECT_NEAR(x[0], place, 1e-10) << late;
  }
}

} // namespace
} // namespace hvi::solver
