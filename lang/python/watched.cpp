// See watched.hpp.
#include "lang/python/watched.hpp"

#include "solver/common/out_of_memory.hpp"
#include "solver/linear/blas_memory.hpp"
#include "solver/linear/blas_threads.hpp"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <thread>

namespace hvi::python {

namespace py = pybind11;

namespace {

constexpr auto between_looks = std::chrono::milliseconds(50); ///< at signals

/// Whether a job has ended, and how.
class Arrival {
public:
  void arrive(std::exception_ptr failure) {
    const std::scoped_lock lock(guard_);
    failure_ = std::move(failure), ended_ = true;
    changed_.notify_one();
  }
  bool wait() {
    std::unique_lock lock(guard_);
    return changed_.wait_for(lock, between_looks, [&] { return ended_; });
  }
  const std::exception_ptr& failure() const { return failure_; }

private:
  std::mutex guard_;
  std::condition_variable changed_;
  bool ended_ = false;
  std::exception_ptr failure_;
};

/// Held by the job that may call BLAS, where one alone may at a time.
class BlasTurn {
public:
  /// Waits for the turn; false where the job is asked to stop before it comes.
  bool take(const std::atomic<bool>& stop) {
    if (solver::blas_is_made_for_threads()) return true;
    static std::timed_mutex only; // as there is one OpenBLAS
    turn_ = std::unique_lock(only, std::defer_lock);
    while (!turn_.try_lock_for(between_looks))
      if (stop) return false;
    return true;
  }

private:
  std::unique_lock<std::timed_mutex> turn_;
};

void do_job(const std::function<void()>& job, const std::atomic<bool>& stop, Arrival& ending) {
  std::exception_ptr failure;
  try {
    BlasTurn turn;
    if (!turn.take(stop)) return ending.arrive(nullptr); // whoever waits throws why
    if (!solver::reserve_blas_memory())
      throw solver::OutOfMemory("out of memory: a run needs some 200 MiB of addresses");
    const solver::OneBlasThread one_thread;
    job();
  } catch (...) {
    failure = std::current_exception();
  }
  ending.arrive(std::move(failure));
}

/// With Python's lock.
void look_up(Watch& watch, const py::object& progress) {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  if (progress.is_none()) return;
  if (const auto news = watch.news()) progress(news->step, news->steps, news->seconds);
}

} // namespace

void watched(const std::function<void()>& job, Watch& watch, const py::object& progress) {
  Arrival ending;
  std::exception_ptr from_python;
  {
    const py::gil_scoped_release unlocked;
    std::thread worker([&] { do_job(job, watch.stop(), ending); });
    while (!ending.wait()) {
      if (from_python) continue; // the job was asked to stop
      const py::gil_scoped_acquire locked;
      try {
        look_up(watch, progress);
      } catch (...) {
        from_python = std::current_exception();
        watch.ask_to_stop();
      }
    }
    worker.join();
  }
  if (from_python) std::rethrow_exception(from_python);
  if (ending.failure()) std::rethrow_exception(ending.failure());
  look_up(watch, progress);
}

} // namespace hvi::python
