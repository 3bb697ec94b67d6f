// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/scale_bar.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace cornice::viewer {
namespace {

constexpr int kWidth = 640, kHeight = 480;

Camera some_camera() { return {{2'600'000.0, 1'200'000.0, 2500.0}, 200.0, -30.0, 50.0}; }

TEST(ScaleBar, IsAsLongInThePictureAsItsLengthLooks) {
  const Camera camera = some_camera();
  const CameraAxes axes = axes_of(camera);
  for (const double depth : {3.0, 47.0, 800.0, 12'345.0, 90'000.0}) {
    const ScaleBar bar = scale_bar(camera, kHeight, depth, 180.0);
    // Both ends of it, across the line of sight at that depth.
    const Vec3d middle = camera.eye + depth * axes.forward;
    const auto left =
        pixel_of_point(camera, kWidth, kHeight, middle - 0.5 * bar.length_m * axes.right);
    const auto right =
        pixel_of_point(camera, kWidth, kHeight, middle + 0.5 * bar.length_m * axes.right);
    ASSERT_TRUE(left && right);
    EXPECT_NEAR(right->x - left->x, bar.pixels, 1e-6) << depth;
    EXPECT_NEAR(right->y, left->y, 1e-6);
  }
}

TEST(ScaleBar, IsTheLongestRoundOneThatFits) {
  for (double depth = 1.0; depth < 1e5; depth *= 1.37) {
    const ScaleBar bar = scale_bar(some_camera(), kHeight, depth, 180.0);
    EXPECT_LE(bar.pixels, 180.0);
    EXPECT_GT(bar.pixels, 180.0 / 2.5 - 1e-9) << depth;
    const double digits =
        bar.length_m / std::pow(10.0, std::floor(std::log10(bar.length_m) + 1e-9));
    EXPECT_TRUE(std::abs(digits - 1.0) < 1e-9 || std::abs(digits - 2.0) < 1e-9 ||
                std::abs(digits - 5.0) < 1e-9)
        << bar.length_m;
  }
}

TEST(ScaleBar, SaysMetresAndKilometres) {
  // One pixel is one metre at this depth.
  Camera camera = some_camera();
  const double depth = 0.5 * kHeight / std::tan(0.5 * camera.field_of_view_deg * 0.017453292519943);
  EXPECT_EQ(scale_bar(camera, kHeight, depth, 180.0).label, "100 m");
  EXPECT_NEAR(scale_bar(camera, kHeight, depth, 180.0).pixels, 100.0, 1e-6);
  EXPECT_EQ(scale_bar(camera, kHeight, 0.01 * depth, 180.0).label, "1 m");
  EXPECT_EQ(scale_bar(camera, kHeight, 0.003 * depth, 180.0).label, "0.5 m");
  EXPECT_EQ(scale_bar(camera, kHeight, 30.0 * depth, 180.0).label, "5 km");
}

TEST(ScalePlace, IsTheCornerWhereThatIsFreeAndAboveTheReadOutElsewhere) {
  const ScalePlace free = scale_place(1280, 720, 180.0f, 400.0f, 640.0f);
  EXPECT_EQ(free.right, 1256.0f);
  EXPECT_EQ(free.low, 696.0f);
  const ScalePlace narrow = scale_place(520, 480, 180.0f, 400.0f, 405.0f);
  EXPECT_LT(narrow.low, 405.0f);
  EXPECT_EQ(narrow.right, 496.0f);
}

}  // namespace
}  // namespace cornice::viewer
