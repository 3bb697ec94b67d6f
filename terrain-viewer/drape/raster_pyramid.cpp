// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/drape/raster_pyramid.h"

#include <cpl_string.h>
#include <gdal.h>
#include <gdal_utils.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <mutex>
#include <utility>

#include "core/base/error.h"
#include "core/geo/crs.h"
#include "core/geo/gdal_handles.h"
#include "core/io/gdal_messages.h"

namespace cornice::viewer {
namespace {

namespace fs = std::filesystem;

/// Rasters of more pixels are slow to see from afar where they hold no smaller copies.
constexpr double kSlowPixels = 1e8;
/// Parts of a pixel by which a reprojected place may be off.
constexpr const char* kWarpErrorPixels = "0.125";

void register_drivers() {
  static std::once_flag once;
  std::call_once(once, [] { GDALAllRegister(); });
}

DatasetPtr open_file(const fs::path& file, const GdalMessages& messages) {
  register_drivers();
  DatasetPtr dataset(
      GDALOpenEx(file.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
  if (!dataset)
    throw InputError(file.string(), "is no raster that GDAL can read" + messages.tail());
  if (GDALGetRasterCount(dataset.get()) < 1) throw InputError(file.string(), "has no band");
  return dataset;
}

/// A call of one of GDAL's programs that leaves a virtual dataset in memory.
DatasetPtr virtual_mosaic(std::vector<GDALDatasetH> from) {
  const std::array<const char*, 3> words{"-resolution", "highest", nullptr};
  GDALBuildVRTOptions* options = GDALBuildVRTOptionsNew(const_cast<char**>(words.data()), nullptr);
  DatasetPtr made(
      GDALBuildVRT("", static_cast<int>(from.size()), from.data(), nullptr, options, nullptr));
  GDALBuildVRTOptionsFree(options);
  return made;
}

DatasetPtr without_palette(GDALDatasetH from) {
  const std::array<const char*, 5> words{"-of", "VRT", "-expand", "rgba", nullptr};
  GDALTranslateOptions* options =
      GDALTranslateOptionsNew(const_cast<char**>(words.data()), nullptr);
  DatasetPtr made(GDALTranslate("", from, options, nullptr));
  GDALTranslateOptionsFree(options);
  return made;
}

DatasetPtr reprojected(GDALDatasetH from, const std::string& to_wkt) {
  std::vector<const char*> words{"-of", "VRT",           "-r", "bilinear", "-dstalpha",
                                 "-et", kWarpErrorPixels};
  if (!to_wkt.empty()) {
    words.push_back("-t_srs");
    words.push_back(to_wkt.c_str());
  }
  words.push_back(nullptr);
  GDALWarpAppOptions* options = GDALWarpAppOptionsNew(const_cast<char**>(words.data()), nullptr);
  DatasetPtr made(GDALWarp("", nullptr, 1, &from, options, nullptr));
  GDALWarpAppOptionsFree(options);
  return made;
}

/// WKT of the plan position's part.
std::string horizontal_wkt(const Crs& crs) {
  OGRSpatialReferenceH srs = OSRNewSpatialReference(crs.wkt.c_str());
  OSRStripVertical(srs);
  char* text = nullptr;
  OSRExportToWkt(srs, &text);
  const std::string wkt = text != nullptr ? text : "";
  CPLFree(text);
  OSRDestroySpatialReference(srs);
  return wkt;
}

bool has_palette(GDALDatasetH dataset) {
  return GDALGetRasterColorTable(GDALGetRasterBand(dataset, 1)) != nullptr;
}

std::optional<RasterKind> kind_of(GDALDatasetH dataset) {
  const GDALDataType type = GDALGetRasterDataType(GDALGetRasterBand(dataset, 1));
  return type == GDT_Byte ? RasterKind::kPhoto : RasterKind::kValues;
}

bool is_north_up(const std::array<double, 6>& t) {
  return t[2] == 0.0 && t[4] == 0.0 && t[1] > 0.0 && t[5] < 0.0;
}

struct StopCheck {
  const std::atomic<bool>* stop;
};
int CPL_STDCALL go_on(double, const char*, void* data) {
  const auto* check = static_cast<const StopCheck*>(data);
  return check->stop == nullptr || !check->stop->load() ? TRUE : FALSE;
}

/// The part of a tile that the raster has texels for, in texels of the tile.
struct Inside {
  int first = 0, count = 0;   ///< texels of the tile
  int pixel = 0, pixels = 0;  ///< of the raster
};
Inside inside(int tile, int level, int texels, int size) {
  const int start = tile * kTileTexels - 1;  // of the tile's border
  Inside part;
  part.first = std::max(0, -start);
  const int end = std::min(kTileSide, texels - start);
  part.count = end - part.first;
  part.pixel = (start + part.first) << level;
  part.pixels = std::min(size - part.pixel, part.count << level);
  return part;
}

/// Texels outside of the raster become those at its edge.
void extend_edges(std::vector<std::uint8_t>& bytes, std::size_t texel, const Inside& x,
                  const Inside& y) {
  const std::size_t line = kTileSide * texel;
  for (int row = y.first; row < y.first + y.count; ++row) {
    std::uint8_t* at = bytes.data() + static_cast<std::size_t>(row) * line;
    const auto from = [&](int column) { return at + static_cast<std::size_t>(column) * texel; };
    for (int c = 0; c < x.first; ++c) std::memcpy(from(c), from(x.first), texel);
    for (int c = x.first + x.count; c < kTileSide; ++c)
      std::memcpy(from(c), from(x.first + x.count - 1), texel);
  }
  const auto from = [&](int row) { return bytes.data() + static_cast<std::size_t>(row) * line; };
  for (int r = 0; r < y.first; ++r) std::memcpy(from(r), from(y.first), line);
  for (int r = y.first + y.count; r < kTileSide; ++r)
    std::memcpy(from(r), from(y.first + y.count - 1), line);
}

/// Texels without coverage get the mean of their covered neighbours. T: of a channel; the last
/// channel is the coverage.
template <class T, std::size_t Channels>
void spread_colours(std::vector<std::uint8_t>& bytes) {
  const std::vector<std::uint8_t> before = bytes;
  const auto texel = [](const std::vector<std::uint8_t>& of, int column, int row) {
    std::array<T, Channels> value;
    const auto at = static_cast<std::size_t>(row * kTileSide + column) * sizeof value;
    std::memcpy(value.data(), of.data() + at, sizeof value);
    return value;
  };
  for (int row = 0; row < kTileSide; ++row)
    for (int column = 0; column < kTileSide; ++column) {
      std::array<T, Channels> own = texel(before, column, row);
      if (own[Channels - 1] != T{0}) continue;
      std::array<double, Channels> sum{};
      double count = 0.0;
      for (int r = std::max(0, row - 1); r <= std::min(kTileSide - 1, row + 1); ++r)
        for (int c = std::max(0, column - 1); c <= std::min(kTileSide - 1, column + 1); ++c) {
          const auto near = texel(before, c, r);
          if (near[Channels - 1] == T{0}) continue;
          for (std::size_t i = 0; i + 1 < Channels; ++i) sum[i] += static_cast<double>(near[i]);
          count += 1.0;
        }
      if (count == 0.0) continue;
      for (std::size_t i = 0; i + 1 < Channels; ++i) own[i] = static_cast<T>(sum[i] / count);
      std::memcpy(bytes.data() + static_cast<std::size_t>(row * kTileSide + column) * sizeof own,
                  own.data(), sizeof own);
    }
}

}  // namespace

PyramidGrid make_grid(int width, int height, double west, double north, double texel_x,
                      double texel_y) {
  PyramidGrid grid{width, height, west, north, texel_x, texel_y, 1};
  while (((std::max(width, height) - 1) >> (grid.levels - 1)) >= kTileTexels) ++grid.levels;
  return grid;
}

struct RasterPyramid::State {
  std::string name;
  std::vector<DatasetPtr> datasets;  ///< each refers to those before it
  GDALDatasetH top = nullptr;
  std::vector<int> bands;  ///< of colours
  double scale = 1.0, offset = 0.0;

  ~State() {
    while (!datasets.empty()) datasets.pop_back();
  }
  void put_over(DatasetPtr dataset, const std::string& what, const GdalMessages& messages) {
    if (!dataset) throw InputError(name, "cannot be " + what + messages.tail());
    datasets.push_back(std::move(dataset));
    top = datasets.back().get();
  }
  void open(const std::vector<fs::path>& files, const std::string& scene_crs);
  void fit_to_scene(const std::string& scene_crs, const GdalMessages& messages);
  bool is_all_valid() const {
    return (GDALGetMaskFlags(GDALGetRasterBand(top, 1)) & GMF_ALL_VALID) != 0;
  }
};

void RasterPyramid::State::open(const std::vector<fs::path>& files, const std::string& scene_crs) {
  const GdalMessages messages;
  std::vector<GDALDatasetH> sources;
  for (const fs::path& file : files) {
    DatasetPtr dataset = open_file(file, messages);
    std::array<double, 6> t{};
    if (GDALGetGeoTransform(dataset.get(), t.data()) != CE_None)
      throw InputError(file.string(),
                       "does not say where it lies; give it a georeference, with gdal_translate "
                       "-a_ullr");
    sources.push_back(dataset.get());
    datasets.push_back(std::move(dataset));
  }
  top = sources.front();
  if (files.size() > 1)
    put_over(virtual_mosaic(sources), "put together with the other rasters", messages);
  if (has_palette(top)) put_over(without_palette(top), "read by its palette", messages);
  fit_to_scene(scene_crs, messages);
}

void RasterPyramid::State::fit_to_scene(const std::string& scene_crs,
                                        const GdalMessages& messages) {
  std::array<double, 6> t{};
  GDALGetGeoTransform(top, t.data());
  const char* wkt = GDALGetProjectionRef(top);
  const auto own = wkt != nullptr && *wkt != '\0' ? crs_from_wkt(wkt) : std::nullopt;
  std::string to;
  if (own && !scene_crs.empty()) {
    const Crs scene = crs_from_text(scene_crs);
    if (!same_crs(*own, scene)) to = horizontal_wkt(scene);
  }
  if (to.empty() && is_north_up(t)) return;
  put_over(reprojected(top, to), "brought into the reference system of the scene", messages);
}

RasterPyramid::RasterPyramid(const std::vector<fs::path>& files, RasterKind kind,
                             const std::string& scene_crs)
    : state_(std::make_unique<State>()), kind_(kind) {
  state_->name = files.front().string();
  state_->open(files, scene_crs);
  GDALDatasetH top = state_->top;
  const GDALRasterBandH first = GDALGetRasterBand(top, 1);
  if (kind == RasterKind::kPhoto) {
    if (kind_of(top) != RasterKind::kPhoto)
      throw InputError(state_->name, std::string("has ") +
                                         GDALGetDataTypeName(GDALGetRasterDataType(first)) +
                                         " in its bands; a photograph has bytes: gdal_translate "
                                         "-ot Byte -scale makes them");
    const bool is_grey = GDALGetRasterCount(top) < 3;
    state_->bands = is_grey ? std::vector<int>{1, 1, 1} : std::vector<int>{1, 2, 3};
  } else {
    int known = 0;
    const double scale = GDALGetRasterScale(first, &known);
    if (known != 0 && scale != 0.0) state_->scale = scale;
    const double offset = GDALGetRasterOffset(first, &known);
    if (known != 0) state_->offset = offset;
  }
  std::array<double, 6> t{};
  GDALGetGeoTransform(top, t.data());
  grid_ = make_grid(GDALGetRasterXSize(top), GDALGetRasterYSize(top), t[0], t[3], t[1], -t[5]);
  if (grid_.levels > PyramidGrid::kMostLevels || !(grid_.texel_x > 0.0) || !(grid_.texel_y > 0.0))
    throw InputError(state_->name, "says a size that no raster has");
  if (files.size() == 1 && GDALGetOverviewCount(first) == 0 &&
      double(grid_.width) * grid_.height > kSlowPixels)
    advice_ =
        state_->name +
        " holds no smaller copies of itself and is slow to see from afar; gdaladdo makes them";
}

RasterPyramid::~RasterPyramid() = default;

RasterTile RasterPyramid::read(TileKey key, const std::atomic<bool>* stop) {
  const GdalMessages messages;
  const Inside x = inside(key.column, key.level, grid_.texels_x(key.level), grid_.width);
  const Inside y = inside(key.row, key.level, grid_.texels_y(key.level), grid_.height);
  const std::size_t texel = texel_bytes(kind_);
  RasterTile tile{key, std::vector<std::uint8_t>(kTileSide * kTileSide * texel)};
  const std::size_t first = static_cast<std::size_t>(y.first * kTileSide + x.first) * texel;
  std::uint8_t* to = tile.bytes.data() + first;
  StopCheck check{stop};
  GDALRasterIOExtraArg extra;
  INIT_RASTERIO_EXTRA_ARG(extra);
  extra.eResampleAlg = key.level > 0 ? GRIORA_Average : GRIORA_NearestNeighbour;
  extra.pfnProgress = go_on;
  extra.pProgressData = &check;
  const auto line = static_cast<GSpacing>(kTileSide * texel);
  const auto read_band = [&](int band, bool is_mask, GDALDataType type, std::size_t offset) {
    GDALRasterBandH handle = GDALGetRasterBand(state_->top, band);
    if (is_mask) handle = GDALGetMaskBand(handle);
    if (GDALRasterIOEx(handle, GF_Read, x.pixel, y.pixel, x.pixels, y.pixels, to + offset, x.count,
                       y.count, type, static_cast<GSpacing>(texel), line, &extra) == CE_None)
      return;
    if (stop != nullptr && stop->load()) return;
    throw InputError(state_->name, "cannot be read at column " + std::to_string(x.pixel) +
                                       ", row " + std::to_string(y.pixel) + messages.tail());
  };
  const bool is_all_valid = state_->is_all_valid();
  if (kind_ == RasterKind::kPhoto) {
    for (std::size_t c = 0; c < 3; ++c) read_band(state_->bands[c], false, GDT_Byte, c);
    if (is_all_valid)
      for (std::size_t i = 3; i < tile.bytes.size(); i += 4) tile.bytes[i] = 255;
    else
      read_band(1, true, GDT_Byte, 3);
    extend_edges(tile.bytes, texel, x, y);
    spread_colours<std::uint8_t, 4>(tile.bytes);
    return tile;
  }
  read_band(1, false, GDT_Float32, 0);
  // 255 where it is there.
  if (!is_all_valid) read_band(1, true, GDT_Float32, 4);
  extend_edges(tile.bytes, texel, x, y);
  for (std::size_t i = 0; i < tile.bytes.size(); i += texel) {
    std::array<float, 2> pair{};
    std::memcpy(pair.data(), tile.bytes.data() + i, texel);
    const float share = is_all_valid ? 1.0f : pair[1] / 255.0f;
    const double value = double(pair[0]) * state_->scale + state_->offset;
    pair = {static_cast<float>(value), share};
    if (!std::isfinite(value) || !(share > 0.0f)) pair = {0.0f, 0.0f};
    std::memcpy(tile.bytes.data() + i, pair.data(), texel);
  }
  spread_colours<float, 2>(tile.bytes);
  return tile;
}

std::optional<RasterKind> raster_kind(const fs::path& file) {
  register_drivers();
  const QuietGdal quiet;
  const DatasetPtr dataset(
      GDALOpenEx(file.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
  if (!dataset || GDALGetRasterCount(dataset.get()) < 1) return std::nullopt;
  return kind_of(dataset.get());
}

double value_range(const RasterTile& tile) {
  std::vector<double> sizes;
  for (std::size_t i = 0; i < tile.bytes.size(); i += texel_bytes(RasterKind::kValues)) {
    std::array<float, 2> pair{};
    std::memcpy(pair.data(), tile.bytes.data() + i, sizeof pair);
    if (pair[1] > 0.0f) sizes.push_back(std::abs(double(pair[0])));
  }
  if (sizes.empty()) return 1.0;
  const auto at = static_cast<std::ptrdiff_t>(0.98 * double(sizes.size() - 1));
  std::nth_element(sizes.begin(), sizes.begin() + at, sizes.end());
  const double most = std::max(sizes[static_cast<std::size_t>(at)], 1e-3);
  const double power = std::pow(10.0, std::floor(std::log10(most)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= most * (1.0 - 1e-6)) return factor * power;
  return 10.0 * power;
}

}  // namespace cornice::viewer
