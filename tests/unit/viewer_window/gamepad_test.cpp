// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/gamepad.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace cornice::viewer {
namespace {

// As SDL's and GLFW's numbers of axes and buttons go.
enum Axis { kLeftX, kLeftY, kRightX, kRightY, kLeftTrigger, kRightTrigger };

PadState pad_with(Axis axis, float value) {
  PadState pad;
  pad.axes[axis] = value;
  return pad;
}

PadMove move_of(const PadState& pad) { return pad_move(std::vector<PadState>{pad}); }

TEST(Gamepad, AtRestOrWithoutOneNothingMoves) {
  for (const auto& pads : {std::vector<PadState>{}, std::vector<PadState>(1)}) {
    const PadMove move = pad_move(pads);
    EXPECT_EQ(move.fly.forward, 0.0);
    EXPECT_EQ(move.fly.right, 0.0);
    EXPECT_EQ(move.fly.up, 0.0) << "triggers rest at -1";
    EXPECT_EQ(move.turn_right, 0.0);
    EXPECT_EQ(move.turn_up, 0.0);
    EXPECT_FALSE(move.is_fast);
  }
}

TEST(Gamepad, TheLeftStickFliesAndTheRightOneTurns) {
  EXPECT_DOUBLE_EQ(move_of(pad_with(kLeftX, 1.0f)).fly.right, 1.0);
  EXPECT_DOUBLE_EQ(move_of(pad_with(kLeftY, -1.0f)).fly.forward, 1.0) << "up is negative";
  EXPECT_DOUBLE_EQ(move_of(pad_with(kRightX, -1.0f)).turn_right, -1.0);
  EXPECT_DOUBLE_EQ(move_of(pad_with(kRightY, -1.0f)).turn_up, 1.0);
}

TEST(Gamepad, TheRightTriggerGoesUpAndTheLeftOneDown) {
  EXPECT_DOUBLE_EQ(move_of(pad_with(kRightTrigger, 1.0f)).fly.up, 1.0);
  EXPECT_DOUBLE_EQ(move_of(pad_with(kLeftTrigger, 1.0f)).fly.up, -1.0);
  PadState both = pad_with(kRightTrigger, 1.0f);
  both.axes[kLeftTrigger] = 1.0f;
  EXPECT_DOUBLE_EQ(move_of(both).fly.up, 0.0);
  EXPECT_NEAR(move_of(pad_with(kRightTrigger, 0.0f)).fly.up, (0.5 - 0.15) / 0.85, 1e-12)
      << "half way";
}

TEST(Gamepad, TheLowerButtonIsFast) {
  PadState pad;
  pad.buttons[0] = 1;
  EXPECT_TRUE(move_of(pad).is_fast);
}

TEST(Gamepad, TheDeadZoneIsContinuousAtItsBorderAndRound) {
  const auto edge = static_cast<float>(kPadDeadZone);
  EXPECT_EQ(move_of(pad_with(kLeftX, 0.99f * edge)).fly.right, 0.0);
  double before = 0.0;
  for (float x = 0.0f; x <= 1.0f; x += 0.001f) {
    const double right = move_of(pad_with(kLeftX, x)).fly.right;
    EXPECT_GE(right, before);
    EXPECT_LE(right - before, 0.0013) << "jumps at " << x;
    EXPECT_DOUBLE_EQ(move_of(pad_with(kLeftX, -x)).fly.right, -right);
    before = right;
  }
  // The same way in all directions: the direction is kept and the length alone counts.
  for (int deg = 0; deg < 360; deg += 15) {
    const double a = deg * 0.017453292519943295;
    PadState pad;
    pad.axes[kLeftX] = static_cast<float>(0.5 * std::cos(a));
    pad.axes[kLeftY] = static_cast<float>(0.5 * std::sin(a));
    const PadMove move = move_of(pad);
    EXPECT_NEAR(std::hypot(move.fly.right, move.fly.forward), 0.35 / 0.85, 1e-6);
    EXPECT_NEAR(move.fly.right * std::sin(a) + move.fly.forward * std::cos(a), 0.0, 1e-6);
  }
}

TEST(Gamepad, TwoPadsAddUpButNoFurtherThanOneCould) {
  const auto both = [](float a, float b) {
    return pad_move(std::vector<PadState>{pad_with(kLeftX, a), pad_with(kLeftX, b)}).fly.right;
  };
  EXPECT_DOUBLE_EQ(both(1.0f, 1.0f), 1.0);
  EXPECT_DOUBLE_EQ(both(1.0f, -1.0f), 0.0);
  EXPECT_DOUBLE_EQ(both(0.0f, 1.0f), 1.0) << "the second alone does as well";
}

TEST(Gamepad, WhatIsNoNumberOrTooMuchDoesNoHarm) {
  EXPECT_EQ(move_of(pad_with(kLeftX, std::numeric_limits<float>::quiet_NaN())).fly.right, 0.0);
  EXPECT_DOUBLE_EQ(move_of(pad_with(kLeftX, 1.2f)).fly.right, 1.0);
  EXPECT_DOUBLE_EQ(move_of(pad_with(kRightTrigger, 1.1f)).fly.up, 1.0);
  EXPECT_EQ(move_of(pad_with(kRightTrigger, -1.1f)).fly.up, 0.0);
}

}  // namespace
}  // namespace cornice::viewer
