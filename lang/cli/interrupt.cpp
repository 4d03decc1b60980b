// Ctrl-C (interrupt.hpp).
#include "lang/cli/interrupt.hpp"

#include <csignal>

namespace hvi::lang {

namespace {

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler writes it");

constexpr int asking_to_stop[] = {SIGINT, SIGTERM, SIGHUP};

void on_interrupt(int) {
  stop_requested = true;
  for (const int signal : asking_to_stop) std::signal(signal, SIG_DFL);
}

} // namespace

const std::atomic<bool>& stop_flag() { return stop_requested; }

InterruptGuard::InterruptGuard() {
  for (std::size_t i = 0; i < std::size(asking_to_stop); ++i) {
    previous_[i] = std::signal(asking_to_stop[i], &on_interrupt);
    // Ignored by who started us (nohup, a job in the background): it stays so.
    if (previous_[i] == SIG_IGN) std::signal(asking_to_stop[i], SIG_IGN);
  }
}

InterruptGuard::~InterruptGuard() {
  for (std::size_t i = 0; i < std::size(asking_to_stop); ++i)
    std::signal(asking_to_stop[i], previous_[i]);
}

} // namespace hvi::lang
