// Runs whose triangular solves read the factor with fewer bits against the same runs in double
// precision.
#include "tests/solver/time/plans.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace hvi::solver {
namespace {

using namespace testing_plans;

/// The same results to `tolerance`, and at most so many times the bytes of factors read.
void expect_same(Plan plan, double tolerance, double bytes, const std::string& what) {
  plan.options.proportional_path = false;
  const auto reduced = solve(plan);
  plan.options.reduced_precision = false;
  const auto exact = solve(plan);
  EXPECT_TRUE(reduced.certificate.certified && exact.certificate.certified) << what;
  EXPECT_LE(reduced.timing.factor_bytes_read, bytes * exact.timing.factor_bytes_read) << what;
  const double scale = exact.u.lpNorm<Eigen::Infinity>();
  EXPECT_GT(scale, 0.0) << what;
  EXPECT_LE((reduced.u - exact.u).lpNorm<Eigen::Infinity>(), tolerance * scale) << what;
  EXPECT_GT((reduced.u - exact.u).lpNorm<Eigen::Infinity>(), 0.0) << what << ": not reduced";
  for (const auto& [name, column] : exact.columns) {
    double largest = 0, difference = 0;
    for (std::size_t i = 0; i < column.size(); ++i) {
      largest = std::max(largest, std::abs(column[i]));
      difference = std::max(difference, std::abs(column[i] - reduced.columns.at(name)[i]));
    }
    EXPECT_LE(difference, tolerance * largest) << what << ", " << name;
  }
}

// One entry of the factor more than once: in 48 bits beside 64, without the halves that no solve
// reads. And matrices that are kept for products that read half.
TEST(ReducedPrecision, WhatIsHeldTwiceIsCounted) {
  Plan plan = slab(12, 96, 2, true);
  plan.options.proportional_path = false;
  const auto reduced = solve(plan);
  plan.options.reduced_precision = false;
  const auto exact = solve(plan);
  const double one_solve = exact.timing.factor_bytes_read / exact.work.triangular_solves;
  EXPECT_GT(reduced.work.bytes - exact.work.bytes, 0.4 * one_solve);
  EXPECT_LT(reduced.work.bytes - exact.work.bytes, 1.1 * one_solve);
  Plan few = slab(12, 11), enough = slab(12, 12);
  few.options.proportional_path = enough.options.proportional_path = false;
  const auto whole = solve(few), halved = solve(enough);
  const double matrix = 12.0 * 7.0 * 2.0 * whole.unknowns; // about seven blocks of 2 a node
  EXPECT_GT(halved.work.bytes - whole.work.bytes, 0.3 * 3.0 * matrix); // A, B and their sum
  EXPECT_LT(halved.work.bytes - whole.work.bytes, 0.8 * 3.0 * matrix);
}

TEST(ReducedPrecision, WithFewerBitsGiveTheSameRun) {
  expect_same(slab(12, 96), 1e-10, 0.8, "slab");
  expect_same(slab(12, 96, 2, true), 1e-10, 0.9, "slab with friction");
  expect_same(slab(4, 36, 3, true), 1e-10, 0.95, "3D with friction");
  Plan free = slab(12, 64);
  free.problem.law_terms.clear();
  while (!free.report.probes.empty() && free.report.probes.back().kind == Probe::Kind::integral)
    free.report.probes.pop_back();
  free.report.tables[0].probes.resize(free.report.probes.size());
  expect_same(free, 1e-10, 0.9, "no contact");
}

} // namespace
} // namespace hvi::solver
