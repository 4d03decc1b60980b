// Ctrl-C (interrupt.hpp).
#include "lang/interrupt.hpp"

#include <csignal>

namespace hvi::lang {

namespace {

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler writes it");

void on_interrupt(int) {
  stop_requested = true;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

} // namespace

const std::atomic<bool>& stop_flag() { return stop_requested; }

InterruptGuard::InterruptGuard()
    : previous_(std::signal(SIGINT, &on_interrupt)),
      previous_term_(std::signal(SIGTERM, &on_interrupt)) {}
InterruptGuard::~InterruptGuard() {
  std::signal(SIGINT, previous_);
  std::signal(SIGTERM, previous_term_);
}

} // namespace hvi::lang
