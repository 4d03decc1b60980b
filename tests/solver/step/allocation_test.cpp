// What a step allocates, counted by a malloc of this program's own: nothing that grows with the
// mesh while no contact point changes its place.
#include "solver/step/step.hpp"
#include "tests/solver/time/plans.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#if defined(__GLIBC__) && !defined(HVI_SANITIZE)

namespace {

bool counting = false;
std::size_t allocated = 0; ///< bytes, while counting

void count(std::size_t bytes) {
  if (counting) allocated += bytes;
}

} // namespace

// glibc's own, behind the names that a program may take over.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) {
  count(size);
  return __libc_malloc(size);
}
void* calloc(std::size_t number, std::size_t size) {
  count(number * size);
  return __libc_calloc(number, size);
}
void* realloc(void* old, std::size_t size) {
  count(size);
  return __libc_realloc(old, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count(size);
  return __libc_memalign(alignment, size);
}
}

namespace hvi::solver {
namespace {

using namespace testing_plans;

/// The most bytes that one of the steps after `first` allocates.
std::size_t most_allocated(const Plan& plan, int first) {
  Discretisation discretisation;
  EXPECT_TRUE(discretise(plan, discretisation).empty());
  Timing timing;
  Stepper stepper(plan, discretisation, timing);
  std::size_t most = 0;
  for (int n = 1; n <= stepper.state().evolution.grid().steps(); ++n) {
    allocated = 0;
    counting = true;
    const auto result = stepper.advance(n);
    counting = false;
    EXPECT_TRUE(result.certified) << n;
    if (n > first) most = std::max(most, allocated);
  }
  return most;
}

/// The slab so early that the contact goes on as it begins.
Plan early(int n, bool friction) {
  Plan plan = slab(n, 32, 2, friction);
  plan.options.proportional_path = false;
  plan.problem.time.grid = uniform_grid(0.02, 32);
  return plan;
}

TEST(Allocation, OfAStepDoesNotGrowWithTheMesh) {
  constexpr std::size_t few = 200;         // bytes: coefficients of the base matrices
  for (const bool audit : {false, true}) { // an audit allocates for the steps so far
    const auto most = [&](Plan plan) {
      plan.options.audit = audit;
      return most_allocated(plan, 16);
    };
    for (const bool friction : {false, true}) {
      const std::size_t coarse = most(early(8, friction));
      EXPECT_TRUE(audit || coarse < few) << friction << ' ' << coarse;
      EXPECT_EQ(most(early(24, friction)), coarse) << friction;
    }
    Plan free = early(8, false), fine = early(24, false);
    for (Plan* plan : {&free, &fine}) plan->problem.law_terms.clear(), plan->report = {};
    EXPECT_TRUE(audit || most(free) < few) << most(free);
    EXPECT_EQ(most(fine), most(free));
  }
}

// The count sees what it should.
TEST(Allocation, OfTheFirstStepIsSeen) { EXPECT_GT(most_allocated(early(8, false), 0), 100000U); }

} // namespace
} // namespace hvi::solver

#endif
