// The time that phases of a run take.
#pragma once

#include <ctime>

namespace hvi::solver {

inline double seconds_of(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// CPU seconds of the process so far, all threads together: a system call.
inline double cpu_seconds() { return seconds_of(CLOCK_PROCESS_CPUTIME_ID); }

/// Wall-clock seconds, for parts of a step, which may be shorter than a system call.
inline double wall_seconds() { return seconds_of(CLOCK_MONOTONIC); }

/// Adds the time of its life to a phase.
template <double (*seconds)() = cpu_seconds>
class PhaseClock {
public:
  explicit PhaseClock(double& phase) : phase_(phase), start_(seconds()) {}
  PhaseClock(const PhaseClock&) = delete;
  PhaseClock& operator=(const PhaseClock&) = delete;
  ~PhaseClock() { phase_ += seconds() - start_; }

private:
  double& phase_;
  double start_;
};

/// Goes from phase to phase: each gets the time since the last one ended.
template <double (*seconds)() = cpu_seconds>
class LapClock {
public:
  LapClock() : last_(seconds()) {}
  void charge(double& phase) {
    const double now = seconds();
    phase += now - last_;
    last_ = now;
  }

private:
  double last_;
};

} // namespace hvi::solver
