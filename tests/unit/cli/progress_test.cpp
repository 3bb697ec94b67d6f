// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "core/cli/log.h"
#include "core/cli/terminal_progress.h"
#include "tests/support/process.h"

namespace cornice {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;
using testing::internal::CaptureStderr;
using testing::internal::GetCapturedStderr;

TEST(ProgressBar, ShowsShareAndTimeLeft) {
  const std::string text = progress_bar_text("fit", 25, 100, 10.0, 100);
  EXPECT_THAT(text, HasSubstr("fit"));
  EXPECT_THAT(text, HasSubstr(" 25 %"));
  EXPECT_THAT(text, HasSubstr("0:30 left"));
}

TEST(ProgressBar, NeverFillsTheTerminalsLastColumn) {
  for (const int width : {1, 5, 20, 40, 60, 200}) {
    const std::string text = progress_bar_text("a rather long step", 7, 9, 3.0, width);
    EXPECT_LE(static_cast<int>(text.size()), std::max(1, width - 1)) << width;
  }
}

TEST(ProgressBar, StaysSensibleForOddNumbers) {
  EXPECT_THAT(progress_bar_text("fit", 0, 100, 0.0, 100), HasSubstr("  0 %"));
  EXPECT_THAT(progress_bar_text("fit", 300, 100, 1.0, 100), HasSubstr("100 %"));
  EXPECT_THAT(progress_bar_text("fit", 300, 0, 2.0, 100), HasSubstr("300 done, 150/s"));
}

TEST(ProgressLine, ShowsShareAndTimeLeft) {
  EXPECT_EQ(progress_line_text("fit", 25, 100, 10.0), "fit, 25 %: 10.0 s, 0:30 left");
  EXPECT_EQ(progress_line_text("fit", 0, 100, 31.0), "fit, 0 %: 31.0 s");
  EXPECT_EQ(progress_line_text("fit", 300, 0, 2.0), "fit 300 done after: 2.0 s");
}

TEST(DurationText, ReadsLikeAClock) {
  EXPECT_EQ(duration_text(0.2), "0:00");
  EXPECT_EQ(duration_text(65), "1:05");
  EXPECT_EQ(duration_text(3600), "1:00:00");
  EXPECT_EQ(duration_text(-3), "0:00");
}

TEST(TerminalProgress, WritesOnePlainLinePerStepInALog) {
  set_up_log("cornice-probe", "info");
  const std::atomic<bool> cancelled{false};
  CaptureStderr();
  {
    TerminalProgress progress(ProgressStyle::kLines, cancelled);
    progress.begin("read", 1000);
    for (int i = 0; i < 1000; ++i) progress.advance(1);
    progress.begin("fit", 10);  // ends the step before
    progress.advance(10);
    progress.end();
  }
  const std::string text = GetCapturedStderr();
  EXPECT_EQ(test::line_count(text), 2u) << text;
  EXPECT_THAT(text, ContainsRegex("cornice-probe: read: [0-9.]+ s\n"));
  EXPECT_EQ(text.find('\r'), std::string::npos);
}

TEST(TerminalProgress, WritesABoundedNumberOfLines) {
  set_up_log("cornice-probe", "info");
  const std::atomic<bool> cancelled{false};
  CaptureStderr();
  {
    TerminalProgress progress(ProgressStyle::kLines, cancelled);
    for (int i = 0; i < 5000; ++i) {
      progress.begin("tile", 1);
      progress.advance(1);
      progress.end();
    }
  }
  const std::string text = GetCapturedStderr();
  EXPECT_EQ(test::line_count(text), static_cast<std::size_t>(TerminalProgress::kMaxLines) + 1);
  EXPECT_THAT(text, HasSubstr("further steps are not shown"));
}

TEST(TerminalProgress, WritesNothingWhenToldSo) {
  const std::atomic<bool> cancelled{false};
  CaptureStderr();
  {
    TerminalProgress progress(ProgressStyle::kNone, cancelled);
    progress.begin("fit", 10);
    progress.advance(10);
    progress.end();
  }
  EXPECT_EQ(GetCapturedStderr(), "");
}

TEST(TerminalProgress, KeepsLogLinesWholeWhileABarIsShown) {
  set_up_log("cornice-probe", "info");
  const std::atomic<bool> cancelled{false};
  CaptureStderr();
  {
    TerminalProgress progress(ProgressStyle::kBar, cancelled);
    progress.begin("fit", 100);
    std::this_thread::sleep_for(std::chrono::milliseconds(120));
    progress.advance(50);
    log_warning("look at this");
    progress.end();
  }
  const std::string text = GetCapturedStderr();
  EXPECT_THAT(text, HasSubstr("50 %"));
  EXPECT_THAT(text, HasSubstr("\r\x1b[Kcornice-probe: warning: look at this\n"));
  EXPECT_THAT(text, ContainsRegex("\r\x1b\\[Kcornice-probe: fit: [0-9.]+ s\n"));
}

TEST(TerminalProgress, CountsWorkOfSeveralThreads) {
  const std::atomic<bool> cancelled{false};
  CaptureStderr();
  {
    TerminalProgress progress(ProgressStyle::kBar, cancelled);
    progress.begin("fit", 40000);
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&] {
        for (int i = 0; i < 9000; ++i) progress.advance(1);
      });
    }
    for (std::thread& thread : threads) thread.join();
    std::this_thread::sleep_for(std::chrono::milliseconds(120));
    progress.advance(0);
    progress.end();
  }
  EXPECT_THAT(GetCapturedStderr(), HasSubstr(" 90 %"));
}

TEST(TerminalProgress, PassesCancellationOn) {
  std::atomic<bool> cancelled{false};
  const TerminalProgress progress(ProgressStyle::kNone, cancelled);
  EXPECT_NO_THROW(check_cancelled(progress));
  cancelled = true;
  EXPECT_THROW(check_cancelled(progress), Cancelled);
}

}  // namespace
}  // namespace cornice
