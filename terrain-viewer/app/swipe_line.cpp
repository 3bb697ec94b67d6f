// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/swipe_line.h"

#include <algorithm>
#include <cmath>

namespace cornice::viewer {

bool SwipeLine::step(const LineMouse& mouse) {
  if (!mouse.held) offset_.reset();
  const double line = share * mouse.width;
  const bool is_near = mouse.is_free && std::abs(mouse.x - line) <= kReachPixels;
  if (mouse.pressed && is_near) offset_ = line - mouse.x;
  // It neither jumps to the cursor when it is taken nor leaves the picture.
  if (offset_) share = std::clamp((mouse.x + *offset_) / std::max(1.0, mouse.width), 0.0, 1.0);
  return is_dragged() || (is_near && !mouse.held);
}

SideNames side_names(const std::vector<std::string>& visible, const std::string& cover) {
  if (visible.empty()) return {};
  if (visible.size() == 1) return {visible.front(), cover};
  std::string others;
  for (std::size_t i = 0; i + 1 < visible.size(); ++i)
    others += (others.empty() ? "" : ", ") + visible[i];
  return {others, visible.back()};
}

}  // namespace cornice::viewer
