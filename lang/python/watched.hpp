// Work on a thread of its own while Python waits for it without its lock: other threads of Python
// go on, Ctrl-C is noticed, and progress is told.
#pragma once

#include "solver/time/run.hpp"

#include <pybind11/pybind11.h>

#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <utility>

namespace hvi::python {

/// What the work and who waits for it tell each other.
class Watch {
public:
  const std::atomic<bool>& stop() const { return stop_; }
  void ask_to_stop() { stop_ = true; }
  /// Told by the work, after every step.
  void note(const solver::Progress& progress) {
    const std::scoped_lock lock(guard_);
    latest_ = progress;
  }
  /// What was noted since it was asked last.
  std::optional<solver::Progress> news() {
    const std::scoped_lock lock(guard_);
    return std::exchange(latest_, std::nullopt);
  }

private:
  std::atomic<bool> stop_{false};
  std::mutex guard_;
  std::optional<solver::Progress> latest_;
};

/// Does the job, with one thread for BLAS. `progress`: None, or called with (step, steps, seconds)
/// some twenty times a second, by the thread that waits. What it or a signal handler of Python
/// throws asks the job to stop, and is thrown when it has; what the job throws is thrown, too. To
/// be called with Python's lock.
void watched(const std::function<void()>& job, Watch& watch, const pybind11::object& progress);

} // namespace hvi::python
