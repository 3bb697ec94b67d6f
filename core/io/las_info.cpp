// SPDX-License-Identifier: GPL-3.0-or-later
// What a point file says of itself, its coordinate system included.
#include <algorithm>
#include <optional>

#include "core/base/error.h"
#include "core/geo/known_crs.h"
#include "core/geo/product_name.h"
#include "core/io/byte_source.h"
#include "core/io/las.h"
#include "core/io/las_chunks.h"
#include "core/io/las_header.h"
#include "core/io/little_endian.h"

namespace cornice {
namespace {

constexpr std::uint16_t kWktBit = 1u << 4;
constexpr std::uint16_t kUserDefined = 32767;
constexpr const char* kProjectionUser = "LASF_Projection";

std::string as_text(const std::vector<std::uint8_t>& bytes) {
  std::string text(bytes.begin(), bytes.end());
  text.erase(std::find(text.begin(), text.end(), '\0'), text.end());
  return text;
}

/// The WKT record's text, empty where there is none or it is blank.
std::string wkt_text(const LasInfo& info) {
  const LasVlr* record = find_vlr(info, kProjectionUser, 2112);
  if (record == nullptr) return "";
  std::string text = as_text(record->data);
  const bool blank = text.find_first_not_of(" \t\r\n'\"") == std::string::npos;
  return blank ? "" : text;
}

std::optional<Crs> crs_of_wkt(const LasInfo& info, const std::string& name) {
  const std::string text = wkt_text(info);
  if (text.empty()) return std::nullopt;
  std::optional<Crs> crs = known_crs_from_wkt(text);
  if (!crs) {
    throw InputError(name, "has a coordinate system that cannot be read (record 2112, WKT '" +
                               text.substr(0, 40) + "'); give the right one with --crs");
  }
  return crs;
}

/// The EPSG code that the keys name for a projected (3072) or geographic (2048) system; 0: none.
int named_code(std::span<const std::uint8_t> keys) {
  int code = 0;
  for (std::size_t at = 8; at + 8 <= keys.size(); at += 8) {
    const auto key = load_le<std::uint16_t>(keys, at);
    const auto value = load_le<std::uint16_t>(keys, at + 6);
    if ((key == 3072 || (key == 2048 && code == 0)) && value != kUserDefined) code = value;
  }
  return code;
}

std::optional<Crs> crs_of_keys(LasInfo& info, const std::string& name) {
  const LasVlr* keys = find_vlr(info, kProjectionUser, 34735);
  if (keys == nullptr) return std::nullopt;
  const LasVlr* doubles = find_vlr(info, kProjectionUser, 34736);
  const LasVlr* ascii = find_vlr(info, kProjectionUser, 34737);
  std::optional<Crs> crs = known_crs_from_geotiff_keys(
      keys->data, doubles != nullptr ? doubles->data : std::vector<std::uint8_t>{},
      ascii != nullptr ? as_text(ascii->data) : "");
  if (crs && !crs->empty()) return crs;
  if (const int code = named_code(keys->data); code != 0) {
    throw InputError(name, "has a coordinate system that cannot be read (record 34735 names EPSG:" +
                               std::to_string(code) + "); give the right one with --crs");
  }
  info.warnings.emplace_back("the GeoTIFF keys (record 34735) name no coordinate system");
  return std::nullopt;
}

void take_crs_of_records(LasInfo& info, const std::string& name) {
  const bool wkt_bit = (info.global_encoding & kWktBit) != 0;
  const bool wkt_first = wkt_bit || info.point_format >= 6;
  std::optional<Crs> crs;
  if (!wkt_first) crs = crs_of_keys(info, name);
  info.crs_source = "geotiff keys";
  if (!crs) {
    crs = crs_of_wkt(info, name);
    info.crs_source = "wkt";
    if (crs && !wkt_bit) {
      info.warnings.emplace_back(
          "the coordinate system is WKT but bit 4 of the global encoding, which "
          "says so, is not set");
    }
  }
  if (!crs && wkt_first) {
    crs = crs_of_keys(info, name);
    info.crs_source = "geotiff keys";
    if (crs) {
      info.warnings.emplace_back(
          "the coordinate system stands in GeoTIFF keys where the header "
          "promises WKT");
    }
  }
  if (crs) {
    info.crs = *std::move(crs);
  } else {
    info.crs_source.clear();
  }
}

bool has_vertical(const Crs& crs) {
  return crs.vertical_epsg != 0 || crs.wkt.find("VERT") != std::string::npos;
}

/// The product's name fills in what the records leave open: everything, or the heights.
void take_crs_of_name(LasInfo& info) {
  const auto product = parse_product_name(info.path.filename().string());
  if (!product || product->crs_text.empty()) return;
  const Crs named = known_crs_from_text(product->crs_text);
  if (info.crs.empty()) {
    info.crs = named;
    info.crs_source = "file name";
  } else if (!same_crs(info.crs, named)) {
    info.warnings.push_back("the coordinate system in the file (" + info.crs.text() +
                            ") is not that of its name (" + product->crs_text +
                            "); the file's is used");
  } else if (!has_vertical(info.crs) && has_vertical(named)) {
    info.crs = named;
    info.warnings.push_back("the coordinate system has no height part; that of the file name (" +
                            product->crs_text + ") is used");
  }
}

}  // namespace

LasInfo read_las_info(const std::filesystem::path& path, const LasOpenOptions& options) {
  const std::string name = path.string();
  const OpenedSource opened = open_point_file(path);
  LasInfo info = parse_las(*opened.bytes, name);
  info.path = path;
  info.zipped = !opened.zip_member.empty();
  info.zip_member = opened.zip_member;
  if (!options.crs_override.empty()) {
    info.crs = known_crs_from_text(options.crs_override);
    info.crs_source = "option";
  } else {
    try {
      take_crs_of_records(info, name);
    } catch (const InputError& error) {
      if (options.require_readable_crs) throw;
      info.crs_source.clear();
      info.warnings.push_back("the file " + error.problem());
    }
    take_crs_of_name(info);
  }
  info.data_problem = plan_chunks(*opened.bytes, info).problem;
  return info;
}

}  // namespace cornice
