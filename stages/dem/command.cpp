// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/dem/command.h"

#include <algorithm>
#include <map>

#include "core/base/error.h"
#include "stages/dem/pieces.h"

namespace cornice::dem {

std::vector<Option> describe_meshing(Command& c) {
  return {
      Option("TILES", c.tiles, "DEM tiles of a survey: GeoTIFF (COG too) or ASCII grid")
          .positional(),
      Option("output", c.output, "folder for a mesh of each tile; of --from-mesh a raster, .tif")
          .short_flag('o')
          .required()
          .output(),
      Option("format", c.format, "of the meshes").words({"ply", "obj", "glb"}),
      Option("only", c.only, "tiles to mesh; the other TILES lend their borders"),
      Option("crs", c.survey.crs, "replaces the CRS of the files, such as EPSG:2056+5728"),
      Option("vertical-crs", c.survey.vertical_crs,
             "system of the heights, such as EPSG:5728, where the files do not say it"),
      Option("no-data", c.survey.no_data, "stored value of pixels without a height"),
      Option("resample", c.survey.resample_m,
             "pixel side of a new grid for all tiles, its lines on multiples of it")
          .range(1e-3, 1e5)
          .unit("m"),
      Option("tile-pixels", c.tile_pixels,
             "larger tiles become several meshes; a mesh of 2048 pixels a side takes 0.2 GB")
          .range(16, static_cast<double>(kMostPixelsOfPiece))
          .unit("pixels"),
  };
}

std::vector<Option> describe_rastering(Command& c) {
  return {
      Option("from-mesh", c.meshes,
             "meshes to turn into a raster, .ply: bands highest, lowest, mean, layers"),
      Option("step", c.step_m, "pixel side of that raster, its lines on multiples of it")
          .range(1e-3, 1e5)
          .unit("m"),
      Option("like", c.like, "raster whose grid it gets instead"),
  };
}

void check_command(const Command& c) {
  if (c.tiles.empty() == c.meshes.empty()) {
    throw UsageError(c.tiles.empty() ? "TILES" : "--from-mesh",
                     c.tiles.empty() ? "are missing; name DEM tiles, or meshes after --from-mesh"
                                     : "makes a raster of meshes; leave the TILES away");
  }
  if (c.tiles.empty()) {
    if (c.step_m.has_value() != c.like.empty()) {
      throw UsageError("--step", "give either --step METRES or --like RASTER");
    }
    if (c.output.extension() != ".tif" && c.output.extension() != ".tiff") {
      throw UsageError("--output", "must be a .tif for --from-mesh");
    }
    return;
  }
  if (c.step_m || !c.like.empty()) {
    throw UsageError(c.step_m ? "--step" : "--like",
                     "is for --from-mesh; for tiles say --resample");
  }
  std::map<std::string, std::filesystem::path> names;
  for (const std::filesystem::path& tile : c.tiles) {
    const auto [first, is_new] = names.emplace(stem_of(tile), tile);
    if (is_new) continue;
    throw UsageError(tile.string(), "its mesh would have the name of that of " +
                                        first->second.string() +
                                        "; every tile needs a name of its own");
  }
  for (const std::filesystem::path& tile : c.only) {
    if (std::find(c.tiles.begin(), c.tiles.end(), tile) == c.tiles.end()) {
      throw UsageError("--only", tile.string() + " is none of the TILES");
    }
  }
}

}  // namespace cornice::dem
