// SPDX-License-Identifier: GPL-3.0-or-later
// From keys and the mouse to moves of the camera. Knows no window: what it needs is in
// ControlInput.
#pragma once

#include <optional>

#include "terrain-viewer/scene/navigation.h"

namespace cornice::viewer {

/// What is held and what happened since the frame before.
struct ControlInput {
  FlyInput fly;
  bool is_fast = false;                              ///< Shift
  double x = 0.0, y = 0.0;                           ///< cursor, pixels
  double dx = 0.0, dy = 0.0;                         ///< its motion
  bool left = false, middle = false, right = false;  ///< buttons held
  bool pressed = false;                              ///< one of them went down in this frame
  bool is_double_click = false;
  double wheel = 0.0;                      ///< clicks, away from oneself is positive
  bool wheel_is_speed = false;             ///< the wheel sets the speed
  double turn_right = 0.0, turn_up = 0.0;  ///< of a gamepad, -1..1
  double seconds = 0.0;
  int width = 0, height = 0;
};

/// Distances are metres, angles degrees.
struct Controls {
  double speed_ms = 30.0;  ///< of flying
  double walking_speed_ms = 3.0;
  bool walks = false;
  std::optional<Vec3d> grabbed;  ///< point of the ground that a drag holds

  /// The camera after this frame. point: the ground under the cursor, nothing where there is sky;
  /// asked for only when a drag, a click or the wheel needs it. ground: height in plan.
  Camera step(const Camera& camera, const ControlInput& input,
              const std::function<std::optional<Vec3d>()>& point, const Ground& ground);

  /// Flies again, from where it is; or puts the eye on the ground below it or, where there is none,
  /// on the point under the cursor, from which one walks. Nothing where neither is.
  std::optional<Camera> toggle_walk(const Camera& camera,
                                    const std::function<std::optional<Vec3d>()>& point,
                                    const Ground& ground);
  double speed() const { return walks ? walking_speed_ms : speed_ms; }

 private:
  Camera dragged(const Camera& camera, const ControlInput& input) const;
};

/// True where a person asks for a motion of the camera, which ends one that goes by itself.
bool asks_to_move(const ControlInput& input);

}  // namespace cornice::viewer
