// SPDX-License-Identifier: GPL-3.0-or-later
#include <cpl_conv.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>

#include "core/base/error.h"
#include "core/geo/gdal_handles.h"
#include "core/geo/product_name.h"
#include "stages/info/examine.h"
#include "stages/info/wording.h"

namespace cornice::info {
namespace {

/// Of whatever a raster may hold; above it lie the values that programs give to empty pixels.
constexpr double kMostOfAnything = 1e30;

std::string metadata(GDALDatasetH dataset, const char* key) {
  const char* value = GDALGetMetadataItem(dataset, key, "IMAGE_STRUCTURE");
  return value != nullptr ? value : "";
}

void read_position(GDALDatasetH dataset, RasterFacts& facts) {
  double t[6] = {};
  if (GDALGetGeoTransform(dataset, t) != CE_None) return;
  facts.has_position = true;
  facts.rotated = t[2] != 0.0 || t[4] != 0.0;
  facts.step_x = t[1];
  facts.step_y = t[5];
  for (const int column : {0, facts.width}) {
    for (const int row : {0, facts.height}) {
      facts.bounds.add(t[0] + column * t[1] + row * t[2], t[3] + column * t[4] + row * t[5]);
    }
  }
  const char* kind = GDALGetMetadataItem(dataset, "AREA_OR_POINT", nullptr);
  facts.pixel_is_point = kind != nullptr && std::string(kind) == "Point";
}

void read_crs(GDALDatasetH dataset, const std::filesystem::path& path,
              const ExamineOptions& options, RasterFacts& facts) {
  if (!options.crs_text.empty()) {
    facts.crs = crs_from_text(options.crs_text);
    return;
  }
  const OGRSpatialReferenceH handle = GDALGetSpatialRef(dataset);
  if (handle != nullptr) {
    char* wkt = nullptr;
    OSRExportToWkt(handle, &wkt);
    facts.crs = crs_from_wkt(wkt != nullptr ? wkt : "").value_or(Crs{});
    CPLFree(wkt);
  }
  const auto product = parse_product_name(path.filename().string());
  if (facts.crs.empty() && product && !product->crs_text.empty()) {
    facts.crs = crs_from_text(product->crs_text);
    facts.crs_from_name = true;
  }
}

/// Range and number of the first band's values, strip by strip.
void read_values(const std::string& name, GDALRasterBandH band, RasterFacts& facts,
                 Progress& progress) {
  int block_width = 0, block_height = 0;
  GDALGetBlockSize(band, &block_width, &block_height);
  const int rows = std::clamp(block_height, 1, 512);
  std::vector<double> strip(static_cast<std::size_t>(facts.width) * static_cast<std::size_t>(rows));
  progress.begin("pixels", static_cast<std::uint64_t>(facts.height));
  for (int row = 0; row < facts.height; row += rows) {
    check_cancelled(progress);
    const int count = std::min(rows, facts.height - row);
    if (GDALRasterIO(band, GF_Read, 0, row, facts.width, count, strip.data(), facts.width, count,
                     GDT_Float64, 0, 0) != CE_None) {
      throw InputError(name,
                       "row " + std::to_string(row) + " cannot be read: " + CPLGetLastErrorMsg());
    }
    const auto end = strip.begin() + static_cast<std::ptrdiff_t>(facts.width) * count;
    for (auto value = strip.begin(); value != end; ++value) {
      if (!std::isfinite(*value)) {
        facts.not_finite += facts.no_data && std::isnan(*facts.no_data) ? 0 : 1;
      } else if (!facts.no_data || *value != *facts.no_data) {
        ++facts.valid;
        facts.min = facts.min ? std::min(*facts.min, *value) : *value;
        facts.max = facts.max ? std::max(*facts.max, *value) : *value;
      }
    }
    progress.advance(static_cast<std::uint64_t>(count));
  }
  progress.end();
}

}  // namespace

RasterFacts examine_raster(const std::filesystem::path& path, const ExamineOptions& options,
                           Progress& progress) {
  static std::once_flag registered;
  std::call_once(registered, [] { GDALAllRegister(); });
  const QuietGdal quiet;
  const std::string name = path.string();
  CPLErrorReset();
  const DatasetPtr dataset(
      GDALOpenEx(name.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
  if (!dataset) {
    throw InputError(name, "is no LAS, LAZ, COPC, PLY or raster file that can be read");
  }
  RasterFacts facts;
  facts.format = GDALGetDriverShortName(GDALGetDatasetDriver(dataset.get()));
  facts.layout = metadata(dataset.get(), "LAYOUT");
  facts.compression = metadata(dataset.get(), "COMPRESSION");
  facts.width = GDALGetRasterXSize(dataset.get());
  facts.height = GDALGetRasterYSize(dataset.get());
  facts.bands = GDALGetRasterCount(dataset.get());
  read_position(dataset.get(), facts);
  read_crs(dataset.get(), path, options, facts);
  if (facts.bands == 0) return facts;
  const GDALRasterBandH band = GDALGetRasterBand(dataset.get(), 1);
  facts.type = GDALGetDataTypeName(GDALGetRasterDataType(band));
  facts.overviews = GDALGetOverviewCount(band);
  int has_no_data = 0;
  const double no_data = GDALGetRasterNoDataValue(band, &has_no_data);
  if (has_no_data != 0) facts.no_data = no_data;
  read_values(name, band, facts, progress);
  return facts;
}

std::vector<Defect> find_defects(const RasterFacts& facts) {
  std::vector<Defect> defects;
  const auto add = [&](const char* id, std::string text) {
    defects.push_back({id, std::move(text)});
  };
  if (facts.bands == 0) add("empty", "the raster has no bands");
  if (!facts.has_position) add("no_position", "nothing says where on the ground the raster lies");
  if (facts.rotated) add("rotated", "the grid is rotated against north");
  if (std::abs(std::abs(facts.step_x) - std::abs(facts.step_y)) > 1e-6 * std::abs(facts.step_x)) {
    add("not_square", "pixels are not square: " + shortest(facts.step_x) + " x " +
                          shortest(std::abs(facts.step_y)));
  }
  const bool in_degrees = !facts.crs.empty() && facts.crs.metres_per_unit == 0.0;
  const double reach = std::max({std::abs(facts.bounds.min_x), std::abs(facts.bounds.max_x),
                                 std::abs(facts.bounds.min_y), std::abs(facts.bounds.max_y)});
  if (facts.crs.empty()) {
    add("crs_missing", "no coordinate reference system; give it with --crs");
  } else if (facts.crs_from_name) {
    add("crs_from_name",
        "the file has no coordinate reference system; it was taken from the file name");
  } else if (in_degrees && facts.has_position && reach > 360.0) {
    add("crs_wrong", "the coordinate reference system (" + facts.crs.name +
                         ") is in degrees, but coordinates reach " + shortest(reach));
  } else if (in_degrees) {
    add("degrees", "pixels are degrees; slopes and distances need a projected system");
  } else if (std::abs(facts.crs.metres_per_unit - 1.0) > 1e-9) {
    add("feet", "pixels are " + unit_name(facts.crs.metres_per_unit) + ", not metres");
  }
  if (facts.no_data && *facts.no_data > 0.0) {
    add("positive_no_data", "the value for missing pixels is " + shortest(*facts.no_data) +
                                ", which could be a height");
  }
  if (facts.valid == 0 && facts.bands > 0) add("no_values", "no pixel has a value");
  for (const std::optional<double>& end : {facts.min, facts.max}) {
    if (!end || std::abs(*end) < kMostOfAnything) continue;
    add("no_data_unmarked", "values reach " + shortest(*end) +
                                ", probably of pixels without one; nothing marks them as such");
  }
  if (facts.not_finite > 0) {
    add("not_finite", counted(facts.not_finite, "pixel") + " are no numbers");
  }
  // Any other offset is a grid of its own; half a pixel is the usual slip between centre and edge.
  const double off = std::abs(std::remainder(facts.bounds.min_x / facts.step_x, 1.0));
  if (facts.has_position && facts.step_x > 0 && !facts.rotated && !in_degrees &&
      std::abs(off - 0.5) < 0.01) {
    add("off_grid", "pixel edges lie half a pixel beside multiples of the pixel side (west edge " +
                        shortest(facts.bounds.min_x, 12) + ")");
  }
  return defects;
}

}  // namespace cornice::info
