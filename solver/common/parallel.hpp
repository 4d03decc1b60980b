// Independent pieces of work on several threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace hvi::solver {

/// f(0) ... f(count - 1), each by one thread, on at most `threads` of them. A piece writes to
/// places of its own, so that the result has the same bits on any number of threads. The first
/// exception is thrown again once all threads have ended; pieces that had not begun by then are
/// left out. Fewer threads do it where the system gives no more.
template <class F>
void for_each_piece(int count, int threads, const F& f) {
  std::atomic<int> next = 0;
  std::exception_ptr failure;
  std::mutex guard;
  const auto work = [&] {
    for (int i = next++; i < count; i = next++) {
      try {
        f(i);
      } catch (...) {
        const std::lock_guard lock(guard);
        if (!failure) failure = std::current_exception();
        next = count;
      }
    }
  };
  {
    std::vector<std::jthread> others;
    try {
      for (int t = 1; t < std::min(threads, count); ++t) others.emplace_back(work);
    } catch (const std::system_error&) { // no more are to be had: these do it all
    }
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

} // namespace hvi::solver
