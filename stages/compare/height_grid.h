// SPDX-License-Identifier: GPL-3.0-or-later
// Two surfaces on one grid: what a column of ground holds of each.
#pragma once

#include <vector>

#include "core/io/raster.h"
#include "stages/compare/statistics.h"
#include "stages/compare/surface.h"

namespace cornice::compare {

/// Pixels of a north-up grid; pixel (col, row) is a square whose centre is where surfaces are
/// asked.
struct GridFrame {
  double west = 0.0, north = 0.0, step = 1.0;
  int width = 0, height = 0;

  std::size_t pixels() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
};

/// The grid of `step` over `box` whose edges are whole steps from (`west`, `north`).
GridFrame frame_over(const Box2d& box, double step, double west, double north);

/// What stands over the pixels' centres. Of surfaces the highest and the lowest sheet that looks
/// up; of clouds the mean height of a pixel's points.
class HeightGrid {
 public:
  explicit HeightGrid(const GridFrame& frame);
  void add(const Surface& surface);
  /// Call after the last add.
  void finish();

  const GridFrame& frame() const { return frame_; }
  /// NaN where there is nothing.
  float top(std::size_t pixel) const { return top_[pixel]; }
  /// Between the highest and the lowest sheet; 0 where there is one alone.
  float gap(std::size_t pixel) const { return top_[pixel] - bottom_[pixel]; }
  std::uint64_t filled() const;

 private:
  void add_triangle(const Surface& surface, const Triangle& triangle);
  void add_points(const Surface& surface);

  GridFrame frame_;
  std::vector<float> top_, bottom_;
  std::vector<float> sum_;            ///< of clouds, relative to the first point of a pixel
  std::vector<std::uint32_t> count_;  ///< of clouds
};

/// Of a pixel of finished heights: unit normal (Horn 1981) and curvature (Laplacian / 2, positive
/// on crests); straight up where neighbours are missing.
Place place_on_grid(const HeightGrid& heights, std::size_t pixel, bool overhang);

/// b - a where both are; no data elsewhere.
Raster difference(const HeightGrid& a, const HeightGrid& b, const Crs& crs);

/// top() as a raster.
Raster heights_of(const HeightGrid& heights, const Crs& crs);

/// gap() as a raster; 0 where there is one sheet, no data where there is none.
Raster layer_gaps(const HeightGrid& heights, const Crs& crs);

}  // namespace cornice::compare
