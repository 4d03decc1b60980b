// CPU time, for the phases of a run.
#pragma once

#include <ctime>

namespace hvi::solver {

/// CPU seconds of the process so far, all threads together.
inline double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
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
