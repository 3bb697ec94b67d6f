// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/property/las_writer/laszip_oracle.h"

#include <laszip/laszip_api.h>

#include <cstring>
#include <stdexcept>

#include "core/points/point_cloud.h"

namespace cornice::test {
namespace {

class Reader {
 public:
  Reader(const std::filesystem::path& path, bool with_index) {
    check(laszip_create(&handle_));
    if (with_index) check(laszip_exploit_spatial_index(handle_, 1));
    laszip_BOOL compressed = 0;
    check(laszip_open_reader(handle_, path.c_str(), &compressed));
    is_compressed = compressed != 0;
    check(laszip_get_header_pointer(handle_, &header));
    check(laszip_get_point_pointer(handle_, &point));
  }
  ~Reader() {
    laszip_close_reader(handle_);
    laszip_destroy(handle_);
  }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  void check(laszip_I32 failure) const {
    if (failure == 0) return;
    laszip_CHAR* text = nullptr;
    laszip_get_error(handle_, &text);
    throw std::runtime_error(text != nullptr ? text : "LASzip failed");
  }
  laszip_POINTER handle() const { return handle_; }

  laszip_header_struct* header = nullptr;
  laszip_point_struct* point = nullptr;
  bool is_compressed = false;

 private:
  laszip_POINTER handle_ = nullptr;
};

OraclePoint point_of(const Reader& reader) {
  const laszip_point_struct& p = *reader.point;
  const bool extended = reader.header->point_data_format >= 6;
  const int format = reader.header->point_data_format;
  OraclePoint out{};
  out.x = p.X, out.y = p.Y, out.z = p.Z;
  out.intensity = p.intensity;
  out.return_number = extended ? p.extended_return_number : p.return_number;
  out.return_count = extended ? p.extended_number_of_returns : p.number_of_returns;
  out.classification = extended ? p.extended_classification : p.classification;
  out.flags = (p.synthetic_flag ? kSynthetic : 0) | (p.keypoint_flag ? kKeyPoint : 0) |
              (p.withheld_flag ? kWithheld : 0) | (p.scan_direction_flag ? kScanDirection : 0) |
              (p.edge_of_flight_line ? kEdgeOfFlightLine : 0);
  if (extended) {
    out.flags |= (p.extended_classification_flags & 8) != 0 ? kOverlap : 0;
    out.channel = p.extended_scanner_channel;
  }
  out.scan_angle = extended ? p.extended_scan_angle : p.scan_angle_rank;
  out.user_data = p.user_data;
  out.point_source_id = p.point_source_ID;
  if (format != 0 && format != 2) out.gps_time = p.gps_time;
  if (format == 2 || format == 3 || format == 5 || format == 7 || format == 8 || format == 10) {
    for (std::size_t c = 0; c < 3; ++c) out.rgb[c] = p.rgb[c];
    if (format == 8 || format == 10) out.rgb[3] = p.rgb[3];
  }
  if (format == 4 || format == 5 || format == 9 || format == 10) {
    std::memcpy(out.wave_packet.data(), p.wave_packet, out.wave_packet.size());
  }
  out.extra_bytes.assign(p.extra_bytes, p.extra_bytes + p.num_extra_bytes);
  return out;
}

void copy_header(const Reader& reader, OracleFile& file) {
  const laszip_header_struct& h = *reader.header;
  file.version_minor = h.version_minor;
  file.point_format = h.point_data_format;
  file.record_bytes = h.point_data_record_length;
  file.global_encoding = h.global_encoding;
  file.compressed = reader.is_compressed;
  file.legacy_count = h.number_of_point_records;
  for (std::size_t i = 0; i < 5; ++i) file.legacy_by_return[i] = h.number_of_points_by_return[i];
  file.extended_count = h.extended_number_of_point_records;
  for (std::size_t i = 0; i < 15; ++i) {
    file.extended_by_return[i] = h.extended_number_of_points_by_return[i];
  }
  file.bounds = {h.min_x, h.max_x, h.min_y, h.max_y, h.min_z, h.max_z};
  for (std::size_t i = 0; i < h.number_of_variable_length_records; ++i) {
    const laszip_vlr_struct& vlr = h.vlrs[i];
    file.vlrs.push_back(
        {vlr.user_id, vlr.record_id, {vlr.data, vlr.data + vlr.record_length_after_header}});
  }
}

}  // namespace

OracleFile read_with_laszip(const std::filesystem::path& path) {
  const Reader reader(path, false);
  OracleFile file;
  copy_header(reader, file);
  const std::uint64_t count = file.legacy_count != 0 ? file.legacy_count : file.extended_count;
  for (std::uint64_t i = 0; i < count; ++i) {
    reader.check(laszip_read_point(reader.handle()));
    file.points.push_back(point_of(reader));
  }
  return file;
}

std::vector<OraclePoint> read_window_with_laszip(const std::filesystem::path& path,
                                                 std::array<double, 4> min_xy_max_xy) {
  const Reader reader(path, true);
  laszip_BOOL is_indexed = 0;
  laszip_BOOL is_appended = 0;
  reader.check(laszip_has_spatial_index(reader.handle(), &is_indexed, &is_appended));
  if (is_indexed == 0) throw std::runtime_error("LASzip finds no spatial index");
  laszip_BOOL is_empty = 0;
  const auto& [min_x, min_y, max_x, max_y] = min_xy_max_xy;
  reader.check(laszip_inside_rectangle(reader.handle(), min_x, min_y, max_x, max_y, &is_empty));
  std::vector<OraclePoint> points;
  laszip_BOOL is_done = is_empty;
  while (is_done == 0) {
    reader.check(laszip_read_inside_point(reader.handle(), &is_done));
    if (is_done == 0) points.push_back(point_of(reader));
  }
  return points;
}

}  // namespace cornice::test
