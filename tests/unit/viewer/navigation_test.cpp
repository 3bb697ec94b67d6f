// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/scene/navigation.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cornice::viewer {
namespace {

constexpr int kWidth = 800, kHeight = 600;

Camera some_camera() { return {{1000.0, 2000.0, 1500.0}, 60.0, -25.0, 50.0}; }

void expect_pixel(const Camera& camera, Vec3d point, double x, double y) {
  const auto pixel = pixel_of_point(camera, kWidth, kHeight, point);
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x, x, 1e-6);
  EXPECT_NEAR(pixel->y, y, 1e-6);
}

TEST(Navigation, OrbitKeepsThePivotInItsPixelAndAtItsDistance) {
  const Camera camera = some_camera();
  const Vec3d pivot = camera.eye + 700.0 * ray_of_pixel(camera, kWidth, kHeight, 610.0, 120.0);
  for (const double step : {-40.0, 3.0, 25.0}) {
    const Camera turned = orbit(camera, pivot, step, 0.5 * step);
    expect_pixel(turned, pivot, 610.0, 120.0);
    EXPECT_NEAR(norm(pivot - turned.eye), 700.0, 1e-9);
  }
}

TEST(Navigation, PanBringsTheGrabbedPointUnderTheCursor) {
  const Camera camera = some_camera();
  const Vec3d point = camera.eye + 450.0 * ray_of_pixel(camera, kWidth, kHeight, 100.0, 500.0);
  const Camera moved = pan(camera, point, kWidth, kHeight, 420.0, 333.0);
  expect_pixel(moved, point, 420.0, 333.0);
  EXPECT_EQ(moved.heading_deg, camera.heading_deg);
}

TEST(Navigation, ZoomKeepsTheTargetInItsPixelAndNeverPassesIt) {
  Camera camera = some_camera();
  const Vec3d target = camera.eye + 300.0 * ray_of_pixel(camera, kWidth, kHeight, 250.0, 420.0);
  for (int click = 0; click < 60; ++click) {
    camera = zoom(camera, target, 0.8);
    expect_pixel(camera, target, 250.0, 420.0);
  }
  EXPECT_NEAR(norm(target - camera.eye), 0.5, 1e-6);
}

TEST(Navigation, FliesAlongTheLineOfSightAtTheSpeedAsked) {
  const Camera camera = some_camera();
  const Camera moved = fly(camera, {1.0, 0.0, 0.0}, 30.0, 2.0);
  EXPECT_NEAR(norm(moved.eye - camera.eye), 60.0, 1e-9);
  EXPECT_NEAR(dot(moved.eye - camera.eye, axes_of(camera).forward), 60.0, 1e-9);
}

TEST(Navigation, NeverTurnsOverTheTop) {
  Camera camera = some_camera();
  for (int i = 0; i < 100; ++i) camera = turn(camera, 7.0, 10.0);
  EXPECT_LT(camera.pitch_deg, 90.0);
  EXPECT_GE(camera.heading_deg, 0.0);
  EXPECT_LT(camera.heading_deg, 360.0);
}

TEST(Navigation, StaysAboveTheGround) {
  const Ground slope = [](double x, double) -> std::optional<double> {
    if (x > 5000.0) return std::nullopt;
    return 1600.0 + 0.1 * x;
  };
  const Camera raised = above_ground(some_camera(), slope, 5.0);
  EXPECT_NEAR(raised.eye.z, 1705.0, 1e-9);
  EXPECT_NEAR(on_ground(some_camera(), slope, 1.7).eye.z, 1701.7, 1e-9);
  Camera outside = some_camera();
  outside.eye.x = 6000.0;
  EXPECT_EQ(above_ground(outside, slope, 5.0), outside);
}

TEST(Navigation, SeesAllCornersOfTheBoxItIsToShow) {
  for (const double shape : {0.5, 1.0, 2.4}) {
    const int width = static_cast<int>(kHeight * shape);
    const Vec3d low{0.0, 0.0, 400.0}, high{3000.0, 1000.0, 2400.0};
    const Camera camera = seeing_all(Camera{}, low, high, shape);
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d p{(corner & 1) != 0 ? high.x : low.x, (corner & 2) != 0 ? high.y : low.y,
                    (corner & 4) != 0 ? high.z : low.z};
      const auto pixel = pixel_of_point(camera, width, kHeight, p);
      ASSERT_TRUE(pixel);
      EXPECT_GE(pixel->x, -0.5);
      EXPECT_LE(pixel->x, width);
      EXPECT_GE(pixel->y, -0.5);
      EXPECT_LE(pixel->y, kHeight);
    }
  }
}

TEST(CameraHistory, GoesBackAndForthAndForgetsWhatWasUndone) {
  CameraHistory history;
  EXPECT_FALSE(history.undo());
  Camera a = some_camera(), b = turn(a, 10.0, 0.0), c = turn(b, 10.0, 0.0);
  history.add(a);
  history.add(b);
  history.add(b);
  EXPECT_EQ(history.undo(), a);
  EXPECT_FALSE(history.undo());
  EXPECT_EQ(history.redo(), b);
  EXPECT_FALSE(history.redo());
  EXPECT_EQ(history.undo(), a);
  history.add(c);
  EXPECT_FALSE(history.redo());
  EXPECT_EQ(history.undo(), a);
}

TEST(PlaceText, ReadsProjectedAndGeographicPlaces) {
  const auto lv95 = parse_place("2643500, 1158000, 2400");
  ASSERT_TRUE(lv95);
  EXPECT_FALSE(lv95->is_globe);
  EXPECT_EQ(lv95->first, 2643500.0);
  EXPECT_EQ(lv95->z, 2400.0);
  const auto globe = parse_place("46.5 8.1");
  ASSERT_TRUE(globe);
  EXPECT_TRUE(globe->is_globe);
  const auto south = parse_place("22.95S 43.2W");
  ASSERT_TRUE(south);
  EXPECT_EQ(south->first, -22.95);
  EXPECT_EQ(south->second, -43.2);
  for (const char* text : {"", "12", "a b", "1 2 3 4", "96N 8E", "46.5N"})
    EXPECT_FALSE(parse_place(text)) << text;
}

}  // namespace
}  // namespace cornice::viewer
