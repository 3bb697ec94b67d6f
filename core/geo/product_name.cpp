// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geo/product_name.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstdio>
#include <string_view>
#include <vector>

namespace cornice {
namespace {

constexpr double kTileSide = 1000.0;  // metres; every product is delivered in square kilometres

/// Range of corners in km that a grid can have; wide enough for territorial borders, no wider.
struct GridRange {
  int min_east = 0, max_east = 0, min_north = 0, max_north = 0;
  bool contains(int east, int north) const {
    return east >= min_east && east <= max_east && north >= min_north && north <= max_north;
  }
};
constexpr GridRange kLv95{2480, 2840, 1070, 1300};
constexpr GridRange kLambert93{0, 1300, 6000, 7200};

/// How IGN names a projected system in file names.
struct IgnSystem {
  std::string_view token;
  int epsg;
  GridRange range;
};
constexpr std::array<IgnSystem, 9> kIgnSystems = {{
    {"lamb93", 2154, kLambert93},
    {"la93", 2154, kLambert93},
    {"rgr92utm40s", 2975, {250, 450, 7600, 7750}},
    {"rgr92utm40", 2975, {250, 450, 7600, 7750}},
    {"rgaf09utm20", 5490, {450, 800, 1550, 2050}},
    {"rgaf09utm20n", 5490, {450, 800, 1550, 2050}},
    {"rgm04utm38s", 4471, {450, 600, 8500, 8650}},
    {"rgfg95utm22", 2972, {100, 900, 200, 700}},
    {"rgfg95utm22n", 2972, {100, 900, 200, 700}},
}};

/// Territory codes of the "LHD_" names, for those whose system is not named.
struct IgnTerritory {
  std::string_view token;
  std::string_view system;
};
constexpr std::array<IgnTerritory, 8> kIgnTerritories = {{
    {"fxx", "lamb93"},
    {"reu", "rgr92utm40s"},
    {"glp", "rgaf09utm20"},
    {"mtq", "rgaf09utm20"},
    {"blm", "rgaf09utm20"},
    {"maf", "rgaf09utm20"},
    {"myt", "rgm04utm38s"},
    {"guf", "rgfg95utm22"},
}};

/// Height systems as file names have them.
struct IgnHeights {
  std::string_view token;
  int epsg;
};
constexpr std::array<IgnHeights, 10> kIgnHeights = {{
    {"ign69", 5720},
    {"ign78", 5721},
    {"ign78c", 5721},
    {"reun89", 5758},
    {"guad88", 5757},
    {"mart87", 5756},
    {"ngg77", 5755},
    {"ngg1977", 5755},
    {"mayo50", 5793},
    {"mayo53", 5793},
}};

template <class Table>
const typename Table::value_type* find_token(const Table& table, std::string_view token) {
  const auto found = std::find_if(table.begin(), table.end(),
                                  [&](const auto& entry) { return entry.token == token; });
  return found == table.end() ? nullptr : &*found;
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

std::vector<std::string> split(std::string_view text, std::string_view separators) {
  std::vector<std::string> tokens(1);
  for (char c : text) {
    if (separators.find(c) != std::string_view::npos) {
      tokens.emplace_back();
    } else {
      tokens.back() += c;
    }
  }
  return tokens;
}

bool all_digits(std::string_view token) {
  return !token.empty() && std::all_of(token.begin(), token.end(),
                                       [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// The number of a token of exactly four digits.
std::optional<int> four_digits(std::string_view token) {
  if (token.size() != 4 || !all_digits(token)) return std::nullopt;
  int value = 0;
  for (char c : token) value = value * 10 + (c - '0');
  return value;
}

std::optional<int> year_of(std::string_view token) {
  const std::optional<int> year = four_digits(token);
  return year && *year >= 1990 && *year <= 2099 ? year : std::nullopt;
}

/// Square of one tile by its south-west corner in km.
Box2d tile_box(int east_km, int south_km) {
  const double x = east_km * kTileSide;
  const double y = south_km * kTileSide;
  return {x, y, x + kTileSide, y + kTileSide};
}

bool has_extension(const std::string& file, std::initializer_list<std::string_view> extensions) {
  return std::any_of(extensions.begin(), extensions.end(), [&](std::string_view extension) {
    return file.size() > extension.size() && std::string_view(file).ends_with(extension);
  });
}
bool is_point_file(const std::string& file) {
  return has_extension(file, {".las", ".laz", ".las.zip", ".laz.zip"});
}
bool is_raster_file(const std::string& file) {
  return has_extension(file, {".tif", ".tiff", ".asc", ".xyz", ".tif.zip", ".asc.zip", ".xyz.zip"});
}

/// swisssurface3d_2019_2746-1234_2056_5728.las.zip
/// swissalti3d_2019_2636-1184_0.5_2056_5728.tif
std::optional<ProductName> parse_swiss(const std::string& file) {
  const std::vector<std::string> tokens = split(file, "_");
  ProductName name;
  if (tokens[0] == "swisssurface3d" && is_point_file(file)) {
    name.product = Product::kSwissSurface3d;
  } else if (tokens[0] == "swissalti3d" && is_raster_file(file)) {
    name.product = Product::kSwissAlti3d;
  } else if (tokens[0] == "swisssurface3d-raster" && is_raster_file(file)) {
    name.product = Product::kSwissSurface3dRaster;
  } else {
    return std::nullopt;
  }
  // Rasters name their step between the corner and the CRS.
  const std::size_t crs_at = name.product == Product::kSwissSurface3d ? 3 : 4;
  if (tokens.size() != crs_at + 2 || tokens[crs_at] != "2056") return std::nullopt;
  const std::vector<std::string> corner = split(tokens[2], "-");
  const std::optional<int> year = year_of(tokens[1]);
  if (!year || corner.size() != 2) return std::nullopt;
  const std::optional<int> east = four_digits(corner[0]);
  const std::optional<int> north = four_digits(corner[1]);
  const std::string vertical = tokens.back().substr(0, tokens.back().find('.'));
  if (!east || !north || !kLv95.contains(*east, *north) || vertical != "5728") return std::nullopt;
  name.year = *year;
  name.tile = tile_box(*east, *north);
  name.crs_text = "EPSG:2056+5728";
  return name;
}

/// What a Lidar HD name holds, as positions in its tokens.
struct IgnTokens {
  const IgnSystem* system = nullptr;
  std::size_t system_at = 0;  ///< where the system's token stands; past the end if by territory
  const IgnHeights* heights = nullptr;
  bool is_raster = false;
  bool is_points = false;
};

IgnTokens classify(const std::vector<std::string>& tokens) {
  IgnTokens found;
  found.system_at = tokens.size();
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    const std::string& token = tokens[i];
    if (found.system == nullptr) {
      found.system = find_token(kIgnSystems, token);
      if (found.system != nullptr) found.system_at = i;
    }
    if (found.heights == nullptr) found.heights = find_token(kIgnHeights, token);
    found.is_raster = found.is_raster || token == "mnt" || token == "mns" || token == "mnh";
    found.is_points = found.is_points || token == "pts" || token == "semis";
  }
  if (found.system == nullptr && tokens[0] == "lhd" && tokens.size() > 1) {
    const IgnTerritory* territory = find_token(kIgnTerritories, tokens[1]);
    if (territory != nullptr) found.system = find_token(kIgnSystems, territory->system);
  }
  return found;
}

std::string ign_crs_text(const IgnTokens& found) {
  std::string text = "EPSG:" + std::to_string(found.system->epsg);
  if (found.heights != nullptr) text += "+" + std::to_string(found.heights->epsg);
  return text;
}

/// LHD_FXX_0657_6868_PTS_O_LAMB93_IGN69.copc.laz, LHD_FXX_0957_6218_MNT_O_0M50_LAMB93_IGN69,
/// Semis_2021_0382_6565_LA93_IGN69.laz, PREFIX_0382_6565_LA93_IGN69_SUFFIX.laz
std::optional<ProductName> parse_ign(const std::string& file) {
  const std::string stem = file.substr(0, file.find('.'));
  const std::vector<std::string> tokens = split(stem, "_-");
  const IgnTokens found = classify(tokens);
  if (found.system == nullptr) return std::nullopt;
  ProductName name;
  name.crs_text = ign_crs_text(found);
  const bool no_extension = file.find('.') == std::string::npos;
  if (found.is_raster && (is_raster_file(file) || no_extension)) {
    name.product = Product::kLidarHdRaster;
  } else if (is_point_file(file) || (found.is_points && no_extension)) {
    name.product = Product::kLidarHdPoints;
  } else {
    return std::nullopt;
  }
  const bool delivered_name = tokens[0] == "lhd";
  // The corner is the last pair of numbers before the system ("LHD" names put more in between).
  for (std::size_t i = std::min(found.system_at, tokens.size()); i-- > 1;) {
    if (!all_digits(tokens[i]) || !all_digits(tokens[i - 1])) continue;
    const std::optional<int> east = four_digits(tokens[i - 1]);
    const std::optional<int> north = four_digits(tokens[i]);
    if (!east || !north) break;  // some other grid, such as 50 m sample tiles
    if (!found.system->range.contains(*east, *north)) return std::nullopt;
    name.tile = tile_box(*east, *north - 1);  // the name has the north-west corner
    if (i >= 2) name.year = year_of(tokens[i - 2]).value_or(0);
    return name;
  }
  // Without a corner the name still fixes the CRS, if it says both systems.
  const bool names_system = found.system_at < tokens.size() && found.heights != nullptr;
  return names_system && !delivered_name ? std::optional(name) : std::nullopt;
}

std::string formatted(const char* format, int a, int b) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), format, a, b);
  return text.data();
}

}  // namespace

std::optional<ProductName> parse_product_name(const std::string& file_name) {
  if (file_name.find('/') != std::string::npos || file_name.empty()) return std::nullopt;
  const std::string file = lower(file_name);
  if (file.starts_with("swiss")) return parse_swiss(file);
  return parse_ign(file);
}

std::string swisssurface3d_name(int year, int east_km, int north_km, const std::string& extension) {
  return "swisssurface3d_" + std::to_string(year) + formatted("_%04d-%04d", east_km, north_km) +
         "_2056_5728" + extension;
}

std::string lidarhd_name(int east_km, int north_km, const std::string& extension) {
  return "LHD_FXX" + formatted("_%04d_%04d", east_km, north_km) + "_PTS_O_LAMB93_IGN69" + extension;
}

}  // namespace cornice
