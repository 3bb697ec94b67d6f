// SPDX-License-Identifier: GPL-3.0-or-later
// Single-band rasters through GDAL, and pictures through OpenImageIO.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/vec.h"
#include "core/geo/crs.h"

namespace cornice {

/// A north-up grid of heights. Row 0 is the northernmost; pixel (col, row) covers
/// [west + col*step, ...] x [..., north - row*step] (pixel is area).
struct Raster {
  int width = 0;
  int height = 0;
  double west = 0.0;   ///< of the first column's west edge
  double north = 0.0;  ///< of the first row's north edge
  double step = 1.0;   ///< metres per pixel
  float no_data = -9999.0f;
  Crs crs;
  std::vector<float> values;  ///< height * width, row by row

  float& at(int col, int row) { return values[static_cast<std::size_t>(row) * width + col]; }
  float at(int col, int row) const { return values[static_cast<std::size_t>(row) * width + col]; }
};

/// Writes a cloud-optimised GeoTIFF atomically (DEFLATE, predictor 3, tiled, overviews).
/// Throws RunError where it cannot be written (disk full).
void write_cog(const std::filesystem::path& path, const Raster& raster);

/// Reads the first band of a GeoTIFF or ASCII grid, scale and offset applied. What the file marks
/// as no data and what is not finite becomes `no_data`; rows come from the north whatever their
/// order in the file; "pixel is point" grids are given as the areas around their points. The CRS is
/// the file's own, else that of the product's file name. Throws InputError for files that are
/// neither, lack a georeference, are rotated or sheared, or have unequal pixel sides.
Raster read_raster(const std::filesystem::path& path);

/// The same without `values`: where it lies and in which CRS, at little cost.
Raster read_raster_head(const std::filesystem::path& path);

/// 8-bit RGB picture, row by row from the top.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::array<std::uint8_t, 3>> pixels;
};

/// Writes PNG or JPEG by extension, atomically. Throws RunError for other extensions, and where it
/// cannot be written.
void write_picture(const std::filesystem::path& path, const Picture& picture);

/// Hillshade with the light from `azimuth_deg` (clockwise from north) and `altitude_deg`; no-data
/// pixels get `background`. Horn 1981, "Hill shading and the reflectance map".
Picture hillshade(const Raster& raster, double azimuth_deg = 315.0, double altitude_deg = 45.0,
                  std::array<std::uint8_t, 3> background = {255, 255, 255});

}  // namespace cornice
