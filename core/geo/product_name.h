// SPDX-License-Identifier: GPL-3.0-or-later
// What the file names of swissSURFACE3D, swissALTI3D and Lidar HD say.
#pragma once

#include <optional>
#include <string>

#include "core/base/vec.h"

namespace cornice {

enum class Product {
  kSwissSurface3d,
  kSwissAlti3d,
  kLidarHdPoints,
  kLidarHdRaster,
  kSwissSurface3dRaster,
};

/// A file name of a known product, taken apart.
struct ProductName {
  Product product = Product::kSwissSurface3d;
  int year = 0;          ///< 0 where the name has none
  Box2d tile;            ///< metres; empty where the name does not fix the tile's size
  std::string crs_text;  ///< "EPSG:2056+5728", "EPSG:2154+5720"; empty where unknown
};

/// Parses a file name without its folder; nothing where it is of no known product.
/// swissSURFACE3D and swissALTI3D names give the south-west corner in km, Lidar HD names the
/// north-west corner. Letter case does not matter, nor, in Lidar HD names, underscore or dash.
/// Names of the form "PREFIX_0382_6565_LA93_IGN69_SUFFIX" are Lidar HD tiles whatever their prefix;
/// where the two numbers do not have the four digits of a tile in km ("77055_627760"), only the CRS
/// is taken. Numbers outside the country's grid are of no known product.
std::optional<ProductName> parse_product_name(const std::string& file_name);

/// "swisssurface3d_2019_2746-1234_2056_5728.las.zip" and the like, extension included.
std::string swisssurface3d_name(int year, int east_km, int north_km, const std::string& extension);

/// "LHD_FXX_0657_6868_PTS_O_LAMB93_IGN69.copc.laz" for the tile whose NORTH-west corner is given.
std::string lidarhd_name(int east_km, int north_km, const std::string& extension);

}  // namespace cornice
