// Runs whose sweeps read the factor with fewer bits against the same runs in double precision, and
// how the choice between them is made.
#include "solver/time/sweep_choice.hpp"
#include "tests/solver/time/plans.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

namespace hvi::solver {
namespace {

using namespace testing_plans;

/// The same results to `tolerance`, and at most so many times the bytes of factors read.
void expect_same(Plan plan, double tolerance, double bytes, const std::string& what) {
  plan.options.proportional_path = false;
  const auto shortened = solve(plan);
  plan.options.shortened_sweeps = false;
  const auto exact = solve(plan);
  EXPECT_TRUE(shortened.certificate.certified && exact.certificate.certified) << what;
  EXPECT_LE(shortened.timing.swept_bytes, bytes * exact.timing.swept_bytes) << what;
  const double scale = exact.u.lpNorm<Eigen::Infinity>();
  EXPECT_GT(scale, 0.0) << what;
  EXPECT_LE((shortened.u - exact.u).lpNorm<Eigen::Infinity>(), tolerance * scale) << what;
  EXPECT_GT((shortened.u - exact.u).lpNorm<Eigen::Infinity>(), 0.0) << what << ": not shortened";
  for (const auto& [name, column] : exact.columns) {
    double largest = 0, difference = 0;
    for (std::size_t i = 0; i < column.size(); ++i) {
      largest = std::max(largest, std::abs(column[i]));
      difference = std::max(difference, std::abs(column[i] - shortened.columns.at(name)[i]));
    }
    EXPECT_LE(difference, tolerance * largest) << what << ", " << name;
  }
}

// One entry of the factor more than once: in 48 bits beside 64, without the halves that no sweep
// reads. And matrices that are kept for products that read half.
TEST(Sweeps, WhatIsHeldTwiceIsCounted) {
  Plan plan = slab(12, 96, 2, true);
  plan.options.proportional_path = false;
  const auto shortened = solve(plan);
  plan.options.shortened_sweeps = false;
  const auto exact = solve(plan);
  const double sweep = exact.timing.swept_bytes / exact.work.sweeps;
  EXPECT_GT(shortened.work.bytes - exact.work.bytes, 0.4 * sweep);
  EXPECT_LT(shortened.work.bytes - exact.work.bytes, 1.1 * sweep);
  Plan few = slab(12, 11), enough = slab(12, 12);
  few.options.proportional_path = enough.options.proportional_path = false;
  const auto whole = solve(few), halved = solve(enough);
  const double matrix = 12.0 * 7.0 * 2.0 * whole.unknowns; // about seven blocks of 2 a node
  EXPECT_GT(halved.work.bytes - whole.work.bytes, 0.3 * 3.0 * matrix); // A, B and their sum
  EXPECT_LT(halved.work.bytes - whole.work.bytes, 0.8 * 3.0 * matrix);
}

TEST(Sweeps, WithFewerBitsGiveTheSameRun) {
  expect_same(slab(12, 96), 1e-10, 0.8, "slab");
  expect_same(slab(12, 96, 2, true), 1e-10, 0.9, "slab with friction");
  expect_same(slab(4, 24, 3, true), 1e-10, 0.95, "3D with friction");
  Plan free = slab(12, 64);
  free.law_terms.clear();
  while (!free.report.probes.empty() && free.report.probes.back().kind == Probe::Kind::integral)
    free.report.probes.pop_back();
  free.report.tables[0].probes.resize(free.report.probes.size());
  expect_same(free, 1e-10, 0.9, "no contact");
}

constexpr double tolerance = 1e-10;
const double unpredicted = std::numeric_limits<double>::infinity();

TEST(Sweeps, AreExactUntilAStepWasPredicted) {
  SweepChoice choice(tolerance);
  choice.note_moved(unpredicted);
  EXPECT_FALSE(choice.worthwhile(100));
  EXPECT_EQ(choice.limits(true).forward, SweepStorage::full);
  EXPECT_EQ(choice.limits(true).back(1e-9), SweepStorage::full);
  choice.note_moved(1e-3);
  EXPECT_TRUE(choice.worthwhile(12));
  EXPECT_FALSE(choice.worthwhile(11));
  const auto limits = choice.limits(true);
  EXPECT_EQ(limits.forward, SweepStorage::single);
  EXPECT_EQ(limits.back(1e-6), SweepStorage::single);
  EXPECT_EQ(limits.back(1e-2), SweepStorage::fine);
  EXPECT_EQ(limits.back(2.0), SweepStorage::full);
}

// The larger the error of a rounded sweep back, the less contact unknowns may move in the next.
TEST(Sweeps, LearnFromTheErrorsTheyLeave) {
  SweepChoice choice(tolerance);
  choice.note_moved(1e-4);
  const double before = choice.limits(true).most_single;
  choice.learn(SweepStorage::single, SweepStorage::single, 2 * choice.target());
  EXPECT_LT(choice.limits(true).most_single, before);
  EXPECT_DOUBLE_EQ(choice.limits(true).most_single, 1e-4 / 4);
  EXPECT_EQ(choice.limits(true).back(1e-4), SweepStorage::fine);
  // Back with 48 bits and still too much: the sweep forward is to blame, the first time.
  choice.learn(SweepStorage::single, SweepStorage::fine, 2 * choice.target());
  EXPECT_EQ(choice.limits(true).forward, SweepStorage::fine);
  EXPECT_FALSE(choice.failed());
  for (int k = 0; k < 4; ++k)
    choice.learn(SweepStorage::fine, SweepStorage::fine, 2 * choice.target());
  EXPECT_LT(choice.limits(true).most_fine, 1e-3);
  EXPECT_TRUE(choice.failed());
  EXPECT_FALSE(choice.worthwhile(100));
}

TEST(Sweeps, GoOnFromASavedChoice) {
  SweepChoice choice(tolerance), again(tolerance);
  choice.note_moved(1e-4);
  choice.learn(SweepStorage::single, SweepStorage::single, 1e-11);
  choice.learn(SweepStorage::single, SweepStorage::fine, 1e-11);
  choice.learn(SweepStorage::fine, SweepStorage::fine, 1e-11);
  std::stringstream saved;
  choice.save(saved);
  again.restore(saved);
  EXPECT_EQ(again.limits(true).forward, choice.limits(true).forward);
  EXPECT_EQ(again.limits(true).most_single, choice.limits(true).most_single);
  EXPECT_EQ(again.limits(true).most_fine, choice.limits(true).most_fine);
}

} // namespace
} // namespace hvi::solver
