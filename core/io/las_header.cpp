// SPDX-License-Identifier: GPL-3.0-or-later
// Source: ASPRS, LAS Specification 1.4 R15, 2019, table 3, and versions 1.0 to 1.3 before it.
#include "core/io/las_header.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/io/little_endian.h"

namespace cornice {
namespace {

constexpr std::size_t kHeaderBytes12 = 227;
constexpr std::size_t kHeaderBytes13 = 235;
constexpr std::size_t kHeaderBytes14 = 375;
constexpr std::uint16_t kAdjustedTimeBit = 1u << 0;
/// A step of the stored integers beyond this is no survey's, whatever its unit.
constexpr double kLargestScale = 1000.0;
constexpr double kSmallestScale = 1e-15;

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

std::size_t header_bytes_of(int version_minor) {
  if (version_minor >= 4) return kHeaderBytes14;
  return version_minor == 3 ? kHeaderBytes13 : kHeaderBytes12;
}

std::vector<std::uint8_t> read_header(ByteSource& source, const std::string& name) {
  std::vector<std::uint8_t> bytes = read_bytes(source, 0, kHeaderBytes14);
  if (bytes.size() < 4 || load_text(bytes, 0, 4) != "LASF") {
    throw InputError(name, "is not LAS or LAZ: it does not begin with 'LASF'; give a point file");
  }
  if (bytes.size() < 26) {
    throw InputError(name, "ends inside the header, after " + std::to_string(bytes.size()) +
                               " bytes; download or copy it again");
  }
  const int major = bytes[24];
  const int minor = bytes[25];
  if (major != 1 || minor > 4) {
    throw InputError(name, "is LAS version " + std::to_string(major) + "." + std::to_string(minor) +
                               " (bytes 24-25); versions 1.0 to 1.4 can be read");
  }
  if (bytes.size() < header_bytes_of(minor)) {
    throw InputError(name, "ends inside the header, after " + std::to_string(bytes.size()) +
                               " of " + std::to_string(header_bytes_of(minor)) +
                               " bytes; download or copy it again");
  }
  return bytes;
}

void check_layout(const std::string& name, std::size_t header_bytes, std::uint64_t file_bytes,
                  const LasInfo& info) {
  const std::size_t least = header_bytes_of(info.version_minor);
  if (header_bytes < least) {
    throw InputError(name, "says its header has " + std::to_string(header_bytes) +
                               " bytes (byte 94) where LAS 1." +
                               std::to_string(info.version_minor) + " has at least " +
                               std::to_string(least) + "; its writer did not finish, make it anew");
  }
  if (info.point_data_offset < header_bytes) {
    throw InputError(name, "says its points begin at byte " +
                               std::to_string(info.point_data_offset) +
                               " (byte 96), inside its header; make it anew");
  }
  if (info.point_data_offset > file_bytes) {
    throw InputError(
        name, "ends after " + std::to_string(file_bytes) + " bytes, before its points at byte " +
                  std::to_string(info.point_data_offset) + "; download or copy it again");
  }
  if (info.point_format > 10) {
    throw InputError(name, "has point format " + std::to_string(info.point_format) +
                               " (byte 104); formats 0 to 10 can be read");
  }
  if (info.record_bytes < las_base_record_bytes(info.point_format)) {
    throw InputError(name, "says its records have " + std::to_string(info.record_bytes) +
                               " bytes (byte 105) where point format " +
                               std::to_string(info.point_format) + " needs " +
                               std::to_string(las_base_record_bytes(info.point_format)) +
                               "; make it anew");
  }
}

void check_scale(const std::string& name, char axis, double scale, double offset) {
  if (!(scale >= kSmallestScale && scale <= kLargestScale)) {
    throw InputError(name, std::string("has the scale ") + number(scale) + " for " + axis +
                               " in its header (byte 131), so its coordinates mean nothing; a "
                               "positive number such as 0.01 is expected, make it anew");
  }
  if (!std::isfinite(offset)) {
    throw InputError(name, std::string("has the offset ") + number(offset) + " for " + axis +
                               " in its header (byte 155), so its coordinates mean nothing; make "
                               "it anew");
  }
}

Vec3d load_vec(const std::vector<std::uint8_t>& bytes, std::size_t offset) {
  return {load_le<double>(bytes, offset), load_le<double>(bytes, offset + 8),
          load_le<double>(bytes, offset + 16)};
}

void load_counts(const std::vector<std::uint8_t>& bytes, LasInfo& info) {
  info.point_count = load_le<std::uint32_t>(bytes, 107);
  for (std::size_t i = 0; i < 5; ++i) {
    info.points_by_return[i] = load_le<std::uint32_t>(bytes, 111 + 4 * i);
  }
  if (info.version_minor < 4) return;
  const auto extended = load_le<std::uint64_t>(bytes, 247);
  if (extended == 0) return;  // some writers of 1.4 fill the old fields only
  if (info.point_count != 0 && info.point_count != extended) {
    info.warnings.push_back("the header's two point counts disagree (" +
                            std::to_string(info.point_count) + " at byte 107, " +
                            std::to_string(extended) + " at byte 247); the second is used");
  }
  info.point_count = extended;
  for (std::size_t i = 0; i < 15; ++i) {
    info.points_by_return[i] = load_le<std::uint64_t>(bytes, 255 + 8 * i);
  }
}

void load_bounds(const std::vector<std::uint8_t>& bytes, LasInfo& info) {
  const auto value = [&](std::size_t i) { return load_le<double>(bytes, 179 + 8 * i); };
  info.bounds.max = {value(0), value(2), value(4)};
  info.bounds.min = {value(1), value(3), value(5)};
  const bool finite = std::isfinite(info.bounds.min.x + info.bounds.min.y + info.bounds.min.z +
                                    info.bounds.max.x + info.bounds.max.y + info.bounds.max.z);
  if (info.point_count > 0 && (!finite || info.bounds.empty())) {
    info.warnings.emplace_back(
        "the header's bounds are not finite, or their minimum is above their "
        "maximum");
  }
}

LasContainer container_of(const LasInfo& info, bool marked_compressed, const std::string& name) {
  const bool has_laszip_record = find_vlr(info, "laszip encoded", 22204) != nullptr;
  if (marked_compressed && !has_laszip_record) {
    throw InputError(name,
                     "is marked as compressed (byte 104) but has no LASzip record before its "
                     "points; download it again or make it anew");
  }
  if (!has_laszip_record) return LasContainer::kLas;
  const LasVlr& first = info.vlrs.front();
  const bool is_copc = first.user_id == "copc" && first.record_id == 1;
  return is_copc ? LasContainer::kCopc : LasContainer::kLaz;
}

GpsTimeType gps_time_type_of(const LasInfo& info) {
  if (info.point_format == 0 || info.point_format == 2) return GpsTimeType::kNone;
  return (info.global_encoding & kAdjustedTimeBit) != 0 ? GpsTimeType::kAdjustedStandard
                                                        : GpsTimeType::kWeekSeconds;
}

/// The fields of the header as they stand there.
LasInfo load_fields(const std::vector<std::uint8_t>& bytes) {
  LasInfo info;
  info.version_minor = bytes[25];
  // LAS 1.0 has a reserved field where later versions have the file's id and the encoding.
  if (info.version_minor > 0) info.file_source_id = load_le<std::uint16_t>(bytes, 4);
  if (info.version_minor > 1) info.global_encoding = load_le<std::uint16_t>(bytes, 6);
  info.system_identifier = load_text(bytes, 26, 32);
  info.generating_software = load_text(bytes, 58, 32);
  info.creation_day = load_le<std::uint16_t>(bytes, 90);
  info.creation_year = load_le<std::uint16_t>(bytes, 92);
  info.point_data_offset = load_le<std::uint32_t>(bytes, 96);
  info.point_format = bytes[104] & 0x3f;  // the upper bits mark compression
  info.record_bytes = load_le<std::uint16_t>(bytes, 105);
  info.scale = load_vec(bytes, 131);
  info.offset = load_vec(bytes, 155);
  load_counts(bytes, info);
  load_bounds(bytes, info);
  info.gps_time_type = gps_time_type_of(info);
  return info;
}

}  // namespace

std::size_t las_base_record_bytes(int point_format) {
  constexpr std::size_t kBytes[11] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
  return point_format >= 0 && point_format <= 10 ? kBytes[point_format] : 0;
}

LasInfo parse_las(ByteSource& source, const std::string& name) {
  const std::vector<std::uint8_t> bytes = read_header(source, name);
  const std::size_t header_bytes = load_le<std::uint16_t>(bytes, 94);
  LasInfo info = load_fields(bytes);
  info.file_bytes = source.size();
  info.point_data_end = source.size();
  check_layout(name, header_bytes, source.size(), info);
  check_scale(name, 'x', info.scale.x, info.offset.x);
  check_scale(name, 'y', info.scale.y, info.offset.y);
  check_scale(name, 'z', info.scale.z, info.offset.z);
  info.extra_stride = info.record_bytes - las_base_record_bytes(info.point_format);

  parse_vlrs(source, name, header_bytes, load_le<std::uint32_t>(bytes, 100), info);
  if (info.version_minor >= 4) {
    parse_evlrs(source, load_le<std::uint64_t>(bytes, 235), load_le<std::uint32_t>(bytes, 243),
                info);
  }
  parse_extra_bytes(info);
  const bool marked_compressed = (bytes[104] & 0x80) != 0;
  info.container = container_of(info, marked_compressed, name);
  return info;
}

}  // namespace cornice
