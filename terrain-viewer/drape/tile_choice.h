// SPDX-License-Identifier: GPL-3.0-or-later
// Which tiles of a draped raster a view needs.
#pragma once

#include <vector>

#include "terrain-viewer/drape/raster_pyramid.h"
#include "terrain-viewer/scene/camera.h"

namespace cornice::viewer {

struct TileView {
  Camera camera;
  double width_over_height = 1.0;
  double height_pixels = 1.0;              ///< of the picture
  double lowest_m = 0.0, highest_m = 0.0;  ///< of the ground
  double wider_deg = 0.0;                  ///< by which more than what is seen is wanted
};

/// Tiles whose texels are at most a pixel large where they are nearest, with all coarser tiles over
/// them: coarse before fine, near before far. Where that would be more than `limit` tiles, texels
/// may be larger, by the same factor everywhere.
std::vector<TileKey> wanted_tiles(const PyramidGrid& grid, const TileView& view, std::size_t limit);

}  // namespace cornice::viewer
