// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/controls.h"

#include <gtest/gtest.h>

namespace cornice::viewer {
namespace {

constexpr int kWidth = 800, kHeight = 600;

Camera start() { return {{0.0, 0.0, 500.0}, 0.0, -30.0, 50.0}; }
std::optional<double> flat(double, double) { return 100.0; }

/// Where a pixel of a camera meets the plane z = 100.
std::optional<Vec3d> on_plane(const Camera& camera, double x, double y) {
  const Vec3d ray = ray_of_pixel(camera, kWidth, kHeight, x, y);
  if (ray.z >= 0.0) return std::nullopt;
  return camera.eye + (100.0 - camera.eye.z) / ray.z * ray;
}

ControlInput input_at(double x, double y) {
  ControlInput in;
  in.x = x;
  in.y = y;
  in.width = kWidth;
  in.height = kHeight;
  in.seconds = 0.02;
  return in;
}

TEST(Controls, ALeftDragTurnsAroundThePointUnderTheCursor) {
  Controls controls;
  const auto point = [] { return on_plane(start(), 300.0, 450.0); };
  ControlInput press = input_at(300.0, 450.0);
  press.left = press.pressed = true;
  EXPECT_EQ(controls.step(start(), press, point, flat), start()) << "a press alone moves nothing";
  ControlInput drag = input_at(340.0, 430.0);
  drag.left = true;
  drag.dx = 40.0;
  drag.dy = -20.0;
  const Camera turned = controls.step(start(), drag, point, flat);
  EXPECT_NE(turned, start());
  const auto pixel = pixel_of_point(turned, kWidth, kHeight, *point());
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x, 300.0, 1e-6);
  EXPECT_NEAR(pixel->y, 450.0, 1e-6);
}

TEST(Controls, ARightDragHoldsTheGround) {
  Controls controls;
  ControlInput press = input_at(300.0, 450.0);
  press.right = press.pressed = true;
  const auto point = [] { return on_plane(start(), 300.0, 450.0); };
  controls.step(start(), press, point, flat);
  ControlInput drag = input_at(420.0, 380.0);
  drag.right = true;
  drag.dx = 120.0;
  drag.dy = -70.0;
  const Camera moved = controls.step(start(), drag, point, flat);
  const auto pixel = pixel_of_point(moved, kWidth, kHeight, *point());
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x, 420.0, 1e-6);
  EXPECT_NEAR(pixel->y, 380.0, 1e-6);
}

TEST(Controls, TheWheelGoesToTheCursorAndSetsTheSpeedWhileFlying) {
  Controls controls;
  ControlInput in = input_at(200.0, 500.0);
  in.wheel = 1.0;
  const auto point = [] { return on_plane(start(), 200.0, 500.0); };
  const Camera nearer = controls.step(start(), in, point, flat);
  EXPECT_NEAR(norm(*point() - nearer.eye), 0.8 * norm(*point() - start().eye), 1e-6);
  in.fly.forward = 1.0;
  in.wheel_is_speed = true;
  const double speed = controls.speed_ms;
  controls.step(start(), in, point, flat);
  EXPECT_NEAR(controls.speed_ms, 1.25 * speed, 1e-9);
}

TEST(Controls, NeverGoesUnderTheGroundAndWalksAtEyeHeight) {
  Controls controls;
  ControlInput down = input_at(0.0, 0.0);
  down.fly.up = -1.0;
  down.seconds = 0.1;
  const auto nothing = [] { return std::optional<Vec3d>(); };
  Camera camera = start();
  for (int i = 0; i < 1000; ++i) camera = controls.step(camera, down, nothing, flat);
  EXPECT_NEAR(camera.eye.z, 101.0, 1e-9);
  controls.walks = true;
  ControlInput ahead = input_at(0.0, 0.0);
  ahead.fly.forward = 1.0;
  camera = controls.step(camera, ahead, nothing, flat);
  EXPECT_NEAR(camera.eye.z, 101.7, 1e-9);
}

TEST(Controls, AMotionBeforeThePressIsNoDrag) {
  // A slow frame knows both at once.
  for (int button = 0; button < 3; ++button) {
    Controls controls;
    ControlInput press = input_at(300.0, 450.0);
    (button == 0 ? press.left : button == 1 ? press.middle : press.right) = true;
    press.pressed = true;
    press.dx = 200.0;
    press.dy = -90.0;
    const auto point = [] { return on_plane(start(), 300.0, 450.0); };
    EXPECT_EQ(controls.step(start(), press, point, flat), start()) << button;
  }
}

TEST(Controls, ADoubleClickGoesMostOfTheWayAndNeverThrough) {
  Controls controls;
  ControlInput in = input_at(200.0, 500.0);
  in.is_double_click = true;
  const auto point = [] { return on_plane(start(), 200.0, 500.0); };
  Camera camera = controls.step(start(), in, point, flat);
  EXPECT_NEAR(norm(*point() - camera.eye), 0.25 * norm(*point() - start().eye), 1e-6);
  for (int i = 0; i < 10; ++i) camera = controls.step(camera, in, point, flat);
  EXPECT_NEAR(norm(*point() - camera.eye), 5.0, 1e-6);
  const auto sky = [] { return std::optional<Vec3d>(); };
  EXPECT_EQ(controls.step(start(), in, sky, flat), start());
}

TEST(Controls, WalkingALeftDragLooksAroundAndTheWheelSetsThePace) {
  Controls controls;
  controls.walks = true;
  const Camera standing{{0.0, 0.0, 101.7}, 0.0, -10.0, 50.0};
  ControlInput press = input_at(400.0, 500.0);
  press.left = press.pressed = true;
  const auto point = [&] { return on_plane(standing, 400.0, 500.0); };
  controls.step(standing, press, point, flat);
  ControlInput drag = input_at(440.0, 500.0);
  drag.left = true;
  drag.dx = 40.0;
  const Camera looked = controls.step(standing, drag, point, flat);
  EXPECT_NEAR(norm(looked.eye - standing.eye), 0.0, 1e-12);
  EXPECT_NEAR(looked.heading_deg, 10.0, 1e-12);
  ControlInput wheel = input_at(400.0, 500.0);
  wheel.wheel = 2.0;
  const double flying = controls.speed_ms, pace = controls.walking_speed_ms;
  EXPECT_EQ(controls.step(standing, wheel, point, flat), standing);
  EXPECT_EQ(controls.speed_ms, flying);
  EXPECT_GT(controls.walking_speed_ms, pace);
}

TEST(Controls, KeepsStillWhereNothingIsDone) {
  Controls controls;
  const auto nothing = [] { return std::optional<Vec3d>(); };
  EXPECT_EQ(controls.step(start(), input_at(10.0, 10.0), nothing, flat), start());
}

}  // namespace
}  // namespace cornice::viewer
