// SPDX-License-Identifier: GPL-3.0-or-later
// For tests that link GDAL.
#pragma once

#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_srs_api.h>

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace cornice::test {

/// A small GeoTIFF as other programs write them.
class ForeignTiff {
 public:
  ForeignTiff(const std::filesystem::path& path, int width, int height, GDALDataType type) {
    GDALAllRegister();
    dataset_ =
        GDALCreate(GDALGetDriverByName("GTiff"), path.c_str(), width, height, 1, type, nullptr);
    transform({0.0, 1.0, 0.0, 0.0, 0.0, -1.0});
  }
  ~ForeignTiff() { GDALClose(dataset_); }
  ForeignTiff(const ForeignTiff&) = delete;
  ForeignTiff& operator=(const ForeignTiff&) = delete;
  void transform(std::array<double, 6> t) { GDALSetGeoTransform(dataset_, t.data()); }
  /// text: "EPSG:2056".
  void crs(const std::string& text) {
    OGRSpatialReferenceH srs = OSRNewSpatialReference(nullptr);
    ASSERT_EQ(OSRSetFromUserInput(srs, text.c_str()), OGRERR_NONE);
    GDALSetSpatialRef(dataset_, srs);
    OSRDestroySpatialReference(srs);
  }
  GDALRasterBandH band() { return GDALGetRasterBand(dataset_, 1); }
  GDALDatasetH dataset() { return dataset_; }
  void fill(std::vector<double> values) {
    const int width = GDALGetRasterXSize(dataset_);
    const int height = GDALGetRasterYSize(dataset_);
    ASSERT_EQ(GDALRasterIO(band(), GF_Write, 0, 0, width, height, values.data(), width, height,
                           GDT_Float64, 0, 0),
              CE_None);
  }

 private:
  GDALDatasetH dataset_ = nullptr;
};

}  // namespace cornice::test
