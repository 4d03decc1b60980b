// Lanczos' method: closed forms, and what it costs.
#include "solver/linear/lanczos.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace hvi::solver {
namespace {

/// Counts how often it is applied: diag(values) in the inner product of diag(metric).
class CountedDiagonal {
public:
  CountedDiagonal(Vector values, Vector metric)
      : values_(std::move(values)), metric_(std::move(metric)) {}
  SymmetricMap map() {
    return {values_.size(),
            [this](const Vector& v, const Vector&) -> Vector {
              ++count;
              return values_.cwiseProduct(v);
            },
            [this](const Vector& v) -> Vector { return metric_.cwiseProduct(v); }};
  }
  int count = 0;

private:
  Vector values_, metric_;
};

Vector metric_of(Eigen::Index n) {
  return Vector::NullaryExpr(
      n, [](Eigen::Index i) { return 1.0 + 0.9 * std::sin(7.0 * static_cast<double>(i)); });
}

/// An eigenvalue far from the others costs a few applications, one in a cluster no more.
TEST(Lanczos, StopsWhereTheEigenvalueIsKnown) {
  const Eigen::Index n = 5000;
  for (const Eigen::Index cluster : {1, 2000}) {
    Vector values = Vector::LinSpaced(n, 0.0, 1.0);
    values.tail(cluster) = Vector::LinSpaced(cluster, 9.999, 10.0);
    CountedDiagonal of(values, metric_of(n));
    const auto found = extreme_eigenvalue(of.map(), End::largest, 1e-5);
    ASSERT_TRUE(found) << cluster;
    EXPECT_NEAR(*found, 10.0, 1e-3) << cluster;
    EXPECT_LE(of.count, 41) << cluster;
  }
}

/// Ends that lie close together need restarts, and come out as they are.
TEST(Lanczos, GoesOnWhereTheEndsAreCrowded) {
  const Eigen::Index n = 2000;
  for (const End end : {End::least, End::largest}) {
    CountedDiagonal of(Vector::LinSpaced(n, -2.0, 3.0), metric_of(n));
    const auto found = extreme_eigenvalue(of.map(), end, 1e-9);
    ASSERT_TRUE(found);
    EXPECT_NEAR(*found, end == End::least ? -2.0 : 3.0, 1e-8);
    EXPECT_GT(of.count, 100);
  }
}

/// A map of rank two has an invariant space of three vectors at most, that of rank zero one of one.
TEST(Lanczos, EndsInAnInvariantSpace) {
  Vector values = Vector::Zero(300);
  values[17] = -4.0, values[230] = 0.5;
  CountedDiagonal of(values, metric_of(300));
  EXPECT_NEAR(extreme_eigenvalue(of.map(), End::least, 1e-9).value_or(0.0), -4.0, 1e-12);
  EXPECT_NEAR(extreme_eigenvalue(of.map(), End::largest, 1e-9).value_or(0.0), 0.5, 1e-12);
  EXPECT_LE(of.count, 8);
  CountedDiagonal nothing(Vector::Zero(300), metric_of(300));
  EXPECT_EQ(extreme_eigenvalue(nothing.map(), End::largest, 1e-9), 0.0);
}

} // namespace
} // namespace hvi::solver
