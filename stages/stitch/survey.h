// SPDX-License-Identifier: GPL-3.0-or-later
// All tiles of a survey, one at a time in memory: a first pass learns their borders, a second one
// changes and writes them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/mesh/mesh.h"
#include "stages/stitch/border.h"
#include "stages/stitch/edit.h"
#include "stages/stitch/overlap.h"
#include "stages/stitch/plan.h"
#include "stages/stitch/seams.h"

namespace cornice::stitch {

/// What to do with tiles whose surfaces lie over each other.
enum class Overlaps {
  kRefuse,
  kCut,   ///< each keeps its side of the middle
  kKeep,  ///< all stay as they are
};

struct Options {
  double tolerance_m = 0.25;  ///< borders farther apart than this stay apart
  Overlaps overlaps = Overlaps::kRefuse;
  double min_area_m2 = 0.0;  ///< smaller parts of the whole surface go; 0: none
  int threads = 0;
};

/// A survey of which the borders are known. Tiles are in an order that follows from what is in
/// them, whatever order their files were named in.
struct Survey {
  std::vector<std::filesystem::path> paths;
  Borders borders;
  Box3d box;  ///< of all tiles, projected CRS; empty where there is no triangle
  std::string crs_text;
  std::uint64_t empty_tiles = 0;
  std::uint64_t moved_origins = 0;     ///< tiles whose origin is on no common grid
  double largest_coordinate_m = 0.0;   ///< of any tile, from its origin
  std::uint64_t without_crs = 0;       ///< tiles that name no CRS, though others do
  std::vector<std::string> overlaps;   ///< a sentence per pair of tiles that lie over each other
  std::vector<std::vector<Cut>> cuts;  ///< of each tile; empty where there are none
  std::vector<std::vector<std::uint32_t>>
      dropped;  ///< triangles of small parts, of each tile as cut
  std::uint64_t small_parts = 0;
  double small_parts_area_m2 = 0.0;
};

/// Reads a tile. Its origin is put on whole metres where it is no multiple of 1/1024 m: only then
/// can two tiles have the same position. `moved`, where given, gets whether it was.
Mesh read_tile(const std::filesystem::path& path, bool* moved = nullptr);

/// Reads every tile once, those whose boxes share ground once or twice more. Throws InputError for
/// unreadable files, tiles of different CRS, and tiles that lie over each other where they may not.
Survey learn_survey(const std::vector<std::filesystem::path>& paths, const Options& options,
                    Progress& progress = no_progress());

/// The faults of a survey as it is.
SeamReport check_survey(const Survey& survey, const Options& options);

/// What stitching did.
struct StitchResult {
  Plan plan;
  std::uint64_t shared_vertices = 0;
  std::uint64_t flipped_edges = 0;
  std::uint64_t vertices = 0, triangles = 0;  ///< of all tiles
  SeamReport seams;                           ///< of the tiles as written
};

/// Takes a stitched tile: its path as it was read, and what became of it.
using TileSink = std::function<void(const std::filesystem::path&, EditedTile&)>;

/// Reads every tile once more, in order, and hands it to `sink`.
StitchResult stitch_survey(const Survey& survey, const Options& options, const TileSink& sink,
                           Progress& progress = no_progress());

}  // namespace cornice::stitch
