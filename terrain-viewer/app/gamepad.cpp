// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/gamepad.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>

namespace cornice::viewer {
namespace {

/// 0 within the dead zone, 1 at the end; pads may report a little more, or no number.
double beyond_dead_zone(double size) {
  if (!(size > kPadDeadZone)) return 0.0;
  return std::min(1.0, (size - kPadDeadZone) / (1.0 - kPadDeadZone));
}

struct Stick {
  double right = 0.0, down = 0.0;
};

/// The dead zone is round: a square one would pull the stick to its axes.
Stick stick_of(const PadState& pad, int axis_x, int axis_y) {
  const double x = double(pad.axes[static_cast<std::size_t>(axis_x)]);
  const double y = double(pad.axes[static_cast<std::size_t>(axis_y)]);
  const double size = std::hypot(x, y), share = beyond_dead_zone(size);
  if (!(share > 0.0)) return {};
  return {x / size * share, y / size * share};
}

double trigger_of(const PadState& pad, int axis) {
  return beyond_dead_zone(0.5 * (double(pad.axes[static_cast<std::size_t>(axis)]) + 1.0));
}

}  // namespace

PadMove pad_move(std::span<const PadState> pads) {
  PadMove move;
  for (const PadState& pad : pads) {
    const Stick left = stick_of(pad, GLFW_GAMEPAD_AXIS_LEFT_X, GLFW_GAMEPAD_AXIS_LEFT_Y);
    const Stick right = stick_of(pad, GLFW_GAMEPAD_AXIS_RIGHT_X, GLFW_GAMEPAD_AXIS_RIGHT_Y);
    move.fly.right += left.right;
    move.fly.forward -= left.down;
    move.fly.up += trigger_of(pad, GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER) -
                   trigger_of(pad, GLFW_GAMEPAD_AXIS_LEFT_TRIGGER);
    move.turn_right += right.right;
    move.turn_up -= right.down;
    move.is_fast |= pad.buttons[GLFW_GAMEPAD_BUTTON_A] == GLFW_PRESS;
  }
  for (double* value :
       {&move.fly.right, &move.fly.forward, &move.fly.up, &move.turn_right, &move.turn_up})
    *value = std::clamp(*value, -1.0, 1.0);
  return move;
}

}  // namespace cornice::viewer
