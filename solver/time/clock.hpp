// CPU time, for the phases of a run.
#pragma once

#include <algorithm>
#include <ctime>

namespace hvi::solver {

inline double seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// CPU seconds of the process so far, all threads together.
///
/// The CPU's clock is a system call, a dozen of them were a thirtieth of a small run's step. Within
/// 200 microseconds of the last one the clock on the wall, which is none, is taken to go on at the
/// same pace: what a phase of that length may be wrong by goes to the next.
inline double cpu_seconds() {
  constexpr double pace_is_kept = 200e-6;
  struct Reading {
    double cpu = 0, wall = -1, told = 0;
  };
  thread_local Reading last;
  const double wall = seconds_of(CLOCK_MONOTONIC);
  double cpu = last.cpu + (wall - last.wall);
  if (wall - last.wall > pace_is_kept) {
    cpu = seconds_of(CLOCK_PROCESS_CPUTIME_ID);
    last.cpu = cpu, last.wall = wall;
  }
  return last.told = std::max(last.told, cpu);
}

/// Adds the CPU time of its life to a phase.
class PhaseClock {
public:
  explicit PhaseClock(double& phase) : phase_(phase), start_(cpu_seconds()) {}
  PhaseClock(const PhaseClock&) = delete;
  PhaseClock& operator=(const PhaseClock&) = delete;
  ~PhaseClock() { phase_ += cpu_seconds() - start_; }

private:
  double& phase_;
  double start_;
};

/// Goes from phase to phase: each gets the CPU time since the last one ended.
class LapClock {
public:
  LapClock() : last_(cpu_seconds()) {}
  void charge(double& phase) {
    const double now = cpu_seconds();
    phase += now - last_;
    last_ = now;
  }

private:
  double last_;
};

} // namespace hvi::solver
