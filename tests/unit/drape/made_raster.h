// SPDX-License-Identifier: GPL-3.0-or-later
// GeoTIFFs whose pixels say where they are.
#pragma once

#include <cpl_error.h>
#include <gdal.h>
#include <ogr_srs_api.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace cornice::test {

struct MadeRaster {
  int width = 0, height = 0, bands = 1;
  GDALDataType type = GDT_Byte;
  std::vector<double> transform{2600000.0, 1.0, 0.0, 1200000.0, 0.0, -1.0};  ///< empty: none
  std::string crs = "EPSG:2056";                                             ///< empty: none
  bool has_no_data = false;
  double no_data = 0.0;
};

/// value: of band b (from 0), column and row.
inline void make_tiff(const std::filesystem::path& path, const MadeRaster& made,
                      const std::function<double(int b, int column, int row)>& value) {
  GDALAllRegister();
  GDALDatasetH dataset = GDALCreate(GDALGetDriverByName("GTiff"), path.c_str(), made.width,
                                    made.height, made.bands, made.type, nullptr);
  if (!made.transform.empty())
    GDALSetGeoTransform(dataset, const_cast<double*>(made.transform.data()));
  if (!made.crs.empty()) {
    OGRSpatialReferenceH srs = OSRNewSpatialReference(nullptr);
    OSRSetFromUserInput(srs, made.crs.c_str());
    GDALSetSpatialRef(dataset, srs);
    OSRDestroySpatialReference(srs);
  }
  std::vector<double> line(static_cast<std::size_t>(made.width));
  for (int b = 0; b < made.bands; ++b) {
    GDALRasterBandH band = GDALGetRasterBand(dataset, b + 1);
    if (made.has_no_data) GDALSetRasterNoDataValue(band, made.no_data);
    for (int row = 0; row < made.height; ++row) {
      for (int column = 0; column < made.width; ++column)
        line[static_cast<std::size_t>(column)] = value(b, column, row);
      const CPLErr done = GDALRasterIO(band, GF_Write, 0, row, made.width, 1, line.data(),
                                       made.width, 1, GDT_Float64, 0, 0);
      if (done != CE_None) throw std::runtime_error("cannot write " + path.string());
    }
  }
  GDALClose(dataset);
}

}  // namespace cornice::test
