// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/las_head_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/base/error.h"
#include "core/io/las_header.h"
#include "core/io/little_endian.h"

namespace cornice {
namespace {

constexpr std::array<int, 5> kHighestFormat = {1, 1, 3, 5, 10};  // by minor version
constexpr std::array<std::size_t, 11> kTypeBytes = {0, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
constexpr std::size_t kExtraBytesRecord = 192;
constexpr std::size_t kLongestVlr = 65535;
constexpr std::uint16_t kGpsTimeBit = 1;
constexpr std::uint16_t kWktBit = 16;

/// Appends little-endian numbers and fixed-width text.
class Bytes {
 public:
  template <class T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    append_le(out, value);
  }
  void put_text(std::string_view text, std::size_t width) {
    const std::size_t kept = std::min(text.size(), width);
    out.insert(out.end(), text.begin(), text.begin() + static_cast<std::ptrdiff_t>(kept));
    out.resize(out.size() + width - kept, 0);
  }
  void put_raw(const std::vector<std::uint8_t>& raw) {
    out.insert(out.end(), raw.begin(), raw.end());
  }
  std::vector<std::uint8_t> out;
};

std::size_t header_bytes(int version_minor) {
  return version_minor >= 4 ? 375 : version_minor == 3 ? 235 : 227;
}

bool has_gps_time(int format) { return format != 0 && format != 2; }

LasVlr projection_record(std::uint16_t id, const char* description,
                         std::vector<std::uint8_t> data) {
  return {"LASF_Projection", id, description, std::move(data), false};
}

void add_crs_records(const LasWriteOptions& options, std::vector<LasVlr>& records) {
  if (options.crs.empty()) return;
  if (options.version_minor >= 4) {
    std::vector<std::uint8_t> wkt(options.crs.wkt.begin(), options.crs.wkt.end());
    wkt.push_back(0);
    records.push_back(projection_record(2112, "OGC WKT coordinate system", std::move(wkt)));
    return;
  }
  const GeotiffRecords geotiff = geotiff_records_from_crs(options.crs);
  if (geotiff.keys.empty()) {
    throw UsageError("crs", "'" + options.crs.name +
                                "' cannot be said in GeoTIFF keys; write LAS 1.4, which holds WKT");
  }
  records.push_back(projection_record(34735, "GeoTIFF GeoKeyDirectoryTag", geotiff.keys));
  if (!geotiff.doubles.empty()) {
    records.push_back(projection_record(34736, "GeoTIFF GeoDoubleParamsTag", geotiff.doubles));
  }
  if (!geotiff.ascii.empty()) {
    records.push_back(projection_record(34737, "GeoTIFF GeoAsciiParamsTag",
                                        {geotiff.ascii.begin(), geotiff.ascii.end()}));
  }
}

/// no_data stands as the widest type of the attribute's kind.
void put_no_data(Bytes& bytes, const ExtraByte& attribute) {
  const double value = attribute.no_data.value_or(0.0);
  const bool is_float = attribute.data_type == 9 || attribute.data_type == 10;
  const bool is_signed = attribute.data_type % 2 == 0;
  if (is_float) {
    bytes.put(value);
  } else if (is_signed) {
    bytes.put(static_cast<std::int64_t>(value));
  } else {
    bytes.put(static_cast<std::uint64_t>(value));
  }
  bytes.put_text("", 16);  // two more values, of types that 1.4 R15 no longer has
}

/// Table 24 of LAS 1.4 R15: 192 bytes an attribute.
LasVlr extra_bytes_record(const std::vector<ExtraByte>& attributes) {
  Bytes bytes;
  for (const ExtraByte& attribute : attributes) {
    const bool is_scaled = attribute.scale != 1.0 || attribute.offset_value != 0.0;
    std::uint8_t options =
        static_cast<std::uint8_t>((attribute.no_data ? 1 : 0) | (is_scaled ? 8 | 16 : 0));
    if (attribute.data_type == 0) options = static_cast<std::uint8_t>(attribute.size);
    bytes.put(std::uint16_t{0});
    bytes.put(attribute.data_type);
    bytes.put(options);
    bytes.put_text(attribute.name, 32);
    bytes.put(std::uint32_t{0});
    put_no_data(bytes, attribute);
    bytes.put_text("", 48);  // minimum and maximum: not known before the points
    bytes.put(is_scaled ? attribute.scale : 0.0);
    bytes.put_text("", 16);
    bytes.put(is_scaled ? attribute.offset_value : 0.0);
    bytes.put_text("", 16);
    bytes.put_text(attribute.description, 32);
  }
  return {"LASF_Spec", 4, "Extra bytes", std::move(bytes.out), false};
}

/// True for records that the writer makes itself.
bool is_made_here(const LasVlr& record, const LasWriteOptions& options) {
  if (record.user_id == "LASF_Projection") return !options.crs.empty();
  if (record.user_id == "LASF_Spec") return record.record_id == 4;
  return record.user_id == "laszip encoded" || record.user_id == "copc";
}

[[noreturn]] void refuse(const std::string& option, const std::string& problem) {
  throw UsageError(option, problem);
}

void check_extra_bytes(const std::vector<ExtraByte>& attributes) {
  std::size_t offset = 0;
  for (const ExtraByte& attribute : attributes) {
    const std::string what = "extra bytes '" + attribute.name + "'";
    if (attribute.data_type > 30) refuse(what, "have no known type; 0 to 30 are");
    const std::size_t size = extra_byte_size(attribute);
    if (size == 0 || size > 255) refuse(what, "take 1 to 255 bytes, not " + std::to_string(size));
    if (attribute.size != 0 && attribute.size != size) {
      refuse(what, "are of a type of " + std::to_string(size) + " bytes, not " +
                       std::to_string(attribute.size));
    }
    if (attribute.offset != 0 && attribute.offset != offset) {
      refuse(what, "stand at byte " + std::to_string(offset) + " of their record, not at " +
                       std::to_string(attribute.offset));
    }
    if (attribute.name.size() > 32) refuse(what, "have a name of more than 32 characters");
    offset += size;
  }
  if (offset * kExtraBytesRecord > 0 && attributes.size() * kExtraBytesRecord > kLongestVlr) {
    refuse("extra bytes", "of more than 341 attributes do not fit one record");
  }
}

}  // namespace

std::size_t extra_byte_size(const ExtraByte& attribute) {
  if (attribute.data_type == 0) return attribute.size;
  // Types 11 to 30 of earlier editions are pairs and triples of 1 to 10.
  const std::size_t base = (attribute.data_type - 1u) % 10u + 1u;
  return kTypeBytes[base] * ((attribute.data_type - 1u) / 10u + 1u);
}

std::size_t extra_stride_of(const std::vector<ExtraByte>& extra_bytes) {
  std::size_t stride = 0;
  for (const ExtraByte& attribute : extra_bytes) stride += extra_byte_size(attribute);
  return stride;
}

void check_las_write_options(const LasWriteOptions& options) {
  const int minor = options.version_minor;
  if (minor < 0 || minor > 4) {
    refuse("LAS version", "1." + std::to_string(minor) + " does not exist; 1.0 to 1.4 do");
  }
  const int highest = kHighestFormat[static_cast<std::size_t>(minor)];
  if (options.point_format < 0 || options.point_format > highest) {
    refuse("point format", std::to_string(options.point_format) + " is not in LAS 1." +
                               std::to_string(minor) + "; 0 to " + std::to_string(highest) +
                               " are");
  }
  for (const double scale : {options.scale.x, options.scale.y, options.scale.z}) {
    if (!(scale > 0.0) || !std::isfinite(scale)) {
      refuse("scale", std::to_string(scale) + " is not a positive number");
    }
  }
  for (const double offset : {options.offset.x, options.offset.y, options.offset.z}) {
    if (!std::isfinite(offset)) refuse("offset", "is not a finite number");
  }
  if (options.chunk_points == 0) refuse("chunk", "of 0 points; 50000 is usual");
  check_extra_bytes(options.extra_bytes);
  const std::size_t record =
      las_base_record_bytes(options.point_format) + extra_stride_of(options.extra_bytes);
  if (record > 65535) refuse("extra bytes", "make records longer than 65535 bytes");
}

LasHead::LasHead(const LasWriteOptions& options, std::vector<LasVlr> leading,
                 std::vector<LasVlr> trailing)
    : options_(options), records_(std::move(leading)) {
  add_crs_records(options, records_);
  if (!options.extra_bytes.empty()) records_.push_back(extra_bytes_record(options.extra_bytes));
  for (const LasVlr& record : options.vlrs) {
    if (is_made_here(record, options)) continue;
    const bool is_long = record.data.size() > kLongestVlr;
    if (options.version_minor < 4 && is_long) {
      refuse("record '" + record.user_id + "'", "of more than 65535 bytes needs LAS 1.4");
    }
    const bool at_end = options.version_minor >= 4 && (record.extended || is_long);
    (at_end ? extended_ : records_).push_back(record);
  }
  records_.insert(records_.end(), trailing.begin(), trailing.end());
  options_.vlrs.clear();
  size_ = header_bytes(options.version_minor) + (options.version_minor == 0 ? 2 : 0);
  for (const LasVlr& record : records_) {
    if (record.data.size() > kLongestVlr) {
      refuse("record '" + record.user_id + "'", "is longer than 65535 bytes");
    }
    size_ += kVlrHeaderBytes + record.data.size();
  }
}

std::vector<std::uint8_t> LasHead::extended_bytes() const {
  Bytes bytes;
  for (const LasVlr& record : extended_) {
    bytes.put(std::uint16_t{0});
    bytes.put_text(record.user_id, 16);
    bytes.put(record.record_id);
    bytes.put(std::uint64_t{record.data.size()});
    bytes.put_text(record.description, 32);
    bytes.put_raw(record.data);
  }
  static_assert(2 + 16 + 2 + 8 + 32 == kEvlrHeaderBytes);
  return std::move(bytes.out);
}

std::vector<std::uint8_t> LasHead::bytes(const LasTally& tally, std::uint64_t extended_at) const {
  return bytes(tally, extended_at, {});
}

std::vector<std::uint8_t> LasHead::bytes(const LasTally& tally, std::uint64_t extended_at,
                                         const std::vector<std::uint8_t>& replaced) const {
  const int minor = options_.version_minor;
  const int format = options_.point_format;
  const std::size_t record = las_base_record_bytes(format) + extra_stride_of(options_.extra_bytes);
  const bool has_legacy_counts = format < 6 && tally.points <= 0xffffffffu;
  const bool has_wkt = minor >= 4 && (format >= 6 || !options_.crs.empty());
  const bool adjusted =
      options_.gps_time_type == GpsTimeType::kAdjustedStandard && has_gps_time(format);
  const auto encoding = static_cast<std::uint16_t>((adjusted && minor >= 2 ? kGpsTimeBit : 0) |
                                                   (has_wkt ? kWktBit : 0));
  Bytes bytes;
  bytes.put_text("LASF", 4);
  bytes.put(minor >= 1 ? options_.file_source_id : std::uint16_t{0});
  bytes.put(encoding);
  bytes.put_text("", 16);  // project id
  bytes.put(std::uint8_t{1});
  bytes.put(static_cast<std::uint8_t>(minor));
  bytes.put_text(options_.system_identifier, 32);
  bytes.put_text(options_.generating_software, 32);
  bytes.put(static_cast<std::uint16_t>(options_.creation_day));
  bytes.put(static_cast<std::uint16_t>(options_.creation_year));
  bytes.put(static_cast<std::uint16_t>(header_bytes(minor)));
  bytes.put(static_cast<std::uint32_t>(size_));
  bytes.put(static_cast<std::uint32_t>(records_.size()));
  // LASzip marks compressed points by the highest bit.
  bytes.put(static_cast<std::uint8_t>(format | (options_.compress ? 128 : 0)));
  bytes.put(static_cast<std::uint16_t>(record));
  bytes.put(has_legacy_counts ? static_cast<std::uint32_t>(tally.points) : 0u);
  for (std::size_t i = 1; i <= 5; ++i) {
    bytes.put(has_legacy_counts ? static_cast<std::uint32_t>(tally.by_return[i]) : 0u);
  }
  for (double scale : {options_.scale.x, options_.scale.y, options_.scale.z}) bytes.put(scale);
  for (double offset : {options_.offset.x, options_.offset.y, options_.offset.z}) {
    bytes.put(offset);
  }
  const auto put_range = [&](std::int32_t max, std::int32_t min, double scale, double offset) {
    bytes.put(tally.points == 0 ? 0.0 : max * scale + offset);
    bytes.put(tally.points == 0 ? 0.0 : min * scale + offset);
  };
  put_range(tally.max.x, tally.min.x, options_.scale.x, options_.offset.x);
  put_range(tally.max.y, tally.min.y, options_.scale.y, options_.offset.y);
  put_range(tally.max.z, tally.min.z, options_.scale.z, options_.offset.z);
  if (minor >= 3) bytes.put(std::uint64_t{0});  // waveform packets: never in this file
  if (minor >= 4) {
    bytes.put(extended_.empty() ? std::uint64_t{0} : extended_at);
    bytes.put(static_cast<std::uint32_t>(extended_.size()));
    bytes.put(tally.points);
    for (std::size_t i = 1; i <= 15; ++i) bytes.put(tally.by_return[i]);
  }
  for (std::size_t i = 0; i < records_.size(); ++i) {
    const LasVlr& vlr = records_[i];
    const std::vector<std::uint8_t>& data = i == 0 && !replaced.empty() ? replaced : vlr.data;
    bytes.put(minor == 0 ? std::uint16_t{0xAABB} : std::uint16_t{0});
    bytes.put_text(vlr.user_id, 16);
    bytes.put(vlr.record_id);
    bytes.put(static_cast<std::uint16_t>(data.size()));
    bytes.put_text(vlr.description, 32);
    bytes.put_raw(data);
  }
  if (minor == 0) bytes.put(std::uint16_t{0xCCDD});  // where the points start, in 1.0 only
  return std::move(bytes.out);
}

}  // namespace cornice
