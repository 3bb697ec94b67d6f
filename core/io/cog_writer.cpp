// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/cog_writer.h"

#include <gdal.h>

#include <array>
#include <utility>

#include "core/base/error.h"
#include "core/geo/gdal_handles.h"
#include "core/io/gdal_output.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const GdalMessages& messages) {
  throw RunError(path.string(), "cannot be written" + messages.tail());
}

}  // namespace

struct CogWriter::Handle {
  DatasetPtr dataset;
};

CogWriter::CogWriter(fs::path path, const RasterGrid& grid, const Crs& crs,
                     const std::vector<std::string>& bands, float no_data)
    : target_(path), blocks_(fs::path(path.string() + ".blocks.tif")), handle_(new Handle) {
  const GdalMessages messages;
  const StringList options =
      string_list({"TILED=YES", "BLOCKXSIZE=512", "BLOCKYSIZE=512", "COMPRESS=DEFLATE", "ZLEVEL=1",
                   "PREDICTOR=3", "INTERLEAVE=BAND", "BIGTIFF=YES", "SPARSE_OK=TRUE"});
  DatasetPtr& dataset = handle_->dataset;
  dataset.reset(GDALCreate(gdal_driver("GTiff"), blocks_.path().c_str(), grid.width, grid.height,
                           static_cast<int>(bands.size()), GDT_Float32, options.get()));
  if (!dataset) fail(path, messages);
  std::array<double, 6> transform{grid.west, grid.step, 0.0, grid.north, 0.0, -grid.step};
  GDALSetGeoTransform(dataset.get(), transform.data());
  if (!crs.empty() && GDALSetProjection(dataset.get(), crs.wkt.c_str()) != CE_None) {
    throw RunError(path.string(), "its CRS cannot be written" + messages.tail());
  }
  for (std::size_t i = 0; i < bands.size(); ++i) {
    GDALRasterBandH band = GDALGetRasterBand(dataset.get(), static_cast<int>(i) + 1);
    GDALSetRasterNoDataValue(band, static_cast<double>(no_data));
    GDALSetDescription(band, bands[i].c_str());
  }
}

CogWriter::~CogWriter() = default;

void CogWriter::write(int band, int col, int row, int width, int height, const float* values) {
  const GdalMessages messages;
  // RasterIO takes no const; it only reads here.
  if (GDALRasterIO(GDALGetRasterBand(handle_->dataset.get(), band + 1), GF_Write, col, row, width,
                   height, const_cast<float*>(values), width, height, GDT_Float32, 0,
                   0) != CE_None) {
    fail(target_.target(), messages);
  }
}

void CogWriter::commit() {
  const GdalMessages messages;
  GDALFlushCache(handle_->dataset.get());
  if (!messages.tail().empty()) fail(target_.target(), messages);
  copy_to_cog(handle_->dataset.get(), target_.path(), target_.target(), messages);
  target_.commit();
}

}  // namespace cornice
