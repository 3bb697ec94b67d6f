// SPDX-License-Identifier: GPL-3.0-or-later
// SIGINT and SIGTERM as a flag that long work looks at.
#pragma once

#include <atomic>
#include <functional>
#include <thread>

namespace cornice {

/// While it lives, SIGINT and SIGTERM set cancelled() instead of ending the process. Must be made
/// before any other thread, for threads inherit the signal mask. A process that goes on for
/// `grace_s` after the first signal calls `give_up` and exits with 128 + signal.
class SignalWatch {
 public:
  SignalWatch(int grace_s, std::function<void()> give_up);
  ~SignalWatch();
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;

  const std::atomic<bool>& cancelled() const { return cancelled_; }
  /// The signal that came; 0 where none.
  int signal_number() const { return signal_; }

 private:
  void watch();

  const int grace_s_;
  const std::function<void()> give_up_;
  std::atomic<bool> cancelled_{false};
  std::atomic<int> signal_{0};
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace cornice
