// SPDX-License-Identifier: GPL-3.0-or-later
// One raster draped over a scene: what of it to read and to keep on the GPU.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "terrain-viewer/drape/tile_choice.h"
#include "terrain-viewer/drape/tile_loader.h"
#include "terrain-viewer/render/drape_texture.h"

namespace cornice::viewer {

struct DrapeCounts {
  std::size_t tiles_needed = 0, tiles_missing = 0;
  std::uint64_t tiles_read = 0;
  std::uint64_t used_bytes = 0, allocated_bytes = 0;  ///< on the GPU
};

/// All functions are for the thread of the OpenGL context.
class Drape {
 public:
  /// Reads the coarsest tile. Throws as RasterPyramid and DrapeTexture.
  Drape(const std::vector<std::filesystem::path>& files, RasterKind kind,
        const std::string& scene_crs, std::uint64_t gpu_bytes);

  const std::string& name() const { return name_; }
  RasterKind kind() const { return kind_; }
  /// RasterPyramid::advice().
  const std::string& advice() const { return advice_; }
  /// value_range() of the coarsest tile.
  double range() const { return range_; }

  /// Streams for one frame; frame numbers rise. velocity: of the eye, metres a second; what comes
  /// is read ahead.
  void update(const TileView& view, Vec3d velocity, std::uint64_t frame);
  /// The same, waiting for all that the view needs: for pictures. False where tiles failed.
  bool settle(const TileView& view, std::uint64_t frame);
  /// Instead of both in a frame of so many seconds that does not show it: what has been hidden for
  /// kHiddenSeconds gives back what tiles took up on the GPU, and reads them again when shown.
  void hide(double seconds);
  static constexpr double kHiddenSeconds = 30.0;

  DrapeTexture& texture() { return texture_; }
  const DrapeCounts& counts() const { return counts_; }
  std::vector<std::string> take_failures() { return loader_->take_failures(); }

 private:
  Drape(std::unique_ptr<RasterPyramid> pyramid, std::uint64_t gpu_bytes, std::string name);
  std::vector<TileKey> needed(const TileView& view, std::uint64_t frame);
  std::vector<TileKey> missing_of(const std::vector<TileKey>& keys) const;
  /// False where some had no room.
  bool upload(std::size_t most, std::uint64_t frame);
  void count(std::size_t needed, std::size_t missing);

  std::string name_;
  PyramidGrid grid_;
  RasterKind kind_;
  std::string advice_;
  double range_ = 1.0;
  DrapeTexture texture_;
  std::unique_ptr<TileLoader> loader_;
  DrapeCounts counts_;
  double hidden_s_ = 0.0;
};

}  // namespace cornice::viewer
