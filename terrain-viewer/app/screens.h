// SPDX-License-Identifier: GPL-3.0-or-later
// Which of several screens a window is on.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace cornice::viewer {

/// Upper left corner and size.
struct PixelRectangle {
  int x = 0, y = 0, width = 0, height = 0;
};

/// The screen that shows the largest part of the window, the first of equals; the first where none
/// does. Nothing without screens.
inline std::optional<std::size_t> screen_with_most_of(const PixelRectangle& window,
                                                      const std::vector<PixelRectangle>& screens) {
  const auto common = [](int a, int a_size, int b, int b_size) {
    return std::max(0, std::min(a + a_size, b + b_size) - std::max(a, b));
  };
  std::optional<std::size_t> best;
  std::int64_t most = -1;
  for (std::size_t i = 0; i < screens.size(); ++i) {
    const PixelRectangle& s = screens[i];
    const std::int64_t area = std::int64_t{common(window.x, window.width, s.x, s.width)} *
                              common(window.y, window.height, s.y, s.height);
    if (area > most) {
      most = area;
      best = i;
    }
  }
  return best;
}

}  // namespace cornice::viewer
