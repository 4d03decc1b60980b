// Ctrl-C (and SIGTERM, what batch systems send, and SIGHUP, of a terminal that closes): asks the
// run to stop; a second one ends the program at once.
#pragma once

#include <array>
#include <atomic>

namespace hvi::lang {

/// What a run looks at before every step, and within steps where nothing would be lost.
const std::atomic<bool>& stop_flag();

/// While it lives, the first Ctrl-C only raises the flag.
class InterruptGuard {
public:
  InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  ~InterruptGuard();

private:
  std::array<void (*)(int), 3> previous_{}; ///< of SIGINT, SIGTERM, SIGHUP
};

} // namespace hvi::lang
