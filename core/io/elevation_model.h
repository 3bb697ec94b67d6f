// SPDX-License-Identifier: GPL-3.0-or-later
// The ground as rasters of heights have it, at any place.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/vec.h"
#include "core/io/raster.h"

namespace cornice {

/// Heights from one or many rasters; where several have a place, the finer one counts, and of equal
/// ones the one named first. What it says of a place follows from the rasters around that place
/// alone, so two tiles that are given the same rasters get the same heights to the bit.
class ElevationModel {
 public:
  /// Of the part of the rasters in `area` (projected, metres) and a few pixels around it. `crs` is
  /// the CRS text of the points or the mesh that it is for. Throws InputError for rasters that
  /// cannot be read or are in another CRS, also those that do not touch the area.
  static ElevationModel read(const std::vector<std::filesystem::path>& rasters,
                             const std::string& crs, const Box2d& area);

  struct Ground {
    double height_m = 0.0;
    Vec3d normal;  ///< unit, up
  };
  /// Bilinear between pixel centres; nothing where the pixel that (x, y) lies in has no data.
  std::optional<Ground> at(double x, double y) const;

  bool empty() const { return grids_.empty(); }
  /// Side of the finest pixels in the area; 0 where there is none.
  double finest_step_m() const { return grids_.empty() ? 0.0 : grids_.front().step; }
  std::uint64_t rasters_used() const { return rasters_used_; }
  /// Rasters that name no vertical system, though `crs` does: their heights are taken as they are.
  std::uint64_t without_vertical() const { return without_vertical_; }

 private:
  /// All rasters that share their pixels' places, as one.
  struct Grid {
    double step = 1.0;
    double west = 0.0, south = 0.0;  ///< corner of pixel (0, 0); below one step from a multiple
    std::int64_t first_col = 0, first_row = 0;
    std::int64_t width = 0, height = 0;
    std::vector<float> heights;  ///< rows from the south; not a number where there is none

    const float* pixel(std::int64_t col, std::int64_t row) const;
    std::optional<Ground> at(double x, double y) const;
    void add(const Raster& raster);
  };
  Grid& grid_for(const std::filesystem::path& path, const Raster& raster, const Box2d& area);

  std::vector<Grid> grids_;  ///< finest first
  std::uint64_t rasters_used_ = 0;
  std::uint64_t without_vertical_ = 0;
};

}  // namespace cornice
