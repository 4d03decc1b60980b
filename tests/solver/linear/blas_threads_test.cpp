// Threads of OpenBLAS: how many there are, and when.
#include "solver/linear/blas_threads.hpp"

#include <gtest/gtest.h>

extern "C" int openblas_get_num_threads(void);

namespace hvi::solver {
namespace {

TEST(BlasThreads, AreWhatWasAskedForWhereTheyAreBuilt) {
  const OneBlasThread one;
  EXPECT_EQ(openblas_get_num_threads(), 1);
  {
    const BlasThreads three(3);
    EXPECT_EQ(openblas_get_num_threads(), blas_is_made_for_threads() ? 3 : 1);
    const OneBlasThread inside; // of a factor: it changes nothing where one was wanted before
    EXPECT_EQ(openblas_get_num_threads(), blas_is_made_for_threads() ? 3 : 1);
    {
      const BlasThreads two(2);
      EXPECT_EQ(openblas_get_num_threads(), blas_is_made_for_threads() ? 2 : 1);
    }
    EXPECT_EQ(openblas_get_num_threads(), blas_is_made_for_threads() ? 3 : 1);
  }
  EXPECT_EQ(openblas_get_num_threads(), 1);
  const BlasThreads none(1);
  EXPECT_EQ(openblas_get_num_threads(), 1);
}

} // namespace
} // namespace hvi::solver
