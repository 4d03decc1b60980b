// One thread for BLAS and OpenMP.
#pragma once

namespace hvi::solver {

/// Limits OpenBLAS and OpenMP to one thread while it lives: the same bits whatever the number of
/// cores, and no waiting threads that use the processor.
class OneBlasThread {
public:
  OneBlasThread();
  ~OneBlasThread();
  OneBlasThread(const OneBlasThread&) = delete;
  OneBlasThread& operator=(const OneBlasThread&) = delete;

private:
  int before_, levels_before_;
};

} // namespace hvi::solver
