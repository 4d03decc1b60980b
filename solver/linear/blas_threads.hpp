// How many threads BLAS and OpenMP have: one, but where more are asked for.
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

/// So many threads for OpenBLAS while it lives, in a program that has one run at a time, and inside
/// a OneBlasThread: products of large dense blocks take them. Sums are then in another order for
/// each number of threads. None but one where OpenBLAS is its serial build.
class BlasThreads {
public:
  explicit BlasThreads(int threads);
  ~BlasThreads();
  BlasThreads(const BlasThreads&) = delete;
  BlasThreads& operator=(const BlasThreads&) = delete;

private:
  int before_;
};

/// Whether OpenBLAS may be called by two threads at once. Its serial build may not: both work in
/// the same memory, and the numbers of both are wrong.
bool blas_is_made_for_threads();

} // namespace hvi::solver
