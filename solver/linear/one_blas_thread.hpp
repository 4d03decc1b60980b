// One thread for BLAS and OpenMP.
#pragma once

namespace hvi::solver {

/// Limits OpenBLAS and the OpenMP of this thread to one thread while it lives: the same bits
/// whatever the number of cores, and no waiting threads that use the processor. Several may live at
/// once; what OpenBLAS had before is set again by the last.
class OneBlasThread {
public:
  OneBlasThread();
  ~OneBlasThread();
  OneBlasThread(const OneBlasThread&) = delete;
  OneBlasThread& operator=(const OneBlasThread&) = delete;

private:
  int levels_before_;
};

} // namespace hvi::solver
