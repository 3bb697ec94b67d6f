// SPDX-License-Identifier: GPL-3.0-or-later
// The tiles of a survey and how they lie beside each other, from the headers of their files alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/vec.h"

namespace cornice::index {

struct IndexOptions {
  /// Of the survey's lattice, metres: tiles' borders are multiples of it.
  double step_m = 0.5;
  /// Tiles nearer than this to each other are neighbours, metres.
  double halo_m = 40.0;
  /// Borders of two tiles that are no further apart than this are one border, metres.
  double seam_m = 2.0;
  /// Replaces the CRS of the files; empty: theirs.
  std::string crs;
};

struct IndexedTile {
  std::filesystem::path path;
  std::string name;  ///< the file's name without ".laz", ".copc.laz", ".las.zip"
  std::uint64_t bytes = 0;
  std::uint64_t points = 0;
  std::string product;  ///< "swisssurface3d", "lidarhd" or "any"
  std::string crs;      ///< as Crs::text()
  Box3d bounds;         ///< of the points, as the header has them
  /// What the tile answers for: multiples of the lattice step; no two tiles' boxes overlap.
  Box2d box;
  std::vector<std::size_t> neighbours;  ///< indices of usable tiles within halo_m, ascending
  std::string problem;                  ///< why the tile cannot be used; empty where it can
};

struct SurveyIndex {
  IndexOptions options;
  std::string crs;                 ///< of the usable tiles, Crs::text()
  std::vector<IndexedTile> tiles;  ///< usable or not, in the order of their names
  std::vector<std::string> warnings;
};

/// Reads the headers and lays out the tiles. A tile's box is, in this order: what the product's
/// file name says; the cell of a regular grid, where all tiles without such a name fit one each;
/// the header's bounds. Boxes whose edges lie within seam_m of each other meet in the middle; where
/// boxes overlap further, the overlap is cut in the middle, and a tile whose middle lies in another
/// tile is a problem. Of tiles in several coordinate systems the most frequent system's are usable,
/// the first one's on a tie.
/// What is wrong with one tile is in its `problem`; throws InputError where no tile is usable, and
/// UsageError for a CRS that is none.
SurveyIndex index_survey(const std::vector<std::filesystem::path>& files,
                         const IndexOptions& options, Progress& progress = no_progress());

/// The document of docs/formats/survey.md.
std::string to_json(const SurveyIndex& survey);

}  // namespace cornice::index
