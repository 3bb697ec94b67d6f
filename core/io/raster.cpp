// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/raster.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <gdal.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/memory.h"
#include "core/geo/product_name.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;

// Rows read at once: as high as the tiles of a cloud-optimised GeoTIFF.
constexpr int kStripRows = 512;
// Parts of a pixel by which the far end of a raster may be off before its grid is called unequal.
constexpr double kGridTolerance = 0.01;

/// Keeps GDAL's messages off stderr on this thread and remembers the last.
class GdalMessages {
 public:
  GdalMessages() {
    CPLErrorReset();
    CPLPushErrorHandlerEx(&GdalMessages::take, this);
  }
  ~GdalMessages() { CPLPopErrorHandler(); }
  GdalMessages(const GdalMessages&) = delete;
  GdalMessages& operator=(const GdalMessages&) = delete;

  /// ": what GDAL says", or empty.
  std::string tail() const { return text_.empty() ? text_ : ": " + text_; }

 private:
  static void CPL_STDCALL take(CPLErr level, CPLErrorNum, const char* message) {
    auto* self = static_cast<GdalMessages*>(CPLGetErrorHandlerUserData());
    if (level >= CE_Failure) self->text_ = message;
  }
  std::string text_;
};

struct DatasetCloser {
  void operator()(void* dataset) const { GDALClose(dataset); }
};
using DatasetPtr = std::unique_ptr<void, DatasetCloser>;

struct StringListDeleter {
  void operator()(char** list) const { CSLDestroy(list); }
};
using StringList = std::unique_ptr<char*, StringListDeleter>;

StringList string_list(const std::vector<std::string>& lines) {
  char** list = nullptr;
  for (const std::string& line : lines) list = CSLAddString(list, line.c_str());
  return StringList(list);
}

void register_drivers() {
  static std::once_flag once;
  std::call_once(once, [] { GDALAllRegister(); });
}

GDALDriverH driver(const char* name) {
  register_drivers();
  GDALDriverH found = GDALGetDriverByName(name);
  if (found == nullptr) throw RunError(name, "this GDAL has no such driver; install libgdal-dev");
  return found;
}

/// The raster as GDAL's dataset in memory, for drivers that can only copy.
DatasetPtr dataset_of(const fs::path& path, const Raster& raster, const GdalMessages& messages) {
  DatasetPtr dataset(
      GDALCreate(driver("MEM"), "", raster.width, raster.height, 1, GDT_Float32, nullptr));
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

DatasetPtr open_raster(const fs::path& path, const GdalMessages& messages) {
  register_drivers();
  std::error_code error;
  if (!fs::exists(path, error)) throw InputError(path.string(), "No such file or directory");
  if (fs::is_directory(path, error)) throw InputError(path.string(), "is a folder, not a file");
  // The formats DEM products come in; others can refer to further files or to the network.
  const std::array<const char*, 4> drivers{"GTiff", "COG", "AAIGrid", nullptr};
  DatasetPtr dataset(GDALOpenEx(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers.data(),
                                nullptr, nullptr));
  if (!dataset) {
    throw InputError(path.string(), "is no GeoTIFF or ASCII grid" + messages.tail());
  }
  if (GDALGetRasterCount(dataset.get()) < 1) throw InputError(path.string(), "has no band");
  return dataset;
}

/// Fills the grid's place and step; true where the file's rows run from south to north.
bool read_grid(const fs::path& path, void* dataset, Raster& raster) {
  std::array<double, 6> t{};
  if (GDALGetGeoTransform(dataset, t.data()) != CE_None) {
    throw InputError(path.string(), "does not say where it lies; give it a georeference");
  }
  for (const double value : t) {
    if (!std::isfinite(value)) throw InputError(path.string(), "its georeference is not finite");
  }
  const double pixels = std::max(raster.width, raster.height);
  if (std::abs(t[2]) * pixels > kGridTolerance * std::abs(t[1]) ||
      std::abs(t[4]) * pixels > kGridTolerance * std::abs(t[5])) {
    throw InputError(path.string(),
                     "its grid is rotated or sheared; make it north-up first, with gdalwarp");
  }
  if (!(t[1] > 0.0) || t[5] == 0.0) {
    throw InputError(path.string(), "its columns do not run from west to east");
  }
  if (std::abs(t[1] - std::abs(t[5])) * pixels > kGridTolerance * t[1]) {
    throw InputError(path.string(), "its pixels are " + std::to_string(t[1]) + " by " +
                                        std::to_string(std::abs(t[5])) +
                                        "; make them square first, with gdalwarp -tr");
  }
  const bool south_up = t[5] > 0.0;
  raster.step = t[1];
  raster.west = t[0];
  raster.north = south_up ? t[3] + t[5] * raster.height : t[3];
  return south_up;
}

Crs read_crs(const fs::path& path, void* dataset) {
  const char* wkt = GDALGetProjectionRef(dataset);
  if (wkt != nullptr && *wkt != '\0') {
    if (std::optional<Crs> crs = crs_from_wkt(wkt)) return *crs;
  }
  const auto product = parse_product_name(path.filename().string());
  return product && !product->crs_text.empty() ? crs_from_text(product->crs_text) : Crs{};
}

/// How stored numbers become heights.
struct BandMeaning {
  std::optional<double> no_data;
  double scale = 1.0;
  double offset = 0.0;
};

BandMeaning meaning_of(GDALRasterBandH band) {
  BandMeaning meaning;
  int known = 0;
  const double no_data = GDALGetRasterNoDataValue(band, &known);
  if (known != 0) meaning.no_data = no_data;
  const double scale = GDALGetRasterScale(band, &known);
  if (known != 0 && scale != 0.0) meaning.scale = scale;
  const double offset = GDALGetRasterOffset(band, &known);
  if (known != 0) meaning.offset = offset;
  return meaning;
}

void read_values(const fs::path& path, void* dataset, bool south_up, Raster& raster,
                 const GdalMessages& messages) {
  GDALRasterBandH band = GDALGetRasterBand(dataset, 1);
  const BandMeaning meaning = meaning_of(band);
  const bool is_float = GDALGetRasterDataType(band) == GDT_Float32;
  // A no-data value may be written with more digits than the floats that it marks.
  const auto rounded = [&](double v) {
    return is_float ? static_cast<double>(static_cast<float>(v)) : v;
  };
  if (meaning.no_data && std::isfinite(*meaning.no_data)) {
    raster.no_data = static_cast<float>(*meaning.no_data);
  }
  const auto width = static_cast<std::size_t>(raster.width);
  std::vector<double> strip(width * static_cast<std::size_t>(std::min(kStripRows, raster.height)));
  for (int first = 0; first < raster.height; first += kStripRows) {
    const int rows = std::min(kStripRows, raster.height - first);
    if (GDALRasterIO(band, GF_Read, 0, first, raster.width, rows, strip.data(), raster.width, rows,
                     GDT_Float64, 0, 0) != CE_None) {
      throw InputError(path.string(), "cannot be read from row " + std::to_string(first) + " on" +
                                          messages.tail());
    }
    for (int row = 0; row < rows; ++row) {
      const int to = south_up ? raster.height - 1 - (first + row) : first + row;
      for (std::size_t col = 0; col < width; ++col) {
        const double stored = strip[static_cast<std::size_t>(row) * width + col];
        const bool absent =
            !std::isfinite(stored) || (meaning.no_data && stored == rounded(*meaning.no_data));
        raster.values[static_cast<std::size_t>(to) * width + col] =
            absent ? raster.no_data : static_cast<float>(stored * meaning.scale + meaning.offset);
      }
    }
  }
}

Raster read_head(const fs::path& path, GDALDatasetH dataset, bool& south_up) {
  Raster raster;
  raster.width = GDALGetRasterXSize(dataset);
  raster.height = GDALGetRasterYSize(dataset);
  south_up = read_grid(path, dataset, raster);
  raster.crs = read_crs(path, dataset);
  return raster;
}

}  // namespace

void write_cog(const fs::path& path, const Raster& raster) {
  check_shape(raster);
  const GdalMessages messages;
  const DatasetPtr memory = dataset_of(path, raster, messages);
  AtomicFile target(path);
  const StringList options =
      string_list({"COMPRESS=DEFLATE", "PREDICTOR=FLOATING_POINT", "BLOCKSIZE=512",
                   "OVERVIEW_RESAMPLING=AVERAGE", "BIGTIFF=IF_SAFER", "NUM_THREADS=1"});
  DatasetPtr written(GDALCreateCopy(driver("COG"), target.path().c_str(), memory.get(), FALSE,
                                    options.get(), nullptr, nullptr));
  if (!written) throw RunError(path.string(), "cannot be written" + messages.tail());
  written.reset();
  // GDAL tells of a full disk at the end, and only so.
  if (!messages.tail().empty())
    throw RunError(path.string(), "cannot be written" + messages.tail());
  target.commit();
}

Raster read_raster_head(const fs::path& path) {
  const GdalMessages messages;
  const DatasetPtr dataset = open_raster(path, messages);
  bool south_up = false;
  return read_head(path, dataset.get(), south_up);
}

Raster read_raster(const fs::path& path) {
  const GdalMessages messages;
  const DatasetPtr dataset = open_raster(path, messages);
  bool south_up = false;
  Raster raster = read_head(path, dataset.get(), south_up);
  const auto pixels =
      static_cast<std::uint64_t>(raster.width) * static_cast<std::uint64_t>(raster.height);
  if (pixels > available_memory_bytes() / sizeof(float)) {
    throw InputError(path.string(), "has " + std::to_string(pixels) +
                                        " pixels, more than fit into memory; cut it into tiles");
  }
  raster.values.resize(static_cast<std::size_t>(pixels));
  read_values(path, dataset.get(), south_up, raster, messages);
  return raster;
}

}  // namespace cornice
