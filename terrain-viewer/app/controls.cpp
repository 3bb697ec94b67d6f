// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/controls.h"

#include <algorithm>
#include <cmath>

namespace cornice::viewer {
namespace {

constexpr double kDegreesPerPixel = 0.25;
constexpr double kZoomPerClick = 0.8;
constexpr double kSpeedPerClick = 1.25;
constexpr double kFastFactor = 5.0;
constexpr double kTurnDegPerSecond = 90.0;
constexpr double kGoShare = 0.25;  ///< of the distance that a double click leaves
constexpr double kEyeHeightM = 1.7;
constexpr double kClearanceM = 1.0;

}  // namespace

Camera Controls::step(const Camera& camera, const ControlInput& in,
                      const std::function<std::optional<Vec3d>()>& point, const Ground& ground) {
  Camera moved = camera;
  if (in.pressed) grabbed = point();
  const bool drags = in.left || in.middle || in.right;
  if (!drags) grabbed.reset();
  if (drags && (in.dx != 0.0 || in.dy != 0.0)) {
    if (in.right && grabbed)
      moved = pan(moved, *grabbed, in.width, in.height, in.x, in.y);
    else if (in.left && grabbed)
      moved = orbit(moved, *grabbed, in.dx * kDegreesPerPixel, -in.dy * kDegreesPerPixel);
    else
      moved = turn(moved, in.dx * kDegreesPerPixel, -in.dy * kDegreesPerPixel);
  }
  if (in.wheel != 0.0) {
    if (in.wheel_is_speed) {
      speed_ms = std::clamp(speed_ms * std::pow(kSpeedPerClick, in.wheel), 0.1, 10000.0);
    } else if (const auto target = point()) {
      moved = zoom(moved, *target, std::pow(kZoomPerClick, in.wheel));
    }
  }
  if (in.is_double_click)
    if (const auto target = point()) moved = zoom(moved, *target, kGoShare, 5.0);
  moved = turn(moved, in.turn_right * kTurnDegPerSecond * in.seconds,
               in.turn_up * kTurnDegPerSecond * in.seconds);
  moved = fly(moved, in.fly, speed_ms * (in.is_fast ? kFastFactor : 1.0), in.seconds);
  if (moved == camera) return camera;
  return walks ? on_ground(moved, ground, kEyeHeightM) : above_ground(moved, ground, kClearanceM);
}

}  // namespace cornice::viewer
