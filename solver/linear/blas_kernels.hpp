// Which kernels OpenBLAS took for this processor.
#pragma once

#include <string>
#include <string_view>

namespace hvi::solver {

/// OpenBLAS chooses its kernels by the processors that its version knows, and gives a newer one
/// those for an older: with AVX-512, kernels for AVX2 make dense products take twice the time.
/// `avx512`: the processor has what kernels for AVX-512 need.
bool has_outgrown(std::string_view kernels, bool avx512);

struct BlasKernels {
  std::string name;      ///< that OpenBLAS gives them, of the processor they were made for
  bool outgrown = false; ///< this processor has better ones in OpenBLAS
};
BlasKernels blas_kernels();

} // namespace hvi::solver
