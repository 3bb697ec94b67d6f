// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/products.h"

#include <cmath>
#include <cstdio>

#include "core/geo/product_name.h"

namespace cornice::simulate {
namespace {

constexpr double kKilometre = 1000.0;
/// Lidar HD tells vegetation apart by its height over the ground (IGN, Lidar HD product sheet).
constexpr double kLowVegetationM = 0.5;
constexpr double kMediumVegetationM = 1.5;

std::string extension_of(TileContainer container) {
  switch (container) {
    case TileContainer::kLas:
      return ".las";
    case TileContainer::kLaz:
      return ".laz";
    case TileContainer::kZippedLas:
      return ".las.zip";
    case TileContainer::kCopc:
      return ".copc.laz";
  }
  return "";
}

int kilometres(double metres) { return static_cast<int>(std::lround(metres / kKilometre)); }

std::string own_name(const Box2d& tile, const std::string& scene, const std::string& tail) {
  char text[120];
  std::snprintf(text, sizeof text, "-e%.0f-n%.0f-%.0fm", tile.min_x, tile.min_y, tile.width());
  return "sim-" + scene + text + tail;
}

}  // namespace

std::string crs_text(SurveyProduct product) {
  return product == SurveyProduct::kLidarHd ? "EPSG:2154+5720" : "EPSG:2056+5728";
}

Vec3d default_corner(SurveyProduct product) {
  return product == SurveyProduct::kLidarHd ? Vec3d{998000.0, 6536000.0, 0.0}
                                            : Vec3d{2746000.0, 1234000.0, 0.0};
}

std::uint8_t class_of(SurveyProduct product, SurfaceId surface, double above_ground_m) {
  switch (surface) {
    case SurfaceId::kGround:
    case SurfaceId::kOverhang:
      return kClassGround;
    case SurfaceId::kHouse:
      return kClassBuilding;
    case SurfaceId::kWater:
      return kClassWater;
    case SurfaceId::kVegetation:
      break;
  }
  if (product == SurveyProduct::kSwissSurface3d || above_ground_m < kLowVegetationM)
    return kClassLowVegetation;
  return above_ground_m < kMediumVegetationM ? kClassMediumVegetation : kClassHighVegetation;
}

int most_returns(SurveyProduct product, TileContainer container) {
  return stores_whole_degrees(product, container) ? 5 : 7;
}

bool stores_whole_degrees(SurveyProduct product, TileContainer container) {
  return product == SurveyProduct::kSwissSurface3d && container != TileContainer::kCopc;
}

bool has_product_names(const TileGrid& grid) {
  return grid.tile_m == kKilometre && std::remainder(grid.west, kKilometre) == 0.0 &&
         std::remainder(grid.south, kKilometre) == 0.0;
}

std::string tile_name(SurveyProduct product, TileContainer container, const TileGrid& grid,
                      int tile, int year, const std::string& scene) {
  const Box2d box = grid.tile(tile);
  const std::string extension = extension_of(container);
  if (!has_product_names(grid)) return own_name(box, scene, extension);
  if (product == SurveyProduct::kLidarHd)
    return lidarhd_name(kilometres(box.min_x), kilometres(box.max_y), extension);
  return swisssurface3d_name(year, kilometres(box.min_x), kilometres(box.min_y), extension);
}

std::string dem_name(SurveyProduct product, const TileGrid& grid, int tile, int year, double step_m,
                     const std::string& scene) {
  const Box2d box = grid.tile(tile);
  char text[120];
  if (!has_product_names(grid)) {
    std::snprintf(text, sizeof text, "-dem-%gm.tif", step_m);
    return own_name(box, scene, text);
  }
  if (product == SurveyProduct::kLidarHd) {
    std::snprintf(text, sizeof text, "LHD_FXX_%04d_%04d_MNT_O_%dM%02d_LAMB93_IGN69.tif",
                  kilometres(box.min_x), kilometres(box.max_y), static_cast<int>(step_m),
                  static_cast<int>(std::lround(100.0 * (step_m - std::floor(step_m)))));
    return text;
  }
  std::snprintf(text, sizeof text, "swissalti3d_%d_%d-%d_%g_2056_5728.tif", year,
                kilometres(box.min_x), kilometres(box.min_y), step_m);
  return text;
}

LasWriteOptions write_options(SurveyProduct product, TileContainer container, const Box2d& tile,
                              int year) {
  LasWriteOptions options;
  const bool is_swiss = product == SurveyProduct::kSwissSurface3d;
  const bool is_old = stores_whole_degrees(product, container);
  options.version_minor = is_old ? 2 : 4;
  options.point_format = is_old ? 1 : 6;
  options.scale = {kScaleM, kScaleM, kScaleM};
  if (is_swiss) options.offset = {tile.min_x, tile.min_y, 0.0};
  options.compress = container == TileContainer::kLaz || container == TileContainer::kCopc;
  options.system_identifier = "simulated survey";
  options.generating_software = "cornice-simulate";
  options.creation_year = year;
  if (!is_old) options.crs = crs_from_text(crs_text(product));
  return options;
}

}  // namespace cornice::simulate
