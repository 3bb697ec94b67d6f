// SPDX-License-Identifier: GPL-3.0-or-later
// The files of the stage: a tile with its halo in, oriented points out.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/geo/crs.h"
#include "core/io/las.h"
#include "core/points/point_cloud.h"
#include "stages/normals/normals.h"

namespace cornice::normals {

/// Where a tile's points and those around it lie.
struct TileInput {
  std::filesystem::path tile;
  std::vector<std::filesystem::path> neighbours;  ///< the tile itself among them is passed over
  double halo_m = 20.0;  ///< width of the border read around the tile, in the file's unit
  std::string crs;       ///< as LasOpenOptions::crs_override
};

/// Points of a tile, followed by those of its halo.
struct TilePoints {
  PointCloud points;
  std::size_t tile_points = 0;
  LasInfo info;  ///< of the tile
  std::vector<std::string> warnings;
};

/// Points that the headers of the tile and its neighbours promise; the halo counts by area.
std::uint64_t promised_points(const TileInput& input);

/// Reads the tile, and of the neighbours the window around the tile's points. Throws InputError
/// where a neighbour's CRS differs from the tile's.
TilePoints read_tile(const TileInput& input, int threads, Progress& progress = no_progress());

/// Writes oriented points as PLY: normals, quality, line_id, class, intensity, halo where kept.
void write_oriented_ply(const std::filesystem::path& path, Result&& result,
                        const std::string& crs_text);

/// Copies the tile's points that `result` holds, with all their attributes and the extra bytes
/// "normal x", "normal y", "normal z", "quality" and "flight line", in the tile's own order.
/// Needs result.source. Returns the number of points written.
std::uint64_t write_oriented_las(const std::filesystem::path& path, const LasInfo& tile,
                                 const Result& result, int threads,
                                 Progress& progress = no_progress());

}  // namespace cornice::normals
