// SPDX-License-Identifier: GPL-3.0-or-later
// Reads tiles of a raster on a thread of its own.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "terrain-viewer/drape/raster_pyramid.h"

namespace cornice::viewer {

/// All functions are for one thread, the one that draws; none waits for the disk but `wait`.
class TileLoader {
 public:
  explicit TileLoader(std::unique_ptr<RasterPyramid> pyramid);
  ~TileLoader();
  TileLoader(const TileLoader&) = delete;
  TileLoader& operator=(const TileLoader&) = delete;

  /// Tiles to be read, the most urgent first, in place of what was wanted before. What has failed
  /// and what is ready to be taken is left out.
  void want(const std::vector<TileKey>& keys);
  /// At most so many tiles that have been read, the first read first. A thread that has kMostReady
  /// tiles ready waits until some are taken.
  std::vector<RasterTile> take(std::size_t most);
  /// Waits until nothing wanted is left to be read, or kMostReady tiles are ready.
  void wait();
  bool has_failed(TileKey key) const;
  /// One message for each tile that could not be read since the last call.
  std::vector<std::string> take_failures();
  std::uint64_t tiles_read() const;

  static constexpr std::size_t kMostReady = 32;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cornice::viewer
