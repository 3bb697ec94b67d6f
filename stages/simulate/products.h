// SPDX-License-Identifier: GPL-3.0-or-later
// How the tiles of swissSURFACE3D and Lidar HD look: format, CRS, names, classes.
#pragma once

#include <cstdint>
#include <string>

#include "core/io/las.h"
#include "stages/simulate/scene.h"
#include "stages/simulate/survey_point.h"

namespace cornice::simulate {

enum class SurveyProduct { kSwissSurface3d, kLidarHd };

/// What a tile is packed in. kCopc is LAS 1.4 of format 6 for both products.
enum class TileContainer { kLas, kLaz, kZippedLas, kCopc };

/// Standard and product classes.
inline constexpr std::uint8_t kClassUnclassified = 1;
inline constexpr std::uint8_t kClassGround = 2;
inline constexpr std::uint8_t kClassLowVegetation = 3;
inline constexpr std::uint8_t kClassMediumVegetation = 4;
inline constexpr std::uint8_t kClassHighVegetation = 5;
inline constexpr std::uint8_t kClassBuilding = 6;
inline constexpr std::uint8_t kClassWater = 9;
inline constexpr std::uint8_t kClassArtefact = 65;
inline constexpr std::uint8_t kClassVirtual = 66;

/// "EPSG:2056+5728" or "EPSG:2154+5720".
std::string crs_text(SurveyProduct product);

/// South-west corner of the first tile where none is asked for: a mountain tile of the product.
Vec3d default_corner(SurveyProduct product);

/// Class of a clean echo.
std::uint8_t class_of(SurveyProduct product, SurfaceId surface, double above_ground_m);

/// Largest number of returns that the product's format holds.
int most_returns(SurveyProduct product, TileContainer container);

/// True where the angle field holds whole degrees (formats 0-5).
bool stores_whole_degrees(SurveyProduct product, TileContainer container);

/// True where a tile of this grid gets the product's own name: 1 km on the kilometre grid.
bool has_product_names(const TileGrid& grid);

/// File name of a tile, with extension. Tiles that are no product tiles are called
/// "sim-SCENE-e2746000-n1234000-100m.laz", which no product's parser takes for its own.
std::string tile_name(SurveyProduct product, TileContainer container, const TileGrid& grid,
                      int tile, int year, const std::string& scene);

/// File name of the DEM of the same tile, as swissALTI3D and Lidar HD MNT have it.
std::string dem_name(SurveyProduct product, const TileGrid& grid, int tile, int year, double step_m,
                     const std::string& scene);

/// Header of a tile. The CRS is left out where the product leaves it out.
LasWriteOptions write_options(SurveyProduct product, TileContainer container, const Box2d& tile,
                              int year);

}  // namespace cornice::simulate
