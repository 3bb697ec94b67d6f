// SPDX-License-Identifier: GPL-3.0-or-later
// Cloud-optimised GeoTIFFs of several bands, block by block, larger than memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/geo/crs.h"

namespace cornice {

/// A north-up grid of square pixels.
struct RasterGrid {
  int width = 0;
  int height = 0;
  double west = 0.0;   ///< of the first column's west edge
  double north = 0.0;  ///< of the first row's north edge
  double step = 1.0;   ///< metres
};

/// Collects blocks of 32-bit floats in a temporary file beside the target (DEFLATE; blocks never
/// written are no data) and makes the COG of it at the end: tiles of 512 pixels, predictor 3,
/// averaged overviews. Thread contract: one thread at a time.
class CogWriter {
 public:
  static constexpr int kBlockSide = 512;

  /// Throws RunError where the folder cannot be written.
  CogWriter(std::filesystem::path path, const RasterGrid& grid, const Crs& crs,
            const std::vector<std::string>& bands, float no_data);
  ~CogWriter();
  CogWriter(const CogWriter&) = delete;
  CogWriter& operator=(const CogWriter&) = delete;

  /// Values of band `band` (from 0) in a window, row by row. Windows whose sides are multiples of
  /// kBlockSide are written fastest. Throws RunError (disk full).
  void write(int band, int col, int row, int width, int height, const float* values);
  /// Makes the COG; the target appears whole. Throws RunError (disk full).
  void commit();

 private:
  struct Handle;
  AtomicFile target_;
  AtomicFile blocks_;  ///< never committed: it goes with this object
  std::unique_ptr<Handle> handle_;
};

}  // namespace cornice
