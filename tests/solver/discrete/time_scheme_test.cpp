// The schemes against polynomials whose derivatives they give without error.
#include "solver/discrete/time_scheme.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

namespace hvi::solver {
namespace {

const std::vector<double> uneven{0.5, 0.6, 0.85, 0.9, 1.3, 1.301, 2.0};

Problem of(Scheme scheme, std::vector<double> grid = uneven) {
  Problem out;
  out.time.is_static = false;
  out.time.grid = std::move(grid);
  out.time.scheme = scheme;
  return out;
}

/// With a form in u''.
Problem in_motion_of(Scheme scheme) {
  Problem out = of(scheme);
  out.forms.emplace_back();
  out.forms.back().field = field_of_u(2);
  return out;
}

Vector values(double t, int degree) {
  return Vector::NullaryExpr(
      3, [&](Eigen::Index i) { return static_cast<double>(i + 1) * std::pow(t, degree); });
}

/// u'(t_n) of the scheme for t^degree, whose steps 1 .. n are taken.
Vector rate_at(TimeScheme& scheme, int n, int degree) {
  const auto& grid = scheme.grid();
  scheme.start(3);
  for (int i = 1; i <= n; ++i) {
    Vector d = values(grid.t(i), degree) - values(grid.t(i - 1), degree);
    scheme.accept(i, d);
  }
  Vector out;
  scheme.derivative(n, 1, out);
  return out;
}

TEST(TimeScheme, BackwardEulerIsExactForLines) {
  const auto scheme = make_scheme(of(Scheme::backward_euler));
  for (int n = 1; n < std::ssize(uneven); ++n)
    EXPECT_LT((rate_at(*scheme, n, 1) - values(1.0, 1)).norm(), 1e-11) << n;
}

TEST(TimeScheme, Bdf2IsExactForParabolasFromItsSecondStepOn) {
  const auto scheme = make_scheme(of(Scheme::bdf2));
  for (int n = 2; n < std::ssize(uneven); ++n) {
    const double t = uneven[static_cast<std::size_t>(n)];
    // The step after 0.001 is 699 times as long: it begins anew.
    const bool anew = n == std::ssize(uneven) - 1;
    const double error = (rate_at(*scheme, n, 2) - 2.0 * values(t, 1)).norm();
    EXPECT_EQ(error < 1e-9, !anew) << n << ' ' << error;
  }
}

/// factor d + known before a step is the derivative after it.
void expect_known_parts(TimeScheme& scheme, int derivatives) {
  scheme.start(3);
  scheme.start_motion(Vector::Constant(3, 0.7), Vector::Constant(3, -0.2));
  for (int n = 1; n < std::ssize(uneven); ++n) {
    Vector d = Vector::Constant(3, std::sin(n));
    std::vector<Vector> predicted;
    std::vector<double> size;
    for (int j = 1; j <= derivatives; ++j) {
      predicted.emplace_back(scheme.factor(n, j) * d);
      size.push_back(predicted.back().norm());
      for (const auto& [factor, vector] : scheme.known(n, j)) {
        if (vector == nullptr) continue;
        predicted.back() += factor * *vector;
        size.back() += std::abs(factor) * vector->norm();
      }
    }
    scheme.accept(n, d);
    for (int j = 1; j <= derivatives; ++j) {
      Vector out;
      scheme.derivative(n, j, out);
      const auto i = static_cast<std::size_t>(j) - 1;
      EXPECT_LT((out - predicted[i]).norm(), 1e-14 * size[i]) << n << ' ' << j;
    }
  }
}

TEST(TimeScheme, WhatIsKnownAndTheIncrementMakeTheDerivative) {
  for (const Scheme kind : {Scheme::backward_euler, Scheme::bdf2})
    expect_known_parts(*make_scheme(of(kind)), 1);
  for (const Scheme kind :
       {Scheme::backward_euler, Scheme::bdf2, Scheme::newmark, Scheme::hht, Scheme::midpoint})
    expect_known_parts(*make_scheme(in_motion_of(kind)), 2);
}

TEST(TimeScheme, GoesOnFromWhatItSaved) {
  const auto scheme = make_scheme(of(Scheme::bdf2)), other = make_scheme(of(Scheme::bdf2));
  const Vector rate = rate_at(*scheme, 4, 3);
  std::stringstream bytes;
  StateWriter w(bytes);
  scheme->save(w);
  other->start(3);
  StateReader r(bytes, {});
  other->restore(r);
  Vector again;
  other->derivative(4, 1, again);
  EXPECT_EQ(again, rate);
}

TEST(TimeScheme, AStaticProblemHasNoRate) {
  const auto scheme = make_scheme(Problem{});
  EXPECT_EQ(scheme->factor(1, 1), 0.0);
  EXPECT_EQ(rate_at(*scheme, 1, 1).norm(), 0.0);
  EXPECT_EQ(useful_factors(*scheme), 1);
}

TEST(TimeScheme, FactorsAreKeptWhereLengthsComeBack) {
  const auto kept = [](Scheme scheme, std::vector<double> grid) {
    return useful_factors(*make_scheme(of(scheme, std::move(grid))));
  };
  const std::vector<double> alternating{0, 1, 3, 4, 6, 7}, growing{0, 1, 3, 7, 15};
  EXPECT_EQ(kept(Scheme::backward_euler, alternating), 2);
  EXPECT_EQ(kept(Scheme::bdf2, alternating), 3); // the first one is backward Euler
  EXPECT_EQ(kept(Scheme::backward_euler, growing), 1);
}

} // namespace
} // namespace hvi::solver
