// SPDX-License-Identifier: GPL-3.0-or-later
// Rectangles on the grid of pixels that all tiles of a survey share.
#pragma once

#include <algorithm>
#include <cstdint>

namespace cornice::dem {

/// Columns [col, col + width) counted eastwards, rows [row, row + height) counted southwards.
struct PixelRect {
  std::int64_t col = 0;
  std::int64_t row = 0;
  std::int64_t width = 0;
  std::int64_t height = 0;

  friend bool operator==(const PixelRect&, const PixelRect&) = default;
  bool empty() const { return width <= 0 || height <= 0; }
  std::int64_t end_col() const { return col + width; }
  std::int64_t end_row() const { return row + height; }
  std::uint64_t area() const {
    return empty() ? 0 : static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  }
  PixelRect grown(std::int64_t by) const {
    return {col - by, row - by, width + 2 * by, height + 2 * by};
  }
  PixelRect common(const PixelRect& o) const {
    const std::int64_t west = std::max(col, o.col), north = std::max(row, o.row);
    return {west, north, std::min(end_col(), o.end_col()) - west,
            std::min(end_row(), o.end_row()) - north};
  }
};

}  // namespace cornice::dem
