// Ctrl-C (and SIGTERM, what batch systems send): asks the run to stop after the step; a second one
// ends the program at once.
#pragma once

#include <atomic>

namespace hvi::lang {

/// What a run looks at before every step.
const std::atomic<bool>& stop_flag();

/// While it lives, the first Ctrl-C only raises the flag.
class InterruptGuard {
public:
  InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  ~InterruptGuard();

private:
  void (*previous_)(int);
  void (*previous_term_)(int);
};

} // namespace hvi::lang
