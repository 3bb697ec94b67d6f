// SPDX-License-Identifier: GPL-3.0-or-later
// The line between two pictures: dragged by the mouse, with the names of what is on either side.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace cornice::viewer {

/// What one hand on the line does. Pixels of any one kind.
struct LineMouse {
  double x = 0.0;        ///< cursor
  bool pressed = false;  ///< the left button went down in this frame
  bool held = false;     ///< it is down
  bool is_free = true;   ///< no panel has the mouse
  double width = 1.0;    ///< of both pictures together
};

class SwipeLine {
 public:
  /// The cursor takes hold of the line from as far away.
  static constexpr double kReachPixels = 6.0;

  double share = 0.5;  ///< where it stands, of the width

  /// Once a frame while the line is shown. True while it has the mouse: near it or dragging it.
  bool step(const LineMouse& mouse);
  bool is_dragged() const { return offset_.has_value(); }
  void let_go() { offset_.reset(); }

 private:
  std::optional<double> offset_;  ///< of the line from the cursor while it is dragged
};

/// What is seen on the left and on the right of it.
struct SideNames {
  std::string left, right;
};

/// visible: names of the visible layers in their order. cover: what lies over the ground, empty
/// where nothing does. As Session draws two pictures: the last layer against the others or, of a
/// single layer, what lies over it against its own colours.
SideNames side_names(const std::vector<std::string>& visible, const std::string& cover);

}  // namespace cornice::viewer
