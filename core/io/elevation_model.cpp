// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/elevation_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/memory.h"
#include "core/io/raster_file.h"

namespace cornice {
namespace {

/// Parts of a pixel by which grids that are taken for one may be off each other.
constexpr double kGridTolerance = 1e-3;
/// Pixels read beyond the area, so that bilinear heights at its rim have all four corners.
constexpr double kRimPixels = 3.0;

/// What is left of x above a multiple of `step`; 0 where it is a multiple but for rounding.
double phase(double x, double step) {
  const double rest = x - step * std::floor(x / step);
  return rest > step * (1.0 - kGridTolerance) ? rest - step : rest;
}

Box2d box_of(const Raster& r) {
  return {r.west, r.north - r.step * r.height, r.west + r.step * r.width, r.north};
}

/// A readable name for a CRS that may have none.
std::string words(const Crs& crs) {
  if (crs.empty()) return "no CRS";
  return crs.horizontal_epsg != 0 ? crs.text() : crs.name;
}

void check_crs(const std::filesystem::path& path, const Crs& raster, const Crs& wanted) {
  if (same_crs(raster, wanted)) return;
  throw InputError(path.string(),
                   "has " + words(raster) + ", but what it is to fill has " + words(wanted) +
                       "; transform it first (gdalwarp), or say its CRS (gdal_edit.py -a_srs)");
}

}  // namespace

const float* ElevationModel::Grid::pixel(std::int64_t col, std::int64_t row) const {
  const std::int64_t c = col - first_col, r = row - first_row;
  if (c < 0 || r < 0 || c >= width || r >= height) return nullptr;
  const float* value = &heights[static_cast<std::size_t>(r * width + c)];
  return std::isnan(*value) ? nullptr : value;
}

std::optional<ElevationModel::Ground> ElevationModel::Grid::at(double x, double y) const {
  const double u = (x - west) / step, v = (y - south) / step;
  const float* own =
      pixel(static_cast<std::int64_t>(std::floor(u)), static_cast<std::int64_t>(std::floor(v)));
  if (own == nullptr) return std::nullopt;
  const auto col = static_cast<std::int64_t>(std::floor(u - 0.5));
  const auto row = static_cast<std::int64_t>(std::floor(v - 0.5));
  const double fx = u - 0.5 - static_cast<double>(col), fy = v - 0.5 - static_cast<double>(row);
  // Where the data ends, half a pixel of its own height is left.
  const auto corner = [&](int c, int r) {
    const float* value = pixel(col + c, row + r);
    return static_cast<double>(value == nullptr ? *own : *value);
  };
  const double sw = corner(0, 0), se = corner(1, 0), nw = corner(0, 1), ne = corner(1, 1);
  const double south_z = sw + fx * (se - sw), north_z = nw + fx * (ne - nw);
  const double slope_x = (1.0 - fy) * (se - sw) + fy * (ne - nw);
  return Ground{south_z + fy * (north_z - south_z),
                normalized(Vec3d{-slope_x, -(north_z - south_z), step})};
}

void ElevationModel::Grid::add(const Raster& raster) {
  const std::int64_t col0 = std::llround((raster.west - west) / step);
  const std::int64_t row0 = std::llround((raster.north - south) / step) - raster.height;
  const std::int64_t from_row = std::max<std::int64_t>(row0, first_row);
  const std::int64_t to_row = std::min<std::int64_t>(row0 + raster.height, first_row + height);
  const std::int64_t from_col = std::max<std::int64_t>(col0, first_col);
  const std::int64_t to_col = std::min<std::int64_t>(col0 + raster.width, first_col + width);
  for (std::int64_t row = from_row; row < to_row; ++row) {
    for (std::int64_t col = from_col; col < to_col; ++col) {
      const float z = raster.at(static_cast<int>(col - col0),
                                static_cast<int>(raster.height - 1 - (row - row0)));
      float& height_m =
          heights[static_cast<std::size_t>((row - first_row) * width + col - first_col)];
      if (z != raster.no_data && std::isnan(height_m)) height_m = z;
    }
  }
}

ElevationModel::Grid& ElevationModel::grid_for(const std::filesystem::path& path,
                                               const Raster& raster, const Box2d& area) {
  const auto same = [](double a, double b, double step) {
    const double off = std::abs(a - b) / step;
    return std::abs(off - std::round(off)) < kGridTolerance;
  };
  for (Grid& grid : grids_) {
    if (std::abs(grid.step - raster.step) < kGridTolerance * 1e-3 * grid.step &&
        same(grid.west, raster.west, grid.step) && same(grid.south, raster.north, grid.step)) {
      return grid;
    }
  }
  Grid grid;
  grid.step = raster.step;
  grid.west = phase(raster.west, raster.step);
  grid.south = phase(raster.north, raster.step);
  const Box2d wanted = area.grown(kRimPixels * raster.step);
  const auto index = [&](double at, double zero) {
    return static_cast<std::int64_t>(std::floor((at - zero) / grid.step));
  };
  grid.first_col = index(wanted.min_x, grid.west);
  grid.first_row = index(wanted.min_y, grid.south);
  grid.width = index(wanted.max_x, grid.west) + 1 - grid.first_col;
  grid.height = index(wanted.max_y, grid.south) + 1 - grid.first_row;
  const double bytes = static_cast<double>(grid.width) * static_cast<double>(grid.height) * 4.0;
  if (bytes > static_cast<double>(available_memory_bytes())) {
    throw InputError(path.string(), "has pixels of " + std::to_string(raster.step) +
                                        " m, too fine for a tile of this size to fit into memory");
  }
  grid.heights.assign(static_cast<std::size_t>(grid.width * grid.height),
                      std::numeric_limits<float>::quiet_NaN());
  // Finest first; equal ones in the order of the rasters.
  const auto after = std::upper_bound(grids_.begin(), grids_.end(), grid,
                                      [](const Grid& a, const Grid& b) { return a.step < b.step; });
  return *grids_.insert(after, std::move(grid));
}

ElevationModel ElevationModel::read(const std::vector<std::filesystem::path>& rasters,
                                    const std::string& crs, const Box2d& area) {
  ElevationModel model;
  const Crs wanted = crs.empty() ? Crs{} : crs_from_text(crs);
  for (const std::filesystem::path& path : rasters) {
    const Raster head = read_raster_head(path);
    check_crs(path, head.crs, wanted);
    if (area.empty() || !box_of(head).intersects(area.grown(kRimPixels * head.step))) continue;
    model.without_vertical_ += wanted.has_vertical && !head.crs.has_vertical;
    ++model.rasters_used_;
    const Raster raster = read_raster(path);
    require_ground(path, raster.values, raster.no_data);
    model.grid_for(path, head, area).add(raster);
  }
  return model;
}

std::optional<ElevationModel::Ground> ElevationModel::at(double x, double y) const {
  for (const Grid& grid : grids_) {
    if (const std::optional<Ground> ground = grid.at(x, y)) return ground;
  }
  return std::nullopt;
}

}  // namespace cornice
