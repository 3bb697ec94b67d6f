// SPDX-License-Identifier: GPL-3.0-or-later
// A raster of heights that stays on disk: what its header says, and any window of it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "core/geo/crs.h"

namespace cornice {

/// What the header of a raster says.
struct RasterHead {
  int width = 0;
  int height = 0;
  double west = 0.0;              ///< of the first column's west edge, projected
  double north = 0.0;             ///< of the northernmost row's north edge
  double step = 1.0;              ///< side of a pixel, in units of the CRS
  Crs crs;                        ///< the file's own, else that of the product's file name
  std::string crs_of;             ///< "file" or "file name"; empty where there is none
  std::string height_unit;        ///< as the band names it; often empty
  std::optional<double> no_data;  ///< as stored, before scale and offset
  std::uint64_t block_bytes = 0;  ///< what reading one pixel needs at least
};

/// Reads GeoTIFF (cloud-optimised ones too) and ASCII grids. Thread contract: one thread at a time.
class RasterFile {
 public:
  /// Throws InputError for files that are neither, lack a georeference, are rotated or sheared,
  /// have unequal pixel sides, or say a size that no raster has.
  explicit RasterFile(std::filesystem::path path);
  ~RasterFile();
  RasterFile(RasterFile&&) noexcept;
  RasterFile& operator=(RasterFile&&) noexcept;

  const std::filesystem::path& path() const { return path_; }
  const RasterHead& head() const { return head_; }
  /// In place of what the file says.
  void set_no_data(double stored) { head_.no_data = stored; }

  /// Heights of the pixels [col, col + width) x [row, row + height), rows from the north whatever
  /// their order in the file, scale and offset applied; row i at `to + i * stride`. What the file
  /// marks as no data and what is not finite becomes not-a-number. The window must lie inside.
  /// Throws InputError, naming the row, where the file ends early or is damaged.
  void read(int col, int row, int width, int height, float* to, std::size_t stride);

 private:
  struct Handle;
  void read_floats(int row, int col, int width, int height, float* to, std::size_t stride);
  void read_numbers(int row, int col, int width, int height, float* to, std::size_t stride);

  std::filesystem::path path_;
  RasterHead head_;
  std::unique_ptr<Handle> handle_;
};

/// Throws InputError where `head` cannot be taken for metres: degrees, feet in plan or in height,
/// or a CRS in degrees over coordinates that are none. An empty CRS passes.
void require_metres(const std::filesystem::path& path, const RasterHead& head);

/// Throws InputError where no ground has one of `heights`, read from `path`: most likely it stands
/// for no data and the file does not say so. Not-a-number and `no_data` pass.
void require_ground(const std::filesystem::path& path, std::span<const float> heights,
                    float no_data = std::numeric_limits<float>::quiet_NaN());

/// Bytes that GDAL keeps of blocks read, over all files of the process.
void limit_raster_cache(std::uint64_t bytes);

}  // namespace cornice
