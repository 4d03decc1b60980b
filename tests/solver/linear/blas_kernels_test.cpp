// Which kernels OpenBLAS took: what a processor has outgrown.
#include "solver/linear/blas_kernels.hpp"

#include <gtest/gtest.h>

namespace hvi::solver {
namespace {

TEST(BlasKernels, ThoseForAvx2AreOutgrownWithAvx512) {
  EXPECT_TRUE(has_outgrown("Haswell", true));
  EXPECT_TRUE(has_outgrown("Zen", true));
  EXPECT_FALSE(has_outgrown("Haswell", false));
  EXPECT_FALSE(has_outgrown("SkylakeX", true));
  EXPECT_FALSE(has_outgrown("Cooperlake", true));
  EXPECT_FALSE(has_outgrown("Neoversen1", false));
}

TEST(BlasKernels, OpenBlasNamesThoseItTook) {
  const BlasKernels taken = blas_kernels();
  EXPECT_FALSE(taken.name.empty());
  EXPECT_TRUE(!taken.outgrown || has_outgrown(taken.name, true));
}

} // namespace
} // namespace hvi::solver
