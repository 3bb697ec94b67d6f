// SPDX-License-Identifier: GPL-3.0-or-later
// A raster that lies over a scene, photograph or values, read in tiles of any level of detail
// through GDAL.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace cornice::viewer {

/// Texels of a tile's side; a border of one texel on each side is its neighbours'.
inline constexpr int kTileTexels = 256;
inline constexpr int kTileSide = kTileTexels + 2;

/// Level 0 is the finest; a texel of a level is two of the level below. Rows count from the north.
struct TileKey {
  int level = 0, column = 0, row = 0;
  friend bool operator==(const TileKey&, const TileKey&) = default;
};
struct TileKeyHash {
  std::size_t operator()(const TileKey& key) const {
    const auto part = [](int value) { return static_cast<std::uint64_t>(value); };
    return std::hash<std::uint64_t>{}((part(key.level) << 58) | (part(key.column) << 29) |
                                      part(key.row));
  }
};

/// Where the texels of a raster lie.
struct PyramidGrid {
  static constexpr int kMostLevels = 24;

  int width = 0, height = 0;            ///< texels of level 0
  double west = 0.0, north = 0.0;       ///< outer edges, CRS of the scene
  double texel_x = 1.0, texel_y = 1.0;  ///< of level 0, metres
  int levels = 1;                       ///< the coarsest is one tile

  double east() const { return west + width * texel_x; }
  double south() const { return north - height * texel_y; }
  /// Whole texels of a level; what is left at the far edges is told by coarser levels.
  int texels_x(int level) const { return width >> level > 0 ? width >> level : 1; }
  int texels_y(int level) const { return height >> level > 0 ? height >> level : 1; }
  int columns(int level) const { return (texels_x(level) + kTileTexels - 1) / kTileTexels; }
  int rows(int level) const { return (texels_y(level) + kTileTexels - 1) / kTileTexels; }
};

/// The grid of a raster of so many texels, with its levels.
PyramidGrid make_grid(int width, int height, double west, double north, double texel_x,
                      double texel_y);

enum class RasterKind {
  kPhoto,  ///< red, green, blue, coverage: a byte each
  kValues  ///< value, coverage: a 32-bit float each
};
constexpr std::size_t texel_bytes(RasterKind kind) { return kind == RasterKind::kPhoto ? 4 : 8; }

/// kTileSide x kTileSide texels, the northern row first. Coverage is 0 where there is nothing and
/// full (255, 1.0) where all is there; texels without coverage have their neighbours' colour, so
/// that mixing texels brings in no other.
struct RasterTile {
  TileKey key;
  std::vector<std::uint8_t> bytes;
};

/// Thread contract: one thread at a time.
class RasterPyramid {
 public:
  /// Opens rasters of one CRS as one. scene_crs: text as in .hlod files; rasters of another CRS are
  /// reprojected as they are read, those without CRS are taken to be in the scene's. Throws
  /// InputError for what is no such raster: without georeference, photographs that are not 8-bit.
  RasterPyramid(const std::vector<std::filesystem::path>& files, RasterKind kind,
                const std::string& scene_crs);
  ~RasterPyramid();
  RasterPyramid(const RasterPyramid&) = delete;
  RasterPyramid& operator=(const RasterPyramid&) = delete;

  const PyramidGrid& grid() const { return grid_; }
  RasterKind kind() const { return kind_; }
  /// What should be known about its speed; empty where there is nothing to say.
  const std::string& advice() const { return advice_; }

  /// Throws InputError where the file cannot be read there. Stops early, with a tile that is of no
  /// use, where `stop` becomes true.
  RasterTile read(TileKey key, const std::atomic<bool>* stop = nullptr);

 private:
  struct State;
  std::unique_ptr<State> state_;
  PyramidGrid grid_;
  RasterKind kind_;
  std::string advice_;
};

/// Values for a photograph, 3 or 4 bands of bytes or a palette, one band of bytes; nothing where
/// the file is no raster. Reads the header alone.
std::optional<RasterKind> raster_kind(const std::filesystem::path& file);

/// A round number that 98 of 100 values of a tile lie within, on both sides of zero; 1 where it has
/// none.
double value_range(const RasterTile& tile);

}  // namespace cornice::viewer
