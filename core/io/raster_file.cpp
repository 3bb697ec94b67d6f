// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/raster_file.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <mutex>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/input_file.h"
#include "core/geo/gdal_handles.h"
#include "core/geo/known_crs.h"
#include "core/geo/product_name.h"
#include "core/io/gdal_messages.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;

// Rows that are converted at once: as high as the tiles of a cloud-optimised GeoTIFF.
constexpr int kStripRows = 512;
// Parts of a pixel by which the far end of a raster may be off before its grid is called unequal.
constexpr double kGridTolerance = 0.01;
// A pixel of a centimetre over ten thousand kilometres; more is a damaged header.
constexpr int kMostPixelsAlong = 1000000000;
constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 50;
// Metres above and below sea level.
constexpr float kHighestGroundM = 9000.0f;
constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.9g", value);
  return text.data();
}

void register_drivers() {
  static std::once_flag once;
  std::call_once(once, [] { GDALAllRegister(); });
}

DatasetPtr open_raster(const fs::path& path, const GdalMessages& messages) {
  register_drivers();
  check_input_file(path);
  // The formats DEM products come in; others can refer to further files or to the network.
  const std::array<const char*, 4> drivers{"GTiff", "COG", "AAIGrid", nullptr};
  // Files before GeoTIFF 1.1 may say a vertical CRS too; GDAL drops it unless told.
  const CPLConfigOptionSetter with_vertical("GTIFF_REPORT_COMPD_CS", "YES", false);
  DatasetPtr dataset(GDALOpenEx(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers.data(),
                                nullptr, nullptr));
  if (!dataset) {
    throw InputError(path.string(), "is no GeoTIFF or ASCII grid" + messages.tail());
  }
  if (GDALGetRasterCount(dataset.get()) < 1) throw InputError(path.string(), "has no band");
  return dataset;
}

void read_size(const fs::path& path, GDALDatasetH dataset, RasterHead& head) {
  head.width = GDALGetRasterXSize(dataset);
  head.height = GDALGetRasterYSize(dataset);
  const auto pixels =
      static_cast<std::uint64_t>(head.width) * static_cast<std::uint64_t>(head.height);
  if (head.width < 1 || head.height < 1 || head.width > kMostPixelsAlong ||
      head.height > kMostPixelsAlong || pixels > kMostPixels) {
    throw InputError(path.string(), "says it has " + std::to_string(head.width) + " x " +
                                        std::to_string(head.height) +
                                        " pixels; its header is damaged, get the file again");
  }
}

/// Fills the grid's place and step; true where the file's rows run from south to north.
bool read_grid(const fs::path& path, GDALDatasetH dataset, RasterHead& head) {
  std::array<double, 6> t{};
  if (GDALGetGeoTransform(dataset, t.data()) != CE_None) {
    throw InputError(path.string(),
                     "does not say where it lies; give it a georeference, with gdal_translate "
                     "-a_ullr");
  }
  for (const double value : t) {
    if (!std::isfinite(value)) throw InputError(path.string(), "its georeference is not finite");
  }
  const double pixels = std::max(head.width, head.height);
  if (std::abs(t[2]) * pixels > kGridTolerance * std::abs(t[1]) ||
      std::abs(t[4]) * pixels > kGridTolerance * std::abs(t[5])) {
    throw InputError(path.string(),
                     "its grid is rotated or sheared; make it north-up first, with "
                     "gdalwarp (a column is " +
                         number(t[1]) + ", " + number(t[4]) + " and a row " + number(t[2]) + ", " +
                         number(t[5]) + " in east and north)");
  }
  if (!(t[1] > 0.0) || t[5] == 0.0) {
    throw InputError(path.string(),
                     "its columns do not run from west to east; turn it, with gdalwarp");
  }
  if (std::abs(t[1] - std::abs(t[5])) * pixels > kGridTolerance * t[1]) {
    throw InputError(path.string(), "its pixels are " + std::to_string(t[1]) + " by " +
                                        std::to_string(std::abs(t[5])) +
                                        "; make them square first, with gdalwarp -tr");
  }
  const bool south_up = t[5] > 0.0;
  head.step = t[1];
  head.west = t[0];
  head.north = south_up ? t[3] + t[5] * head.height : t[3];
  return south_up;
}

/// The file's own CRS; where it lacks heights or everything, the product's file name says the rest.
void read_crs(const fs::path& path, GDALDatasetH dataset, RasterHead& head) {
  const char* wkt = GDALGetProjectionRef(dataset);
  if (wkt != nullptr && *wkt != '\0') {
    if (std::optional<Crs> crs = known_crs_from_wkt(wkt)) head.crs = *crs;
  }
  head.crs_of = head.crs.empty() ? "" : "file";
  const auto product = parse_product_name(path.filename().string());
  if (!product || product->crs_text.empty() || head.crs.has_vertical) return;
  const Crs named = known_crs_from_text(product->crs_text);
  if (head.crs.empty()) head.crs_of = "file name";
  if (head.crs.empty() || same_crs(named, head.crs)) head.crs = named;
}

}  // namespace

struct RasterFile::Handle {
  DatasetPtr dataset;
  GDALRasterBandH band = nullptr;
  bool south_up = false;
  bool is_float = false;  ///< 32-bit floats that are the heights themselves
  double scale = 1.0;
  double offset = 0.0;
};

RasterFile::RasterFile(fs::path path) : path_(std::move(path)), handle_(new Handle) {
  const GdalMessages messages;
  Handle& h = *handle_;
  h.dataset = open_raster(path_, messages);
  read_size(path_, h.dataset.get(), head_);
  h.south_up = read_grid(path_, h.dataset.get(), head_);
  read_crs(path_, h.dataset.get(), head_);
  h.band = GDALGetRasterBand(h.dataset.get(), 1);
  const GDALDataType type = GDALGetRasterDataType(h.band);
  if (GDALDataTypeIsComplex(type) != 0) throw InputError(path_.string(), "holds complex numbers");
  int known = 0;
  const double no_data = GDALGetRasterNoDataValue(h.band, &known);
  if (known != 0) head_.no_data = no_data;
  const double scale = GDALGetRasterScale(h.band, &known);
  if (known != 0 && scale != 0.0) h.scale = scale;
  const double offset = GDALGetRasterOffset(h.band, &known);
  if (known != 0) h.offset = offset;
  h.is_float = type == GDT_Float32 && h.scale == 1.0 && h.offset == 0.0;
  const char* unit = GDALGetRasterUnitType(h.band);
  head_.height_unit = unit == nullptr ? "" : unit;
  int width = 0, height = 0;
  GDALGetBlockSize(h.band, &width, &height);
  head_.block_bytes = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) *
                      static_cast<std::uint64_t>(GDALGetDataTypeSizeBytes(type));
}

RasterFile::~RasterFile() = default;
RasterFile::RasterFile(RasterFile&&) noexcept = default;
RasterFile& RasterFile::operator=(RasterFile&&) noexcept = default;

void RasterFile::read(int col, int row, int width, int height, float* to, std::size_t stride) {
  for (int first = 0; first < height; first += kStripRows) {
    const int rows = std::min(kStripRows, height - first);
    float* strip = to + static_cast<std::size_t>(first) * stride;
    // The file's rows, from its own top.
    const int file_row = handle_->south_up ? head_.height - (row + first + rows) : row + first;
    if (handle_->is_float) {
      read_floats(file_row, col, width, rows, strip, stride);
    } else {
      read_numbers(file_row, col, width, rows, strip, stride);
    }
    if (!handle_->south_up) continue;
    for (int i = 0; i < rows / 2; ++i) {
      float* upper = strip + static_cast<std::size_t>(i) * stride;
      std::swap_ranges(upper, upper + width,
                       strip + static_cast<std::size_t>(rows - 1 - i) * stride);
    }
  }
}

void RasterFile::read_floats(int row, int col, int width, int height, float* to,
                             std::size_t stride) {
  const GdalMessages messages;
  if (GDALRasterIOEx(handle_->band, GF_Read, col, row, width, height, to, width, height,
                     GDT_Float32, sizeof(float), static_cast<GSpacing>(stride * sizeof(float)),
                     nullptr) != CE_None) {
    throw InputError(path_.string(), "cannot be read from row " + std::to_string(row) + " on" +
                                         messages.tail() + "; get the file again");
  }
  // A no-data value may be written with more digits than the floats that it marks.
  const float mark = head_.no_data ? static_cast<float>(*head_.no_data) : kNothing;
  for (int i = 0; i < height; ++i) {
    float* line = to + static_cast<std::size_t>(i) * stride;
    for (int j = 0; j < width; ++j) {
      const float value = line[j];
      line[j] = value == mark || !std::isfinite(value) ? kNothing : value;
    }
  }
}

void RasterFile::read_numbers(int row, int col, int width, int height, float* to,
                              std::size_t stride) {
  const GdalMessages messages;
  std::vector<double> strip(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  if (GDALRasterIO(handle_->band, GF_Read, col, row, width, height, strip.data(), width, height,
                   GDT_Float64, 0, 0) != CE_None) {
    throw InputError(path_.string(), "cannot be read from row " + std::to_string(row) + " on" +
                                         messages.tail() + "; get the file again");
  }
  const bool is_float = GDALGetRasterDataType(handle_->band) == GDT_Float32;
  const double stored_mark = head_.no_data.value_or(std::numeric_limits<double>::quiet_NaN());
  const double mark = is_float ? static_cast<double>(static_cast<float>(stored_mark)) : stored_mark;
  for (int i = 0; i < height; ++i) {
    const double* from =
        strip.data() + static_cast<std::size_t>(i) * static_cast<std::size_t>(width);
    float* line = to + static_cast<std::size_t>(i) * stride;
    for (int j = 0; j < width; ++j) {
      const auto value = static_cast<float>(from[j] * handle_->scale + handle_->offset);
      line[j] = from[j] == mark || !std::isfinite(value) ? kNothing : value;
    }
  }
}

void require_ground(const fs::path& path, std::span<const float> heights, float no_data) {
  const auto bad = std::find_if(heights.begin(), heights.end(), [no_data](float z) {
    return std::abs(z) > kHighestGroundM && z != no_data;
  });
  if (bad == heights.end()) return;
  const std::string value = number(static_cast<double>(*bad));
  throw InputError(path.string(), "has a height of " + value +
                                      " m, which no ground has; if it stands for no data, let the "
                                      "file say so, with gdal_edit.py -a_nodata " +
                                      value);
}

void require_metres(const fs::path& path, const RasterHead& head) {
  const Crs& crs = head.crs;
  if (crs.empty()) return;
  if (!crs.projected) {
    const double east = head.west + head.step * head.width;
    const double south = head.north - head.step * head.height;
    const bool are_degrees =
        head.west >= -180.5 && east <= 360.5 && head.north <= 90.5 && south >= -90.5;
    if (are_degrees) {
      throw InputError(path.string(), "its pixels are degrees (" + crs.name +
                                          "), not metres; project it first, with gdalwarp -t_srs");
    }
    throw InputError(path.string(), "says " + crs.text() + ", degrees, but its corner " +
                                        number(head.west) + ", " + number(head.north) +
                                        " is none: its CRS is wrong; tell the true one with --crs");
  }
  constexpr double kTolerance = 1e-6;
  if (std::abs(crs.metres_per_unit - 1.0) > kTolerance) {
    throw InputError(path.string(), "its pixels are feet or another unit of " +
                                        number(crs.metres_per_unit) + " m (" + crs.name +
                                        "), not metres; project it first, with gdalwarp -t_srs");
  }
  double unit = crs.vertical_metres_per_unit;
  std::string name = head.height_unit;
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (name.find("foot") != std::string::npos || name.find("feet") != std::string::npos ||
      name == "ft" || name.starts_with("ft ") || name.ends_with("-ft") || name == "ftus") {
    unit = 0.3048;
  }
  if (std::abs(unit - 1.0) > kTolerance) {
    throw InputError(path.string(),
                     "its heights are feet or another unit of " + number(unit) +
                         " m, not metres; convert them first, with gdal_calc.py --calc 'A*" +
                         number(unit) + "', and tell the new datum with --vertical-crs");
  }
}

void limit_raster_cache(std::uint64_t bytes) { GDALSetCacheMax64(static_cast<GIntBig>(bytes)); }

}  // namespace cornice
