// SPDX-License-Identifier: GPL-3.0-or-later
// The DEM tiles of a survey as one grid of heights.
#pragma once

#include <cstdint>
#include <filesystem>
#include <list>
#include <optional>
#include <string>
#include <vector>

#include "core/geo/crs.h"
#include "core/io/raster_file.h"
#include "stages/dem/pixel_rect.h"

namespace cornice::dem {

/// What the tiles' own headers do not say, or say wrongly.
struct SurveyOptions {
  std::string crs;                   ///< replaces the CRS of the files; empty: theirs
  std::string vertical_crs;          ///< of the heights, "EPSG:5728"; empty: that of the files
  std::optional<double> no_data;     ///< as stored, in place of what the files say
  std::optional<double> resample_m;  ///< pixels of the common grid; nothing: those of the tiles
};

/// One input file and its place on the common grid.
struct Tile {
  std::filesystem::path path;
  RasterHead head;
  PixelRect rect;
};

/// All tiles of a survey. Heights are those of pixel centres: of tiles that overlap the first in
/// order counts. Thread contract: one thread at a time.
class Survey {
 public:
  /// Reads the headers. The tiles are put in order from north to south, then west to east, whatever
  /// their order in `paths`. Throws InputError for a tile without CRS, in degrees or feet, in
  /// another CRS than the others, or off their common grid while no resampling is asked for.
  Survey(const std::vector<std::filesystem::path>& paths, const SurveyOptions& options);

  const std::vector<Tile>& tiles() const { return tiles_; }
  const Crs& crs() const { return crs_; }
  double step() const { return step_; }
  /// Centre of a column's or row's pixels, projected metres.
  double east_of(std::int64_t col) const {
    return west_ + (static_cast<double>(col) + 0.5) * step_;
  }
  double north_of(std::int64_t row) const {
    return north_ - (static_cast<double>(row) + 0.5) * step_;
  }
  /// Lines that the user should see.
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Heights of a window, row by row from the north; not-a-number where no tile has any. Throws
  /// InputError for heights that no ground has: they are a no-data value that the file does not
  /// declare.
  std::vector<float> read(const PixelRect& window);

  /// Parts of `rect`, which lies in tile `index`, that a tile before it in order covers as well.
  std::vector<PixelRect> taken(std::size_t index, const PixelRect& rect) const;

  /// Bytes that one window of so many pixels needs while it is read.
  std::uint64_t window_bytes(std::uint64_t pixels) const;

 private:
  void check_crs(const SurveyOptions& options);
  void lay_out(const SurveyOptions& options);
  void find_overlaps();
  void find_islands();
  RasterFile& open(std::size_t index);
  void add_tile(std::size_t index, const PixelRect& window, std::vector<float>& heights);
  void read_part(std::size_t index, const PixelRect& part, float* to, std::size_t stride);

  std::vector<Tile> tiles_;
  Crs crs_;
  double west_ = 0.0;
  double north_ = 0.0;
  double step_ = 1.0;
  bool is_resampled_ = false;
  std::optional<double> no_data_;
  std::vector<std::string> warnings_;
  std::list<std::pair<std::size_t, RasterFile>> open_;  ///< last used first
};

}  // namespace cornice::dem
