// SPDX-License-Identifier: GPL-3.0-or-later
// Coordinate reference systems as values; PROJ and GDAL stay behind crs.cpp.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace cornice {

/// A CRS, horizontal or compound. Empty where nothing is known.
struct Crs {
  std::string wkt;          ///< WKT of the whole, OGC WKT 1 as LAS 1.4 wants it; empty: no CRS
  int horizontal_epsg = 0;  ///< 0 where no authority code is known
  int vertical_epsg = 0;    ///< 0 where there is no vertical part or no code
  std::string name;
  double metres_per_unit = 1.0;  ///< of the horizontal axes; of degrees: 0
  /// Of heights. Without a vertical part: as the horizontal axes of a projected CRS, else metres.
  double vertical_metres_per_unit = 1.0;
  bool projected = false;
  bool has_vertical = false;  ///< compound, or with ellipsoidal heights

  bool empty() const { return wkt.empty(); }
  /// "EPSG:2056+5728", "EPSG:2154", the WKT where there is no code, or "" where empty.
  std::string text() const;
};

/// CRS from user text: "EPSG:2056+5728", "EPSG:2154", WKT, PROJ string.
/// Throws UsageError("--crs", ...) where PROJ does not know it, and where it is vertical only or
/// geocentric. Reads neither files nor the network.
Crs crs_from_text(const std::string& text);

/// CRS from WKT 1 or 2; nothing where it cannot be parsed or says nothing of the plan position.
/// Padding by zero bytes and white space is allowed.
std::optional<Crs> crs_from_wkt(const std::string& wkt);

/// CRS from the GeoTIFF keys of a LAS file: the three records 34735, 34736, 34737 as stored.
/// Nothing where the keys are empty or say "user defined" without enough to build a CRS.
std::optional<Crs> crs_from_geotiff_keys(const std::vector<unsigned char>& keys,
                                         const std::vector<unsigned char>& doubles,
                                         const std::string& ascii);

/// The inverse of crs_from_geotiff_keys for a CRS with EPSG codes: record 34735's bytes. Empty
/// where there is no horizontal code, or a vertical part without one.
std::vector<unsigned char> geotiff_keys_from_crs(const Crs& crs);

/// The three GeoTIFF records of a LAS file.
struct GeotiffRecords {
  std::vector<unsigned char> keys;     ///< 34735
  std::vector<unsigned char> doubles;  ///< 34736
  std::string ascii;                   ///< 34737
};

/// As geotiff_keys_from_crs, and for a CRS without codes with its parameters spelled out.
/// All empty for an empty CRS and for one that GeoTIFF cannot say.
GeotiffRecords geotiff_records_from_crs(const Crs& crs);

/// True where both have the same horizontal system, and the same vertical one where both have one.
/// Codes decide where known; else PROJ's own comparison. An empty CRS equals only an empty one.
bool same_crs(const Crs& a, const Crs& b);

}  // namespace cornice
