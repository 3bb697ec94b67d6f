// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/raster.h"

#include <gdal.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/memory.h"
#include "core/geo/gdal_handles.h"
#include "core/io/gdal_output.h"
#include "core/io/raster_file.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;

/// The raster as GDAL's dataset in memory, for drivers that can only copy.
DatasetPtr dataset_of(const fs::path& path, const Raster& raster, const GdalMessages& messages) {
  DatasetPtr dataset(
      GDALCreate(gdal_driver("MEM"), "", raster.width, raster.height, 1, GDT_Float32, nullptr));
  if (!dataset) throw RunError(path.string(), "cannot be written" + messages.tail());
  std::array<double, 6> transform{raster.west, raster.step, 0.0, raster.north, 0.0, -raster.step};
  GDALSetGeoTransform(dataset.get(), transform.data());
  if (!raster.crs.empty() && GDALSetProjection(dataset.get(), raster.crs.wkt.c_str()) != CE_None) {
    throw RunError(path.string(), "its CRS cannot be written" + messages.tail());
  }
  GDALRasterBandH band = GDALGetRasterBand(dataset.get(), 1);
  GDALSetRasterNoDataValue(band, static_cast<double>(raster.no_data));
  // RasterIO takes no const; it only reads here.
  auto* values = const_cast<float*>(raster.values.data());
  if (GDALRasterIO(band, GF_Write, 0, 0, raster.width, raster.height, values, raster.width,
                   raster.height, GDT_Float32, 0, 0) != CE_None) {
    throw RunError(path.string(), "cannot be written" + messages.tail());
  }
  return dataset;
}

void check_shape(const Raster& raster) {
  const bool sized = raster.width > 0 && raster.height > 0 &&
                     raster.values.size() == static_cast<std::size_t>(raster.width) *
                                                 static_cast<std::size_t>(raster.height);
  if (!sized) throw std::invalid_argument("a raster needs width * height values, at least one");
  if (!(raster.step > 0.0) || !std::isfinite(raster.step)) {
    throw std::invalid_argument("a raster needs a pixel size above 0");
  }
}

Raster head_of(const RasterHead& head) {
  Raster raster;
  raster.width = head.width;
  raster.height = head.height;
  raster.west = head.west;
  raster.north = head.north;
  raster.step = head.step;
  raster.crs = head.crs;
  if (head.no_data && std::isfinite(*head.no_data)) {
    raster.no_data = static_cast<float>(*head.no_data);
  }
  return raster;
}

}  // namespace

void write_cog(const fs::path& path, const Raster& raster) {
  check_shape(raster);
  const GdalMessages messages;
  const DatasetPtr memory = dataset_of(path, raster, messages);
  AtomicFile target(path);
  copy_to_cog(memory.get(), target.path(), path, messages);
  target.commit();
}

Raster read_raster_head(const fs::path& path) { return head_of(RasterFile(path).head()); }

Raster read_raster(const fs::path& path) {
  RasterFile file(path);
  Raster raster = head_of(file.head());
  const auto pixels =
      static_cast<std::uint64_t>(raster.width) * static_cast<std::uint64_t>(raster.height);
  if (pixels > available_memory_bytes() / sizeof(float)) {
    throw InputError(path.string(), "has " + std::to_string(pixels) +
                                        " pixels, more than fit into memory; cut it into tiles");
  }
  raster.values.resize(static_cast<std::size_t>(pixels));
  file.read(0, 0, raster.width, raster.height, raster.values.data(),
            static_cast<std::size_t>(raster.width));
  for (float& value : raster.values) {
    if (std::isnan(value)) value = raster.no_data;
  }
  return raster;
}

}  // namespace cornice
