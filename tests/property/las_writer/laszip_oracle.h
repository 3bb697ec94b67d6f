// SPDX-License-Identifier: GPL-3.0-or-later
// What LASzip itself reads in a file: the foreign second opinion on what we write.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace cornice::test {

/// Every field of a point as LASzip has it; those the format lacks are 0.
struct OraclePoint {
  std::int32_t x, y, z;
  std::uint16_t intensity;
  int return_number, return_count;
  int classification;
  int flags;  ///< PointFlag bits, the overlap from the extended flags only
  int channel;
  int scan_angle;  ///< as stored: whole degrees, or steps of 0.006 in formats 6 and above
  int user_data;
  int point_source_id;
  double gps_time;
  std::array<std::uint16_t, 4> rgb;
  std::array<std::uint8_t, 29> wave_packet;
  std::vector<std::uint8_t> extra_bytes;

  friend bool operator==(const OraclePoint&, const OraclePoint&) = default;
  friend auto operator<=>(const OraclePoint&, const OraclePoint&) = default;
};

struct OracleVlr {
  std::string user_id;
  int record_id = 0;
  std::vector<std::uint8_t> data;
};

struct OracleFile {
  int version_minor = 0;
  int point_format = 0;
  int record_bytes = 0;
  int global_encoding = 0;
  bool compressed = false;
  std::uint64_t legacy_count = 0;
  std::array<std::uint64_t, 5> legacy_by_return{};
  std::uint64_t extended_count = 0;
  std::array<std::uint64_t, 15> extended_by_return{};
  std::array<double, 6> bounds{};  ///< min x, max x, min y, max y, min z, max z
  std::vector<OracleVlr> vlrs;
  std::vector<OraclePoint> points;
};

/// Throws std::runtime_error with LASzip's own words where it cannot read the file to its end.
OracleFile read_with_laszip(const std::filesystem::path& path);

/// Points inside a closed rectangle as LASzip finds them through the spatial index beside the file;
/// throws where it finds no index.
std::vector<OraclePoint> read_window_with_laszip(const std::filesystem::path& path,
                                                 std::array<double, 4> min_xy_max_xy);

}  // namespace cornice::test
