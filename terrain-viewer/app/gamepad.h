// SPDX-License-Identifier: GPL-3.0-or-later
// From sticks and triggers of gamepads to motion. Knows no window.
#pragma once

#include <array>
#include <span>

#include "terrain-viewer/scene/navigation.h"

namespace cornice::viewer {

/// As GLFW_GAMEPAD_AXIS_ and GLFW_GAMEPAD_BUTTON_ number them: sticks -1..1, right and down
/// positive; triggers -1 at rest, 1 pressed.
struct PadState {
  std::array<float, 6> axes{0.0f, 0.0f, 0.0f, 0.0f, -1.0f, -1.0f};
  std::array<unsigned char, 15> buttons{};
};

/// Each from -1 to 1.
struct PadMove {
  FlyInput fly;
  double turn_right = 0.0, turn_up = 0.0;
  bool is_fast = false;
};

/// Sticks and triggers do nothing until they are this far from rest, and from there on begin at 0.
inline constexpr double kPadDeadZone = 0.15;

/// What all pads together ask for: the left stick flies, the right one turns, the right trigger
/// goes up and the left one down, the lower button is fast.
PadMove pad_move(std::span<const PadState> pads);

}  // namespace cornice::viewer
