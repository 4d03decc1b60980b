// Pieces of work on several threads: all of them once, the same bits, exceptions brought back.
#include "solver/common/parallel.hpp"
#include "tests/solver/time/plans.hpp"

#include <stdexcept>

namespace hvi::solver {
namespace {

using namespace testing_plans;

TEST(Pieces, AreAllDoneOnce) {
  for (const int threads : {1, 2, 5, 100}) {
    std::vector<int> done(37, 0);
    for_each_piece(37, threads, [&](int i) { done[i] += i; });
    for (int i = 0; i < 37; ++i) EXPECT_EQ(done[i], i);
  }
  for_each_piece(0, 4, [](int) { FAIL(); });
}

TEST(Pieces, BringTheirExceptionBack) {
  const auto fails = [](int i) {
    if (i == 3) throw std::runtime_error("piece 3");
  };
  EXPECT_THROW(for_each_piece(8, 4, fails), std::runtime_error);
  EXPECT_THROW(for_each_piece(8, 1, fails), std::runtime_error);
}

TEST(Pieces, OfAProblemHaveTheSameBitsOnAnyNumberOfThreads) {
  auto plan = slab(6, 8, 2, true);
  const auto one = solve(plan);
  plan.options.threads = 4;
  const auto four = solve(plan);
  ASSERT_EQ(one.u.size(), four.u.size());
  EXPECT_TRUE((one.u.array() == four.u.array()).all());
  EXPECT_EQ(one.columns, four.columns);
}

} // namespace
} // namespace hvi::solver
