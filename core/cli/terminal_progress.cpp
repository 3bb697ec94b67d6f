// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/cli/terminal_progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/cli/console.h"
#include "core/cli/log.h"

namespace cornice {
namespace {

using std::chrono::duration;
using std::chrono::duration_cast;
using std::chrono::milliseconds;
using std::chrono::seconds;

// A bar is redrawn about as often as an eye notices; a log gets a sign of life now and then.
constexpr milliseconds kBarInterval{100};
constexpr seconds kLineInterval{30};

std::string step_text(const std::string& step, double elapsed_s) {
  char text[32];
  std::snprintf(text, sizeof text, ": %.1f s", elapsed_s);
  return step + text;
}

}  // namespace

std::string duration_text(double elapsed_s) {
  const auto whole = static_cast<long long>(std::lround(std::clamp(elapsed_s, 0.0, 3.6e8)));
  char text[48];
  if (whole >= 3600) {
    std::snprintf(text, sizeof text, "%lld:%02lld:%02lld", whole / 3600, whole / 60 % 60,
                  whole % 60);
  } else {
    std::snprintf(text, sizeof text, "%lld:%02lld", whole / 60, whole % 60);
  }
  return text;
}

namespace {

/// "1:05 left", if everything goes on as it did; empty at the very beginning.
std::string time_left(double share, double elapsed_s) {
  return share > 0.0 ? duration_text(elapsed_s * (1.0 - share) / share) + " left" : "";
}

}  // namespace

std::string progress_line_text(const std::string& step, std::uint64_t done, std::uint64_t total,
                               double elapsed_s) {
  if (total == 0) return step_text(step + " " + std::to_string(done) + " done after", elapsed_s);
  const double share = std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
  char text[32];
  std::snprintf(text, sizeof text, ", %.0f %%", std::floor(share * 100.0));
  const std::string left = time_left(share, elapsed_s);
  return step_text(step + text, elapsed_s) + (left.empty() ? "" : ", " + left);
}

std::string progress_bar_text(const std::string& step, std::uint64_t done, std::uint64_t total,
                              double elapsed_s, int width) {
  char tail[64];
  std::string bar;
  if (total == 0) {
    const double rate = elapsed_s > 0.0 ? static_cast<double>(done) / elapsed_s : 0.0;
    std::snprintf(tail, sizeof tail, "  %llu done, %.3g/s", static_cast<unsigned long long>(done),
                  rate);
  } else {
    const double share = std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
    constexpr int kCells = 30;
    const int full = static_cast<int>(share * kCells);
    bar = "  [" + std::string(full, '#') + std::string(kCells - full, '.') + "]";
    const std::string left = time_left(share, elapsed_s);
    std::snprintf(tail, sizeof tail, " %3.0f %%  %s", std::floor(share * 100.0), left.c_str());
  }
  std::string text = step + bar + tail;
  // A line as wide as the terminal would wrap and could not be redrawn.
  if (static_cast<int>(text.size()) >= width) text = step + tail;
  return text.substr(0, static_cast<std::size_t>(std::max(1, width - 1)));
}

TerminalProgress::TerminalProgress(ProgressStyle style, const std::atomic<bool>& cancelled)
    : style_(style), cancelled_(cancelled) {}

TerminalProgress::~TerminalProgress() {
  if (style_ == ProgressStyle::kBar) console_bar("");
}

void TerminalProgress::begin(std::string_view step, std::uint64_t total) {
  end();
  const std::lock_guard lock(mutex_);
  step_ = step;
  total_ = total;
  done_ = 0;
  start_ = Clock::now();
  const auto wait = style_ == ProgressStyle::kBar ? duration_cast<Clock::duration>(kBarInterval)
                                                  : duration_cast<Clock::duration>(kLineInterval);
  next_show_ = (start_ + wait).time_since_epoch().count();
  running_ = true;
}

void TerminalProgress::advance(std::uint64_t work) {
  const std::uint64_t done = done_ += work;
  if (style_ == ProgressStyle::kNone) return;
  const Clock::time_point now = Clock::now();
  if (now.time_since_epoch().count() < next_show_) return;
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock || !running_ || now.time_since_epoch().count() < next_show_) return;
  show(done, duration<double>(now - start_).count());
  const auto wait = style_ == ProgressStyle::kBar ? duration_cast<Clock::duration>(kBarInterval)
                                                  : duration_cast<Clock::duration>(kLineInterval);
  next_show_ = (now + wait).time_since_epoch().count();
}

void TerminalProgress::end() {
  const std::lock_guard lock(mutex_);
  if (!running_) return;
  running_ = false;
  if (style_ == ProgressStyle::kNone) return;
  if (style_ == ProgressStyle::kBar) console_bar("");
  line(step_text(step_, duration<double>(Clock::now() - start_).count()));
}

void TerminalProgress::show(std::uint64_t done, double elapsed_s) {
  if (style_ == ProgressStyle::kBar) {
    console_bar(progress_bar_text(step_, done, total_, elapsed_s, console_width()));
  } else {
    line(progress_line_text(step_, done, total_, elapsed_s));
  }
}

void TerminalProgress::line(const std::string& text) {
  if (lines_ < kMaxLines) {
    log_info(text);
  } else if (lines_ == kMaxLines) {
    log_info("further steps are not shown");
  }
  ++lines_;
}

}  // namespace cornice
