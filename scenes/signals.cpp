#include "scenes/signals.h"

#include <atomic>
#include <csignal>

namespace wick::scenes {

namespace {

std::atomic<int> stop{0};
std::atomic<int> checkpoint{0};
static_assert(std::atomic<int>::is_always_lock_free, "set from a signal handler");

extern "C" void on_signal(int signal) {
  if (signal == SIGUSR1) {
    checkpoint = 1;
    return;
  }
  stop = 1;
  if (signal == SIGINT) std::signal(SIGINT, SIG_DFL);
}

}  // namespace

void watch_signals() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGUSR1, SIGUSR2, SIGTERM, SIGINT}) sigaction(signal, &action, nullptr);
  // Writes beyond a file-size limit and into closed pipes are errors to report, not reasons to die.
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
}

bool stop_requested() {
  return stop != 0;
}

bool checkpoint_requested() {
  return checkpoint != 0;
}

bool take_checkpoint_request() {
  return checkpoint.exchange(0) != 0;
}

}  // namespace wick::scenes
