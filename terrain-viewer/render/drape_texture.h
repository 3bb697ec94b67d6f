// SPDX-License-Identifier: GPL-3.0-or-later
// Tiles of a draped raster on the GPU, and the table by which the shader finds them: for each level
// kPages x kPages entries around the eye, an entry for tile (column, row) at (column, row) modulo
// kPages. What lies further away than that table reaches is found in coarser levels.
#pragma once

#include <array>
#include <cstdint>
#include <list>
#include <unordered_map>
#include <vector>

#include "core/base/vec.h"
#include "terrain-viewer/drape/raster_pyramid.h"
#include "terrain-viewer/render/gl.h"

namespace cornice::viewer {

/// As Drape in shaders/drape.glsl (std140).
struct DrapeBlock {
  std::array<std::int32_t, 4> what{};  ///< x: 0 none, 1 photograph, 2 values; y: levels
  std::array<float, 4> texel{};        ///< x, y: of level 0, metres; z: opacity; w: relief
  std::array<float, 4> bounds{};       ///< west, south, east, north from the eye
  std::array<float, 4> ramp{};         ///< x, y: its ends
  std::array<std::array<std::int32_t, 4>, PyramidGrid::kMostLevels> tile{};  ///< x, y: the eye's
  std::array<std::array<float, 4>, PyramidGrid::kMostLevels> within{};  ///< x, y: eye in it, 0..1
};

class DrapeTexture {
 public:
  static constexpr int kPages = 64;

  /// Takes up at most `bytes` on the GPU: a sixth at first, then a third, then two thirds, the
  /// tiles being copied from the array before, which takes up half as much meanwhile. Throws
  /// RunError where that is too little for the tiles of one view or the GPU has no room for the
  /// first array.
  DrapeTexture(const PyramidGrid& grid, RasterKind kind, std::uint64_t bytes);

  /// Tiles there may be; fewer once the GPU has had no room for more.
  std::size_t capacity() const { return capacity_; }
  bool holds(TileKey key) const { return held_.contains(key); }
  /// Counts as the use of a tile, if it is there, in frame `frame`.
  void use(TileKey key, std::uint64_t frame);
  /// Puts a tile there; the tile that has been unused longest makes room. False where all were used
  /// in this frame.
  bool put(const RasterTile& tile, std::uint64_t frame);
  std::uint64_t used_bytes() const { return held_.size() * tile_bytes_; }
  std::uint64_t allocated_bytes() const { return places_ * tile_bytes_; }
  /// Forgets all tiles and gives back all but the room that there was at first.
  void clear();

  /// Binds tiles and table to texture units 1 and 2; returns what the shader needs to know, but for
  /// opacity, relief and ramp. For the thread of the context, as all here.
  DrapeBlock bind(Vec3d eye);

 private:
  struct Held {
    int place = 0;
    std::uint64_t frame = 0;
    std::list<TileKey>::iterator use;
  };
  GlTexture make_tiles(std::size_t places) const;
  void grow();
  void write_pages(const DrapeBlock& block);

  PyramidGrid grid_;
  RasterKind kind_;
  std::uint64_t tile_bytes_;
  std::size_t capacity_ = 0, first_places_ = 0;
  std::size_t places_ = 0;  ///< tiles that the array has room for
  GlTexture tiles_, pages_;
  std::unordered_map<TileKey, Held, TileKeyHash> held_;
  std::list<TileKey> used_;  ///< the latest first
  std::vector<std::uint16_t> table_;
  std::array<std::array<std::int32_t, 4>, PyramidGrid::kMostLevels> written_around_{};
  bool has_changed_ = true;
};

}  // namespace cornice::viewer
