// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/cli/signals.h"

#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>

namespace cornice {
namespace {

sigset_t watched_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}

}  // namespace

SignalWatch::SignalWatch(int grace_s, std::function<void()> give_up)
    : grace_s_(grace_s), give_up_(std::move(give_up)) {
  const sigset_t set = watched_signals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  thread_ = std::thread([this] { watch(); });
}

SignalWatch::~SignalWatch() {
  stopping_ = true;
  // Wakes the watcher; a signal of the system's would go to the process as well.
  pthread_kill(thread_.native_handle(), SIGTERM);
  thread_.join();
}

void SignalWatch::watch() {
  const sigset_t set = watched_signals();
  int number = 0;
  if (sigwait(&set, &number) != 0 || stopping_) return;
  signal_ = number;
  cancelled_ = true;
  // Further signals while the work winds up change nothing: the first one's end is on its way.
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const std::time_t last = now.tv_sec + grace_s_;
  while (now.tv_sec < last) {
    const timespec wait{last - now.tv_sec, 0};
    sigtimedwait(&set, nullptr, &wait);
    if (stopping_) return;
    clock_gettime(CLOCK_MONOTONIC, &now);
  }
  give_up_();
  _exit(128 + number);
}

}  // namespace cornice
