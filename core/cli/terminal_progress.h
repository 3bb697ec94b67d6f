// SPDX-License-Identifier: GPL-3.0-or-later
// Progress on stderr: a bar with the time left on a terminal, a bounded number of lines in a log.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>

#include "core/base/progress.h"

namespace cornice {

enum class ProgressStyle { kNone, kLines, kBar };

/// Thread contract: advance() and cancelled() from any thread, begin() and end() from one.
class TerminalProgress : public Progress {
 public:
  /// cancelled: set from outside once the work shall stop; must outlive this.
  TerminalProgress(ProgressStyle style, const std::atomic<bool>& cancelled);
  ~TerminalProgress() override;
  TerminalProgress(const TerminalProgress&) = delete;
  TerminalProgress& operator=(const TerminalProgress&) = delete;
  void begin(std::string_view step, std::uint64_t total) override;
  void advance(std::uint64_t work) override;
  void end() override;
  bool cancelled() const override { return cancelled_; }

  /// A run of many thousand steps must not fill the log: no more lines than this.
  static constexpr int kMaxLines = 200;

 private:
  using Clock = std::chrono::steady_clock;
  void show(std::uint64_t done, double elapsed_s);
  void line(const std::string& text);

  const ProgressStyle style_;
  const std::atomic<bool>& cancelled_;
  std::atomic<std::uint64_t> done_{0};
  std::atomic<Clock::rep> next_show_{0};
  std::mutex mutex_;
  std::string step_;
  std::uint64_t total_ = 0;
  Clock::time_point start_;
  int lines_ = 0;
  bool running_ = false;
};

/// "fit  [#####.....]  50 %  1:05 left" of at most `width` columns. total 0: work done and rate.
std::string progress_bar_text(const std::string& step, std::uint64_t done, std::uint64_t total,
                              double elapsed_s, int width);

/// The sign of life of a long step in a log: "fit, 25 %: 10.0 s, 0:30 left".
std::string progress_line_text(const std::string& step, std::uint64_t done, std::uint64_t total,
                               double elapsed_s);

/// "0:07", "12:05", "3:00:00".
std::string duration_text(double elapsed_s);

}  // namespace cornice
