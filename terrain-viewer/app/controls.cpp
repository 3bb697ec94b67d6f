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
constexpr double kNearestGoM = 5.0;
constexpr double kEyeHeightM = 1.7;
constexpr double kLookDeg = 15.0;
constexpr double kClearanceM = 1.0;

}  // namespace

Camera Controls::dragged(const Camera& camera, const ControlInput& in) const {
  if (in.right && grabbed) return pan(camera, *grabbed, in.width, in.height, in.x, in.y);
  const double right = in.dx * kDegreesPerPixel, up = -in.dy * kDegreesPerPixel;
  if (in.left && grabbed && !walks) return orbit(camera, *grabbed, right, up);
  return turn(camera, right, up);
}

Camera Controls::step(const Camera& camera, const ControlInput& in,
                      const std::function<std::optional<Vec3d>()>& point, const Ground& ground) {
  Camera moved = camera;
  if (in.pressed) grabbed = point();
  const bool drags = in.left || in.middle || in.right;
  if (!drags) grabbed.reset();
  // In the frame of the press the cursor's motion came before it: it was no drag yet.
  if (drags && !in.pressed && (in.dx != 0.0 || in.dy != 0.0)) moved = dragged(moved, in);
  if (in.wheel != 0.0) {
    if (in.wheel_is_speed || walks) {
      double& speed = walks ? walking_speed_ms : speed_ms;
      speed = std::clamp(speed * std::pow(kSpeedPerClick, in.wheel), 0.1, 10000.0);
    } else if (const auto target = point()) {
      moved = zoom(moved, *target, std::pow(kZoomPerClick, in.wheel));
    }
  }
  if (in.is_double_click)
    if (const auto target = point()) moved = zoom(moved, *target, kGoShare, kNearestGoM);
  moved = turn(moved, in.turn_right * kTurnDegPerSecond * in.seconds,
               in.turn_up * kTurnDegPerSecond * in.seconds);
  moved =
      (walks ? walk : fly)(moved, in.fly, speed() * (in.is_fast ? kFastFactor : 1.0), in.seconds);
  if (moved == camera) return camera;
  return walks ? on_ground(moved, ground, kEyeHeightM) : above_ground(moved, ground, kClearanceM);
}

std::optional<Camera> Controls::toggle_walk(const Camera& camera,
                                            const std::function<std::optional<Vec3d>()>& point,
                                            const Ground& ground) {
  if (walks) {
    walks = false;
    return camera;
  }
  Camera standing = camera;
  // From above one looked down; on the ground that would be at one's feet.
  standing.pitch_deg = std::clamp(camera.pitch_deg, -kLookDeg, kLookDeg);
  if (ground(camera.eye.x, camera.eye.y))
    standing = on_ground(standing, ground, kEyeHeightM);
  else if (const auto target = point())
    standing.eye = *target + Vec3d{0.0, 0.0, kEyeHeightM};
  else
    return std::nullopt;
  walks = true;
  return standing;
}

bool asks_to_move(const ControlInput& in) {
  const bool flies = in.fly.forward != 0.0 || in.fly.right != 0.0 || in.fly.up != 0.0;
  return flies || in.pressed || in.is_double_click || in.wheel != 0.0 || in.turn_right != 0.0 ||
         in.turn_up != 0.0;
}

}  // namespace cornice::viewer
