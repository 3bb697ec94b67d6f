// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/frame_pacer.h"

#include <gtest/gtest.h>

namespace cornice::viewer {
namespace {

constexpr double kStepS = 0.02;

/// Draws whenever there is something to draw, in steps of so many seconds.
struct Clock {
  double now_s = 100.0;
  FramePacer pacer{100.0};

  int draw(double seconds, bool moves = false, bool refreshes = false) {
    int frames = 0;
    for (const double end = now_s + seconds - 1e-9; now_s < end;) {
      now_s += kStepS;
      if (!pacer.next(now_s)) continue;
      pacer.drawn(moves, refreshes);
      ++frames;
    }
    return frames;
  }
};

TEST(FramePacer, DrawsWhileSomethingMovesAndAFewFramesAfterNewsAndThenNone) {
  Clock clock;
  EXPECT_EQ(clock.draw(5.0), FramePacer::kFramesAfterNews) << "the first";
  EXPECT_EQ(clock.draw(5.0), 0);
  clock.pacer.wake();
  EXPECT_EQ(clock.draw(5.0, true), 250);
  EXPECT_EQ(clock.draw(5.0), 1) << "the one in which it shows that nothing moves any more";
  clock.pacer.wake();
  EXPECT_EQ(clock.draw(2 * kStepS), 2);
  clock.pacer.wake();
  EXPECT_EQ(clock.draw(5.0), FramePacer::kFramesAfterNews) << "counted from the last";
}

TEST(FramePacer, BringsNumbersUpToDateNowAndThen) {
  Clock clock;
  clock.draw(1.0, false, true);
  const int frames = clock.draw(10.0, false, true);
  EXPECT_GE(frames, 35);
  EXPECT_LE(frames, 40);
  EXPECT_LE(clock.pacer.wait_s(clock.now_s, 10.0), FramePacer::kRefreshS);
  EXPECT_EQ(clock.pacer.wait_s(clock.now_s, 0.01), 0.01);
  clock.draw(1.0);
  EXPECT_EQ(clock.draw(5.0), 0);
  EXPECT_EQ(clock.pacer.wait_s(clock.now_s, 10.0), 10.0);
}

TEST(FramePacer, NothingJumpsAfterAPause) {
  Clock clock;
  clock.draw(100.0);
  clock.pacer.wake();
  clock.now_s += kStepS;
  const auto first = clock.pacer.next(clock.now_s);
  ASSERT_TRUE(first);
  EXPECT_TRUE(first->is_after_pause);
  EXPECT_EQ(first->seconds, FramePacer::kFirstFrameS);
  EXPECT_GT(first->since_last_s, 99.0);
  clock.pacer.drawn(true, false);
  const auto second = clock.pacer.next(clock.now_s + 0.1);
  ASSERT_TRUE(second);
  EXPECT_FALSE(second->is_after_pause);
  EXPECT_NEAR(second->seconds, 0.1, 1e-9) << "what moves goes on with the clock";
  EXPECT_EQ(second->seconds, second->since_last_s);
  const auto slow = clock.pacer.next(clock.now_s + 20.0);
  ASSERT_TRUE(slow);
  EXPECT_EQ(slow->seconds, FramePacer::kLongestFrameS);
  // However short the pause was, no frame counts more than it took.
  for (int i = 0; i < FramePacer::kFramesAfterNews; ++i) clock.pacer.drawn(false, false);
  clock.pacer.wake();
  EXPECT_NEAR(clock.pacer.next(clock.now_s + 20.001)->seconds, 0.001, 1e-9);
}

TEST(FramePacer, AWindowThatIsSeenAgainIsDrawnAtOnceAndNothingJumps) {
  Clock clock;
  clock.draw(1.0);
  clock.pacer.hide();
  clock.now_s += 60.0;
  const auto seen = clock.pacer.next(clock.now_s);
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->seconds, FramePacer::kFirstFrameS);
}

}  // namespace
}  // namespace cornice::viewer
