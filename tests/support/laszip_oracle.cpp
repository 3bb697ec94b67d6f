// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/laszip_oracle.h"

#include <laszip/laszip_api.h>

#include <algorithm>
#include <cstring>

namespace cornice::test {
namespace {

std::string error_of(laszip_POINTER reader) {
  laszip_CHAR* text = nullptr;
  laszip_get_error(reader, &text);
  return text != nullptr ? text : "unknown";
}

std::uint8_t flags_of(const laszip_point_struct& p, bool legacy) {
  unsigned flags = 0;
  if (legacy) {
    if (p.synthetic_flag != 0) flags |= kSynthetic;
    if (p.keypoint_flag != 0) flags |= kKeyPoint;
    if (p.withheld_flag != 0) flags |= kWithheld;
    if (p.classification == 12) flags |= kOverlap;
  } else {
    if ((p.extended_classification_flags & 1) != 0) flags |= kSynthetic;
    if ((p.extended_classification_flags & 2) != 0) flags |= kKeyPoint;
    if ((p.extended_classification_flags & 4) != 0) flags |= kWithheld;
    if ((p.extended_classification_flags & 8) != 0) flags |= kOverlap;
  }
  if (p.scan_direction_flag != 0) flags |= kScanDirection;
  if (p.edge_of_flight_line != 0) flags |= kEdgeOfFlightLine;
  return static_cast<std::uint8_t>(flags);
}

void add(const laszip_point_struct& p, bool legacy, PointCloud& to) {
  to.exact.push_back({p.X, p.Y, p.Z});
  to.gps_time_s.push_back(p.gps_time);
  to.scan_angle_deg.push_back(legacy ? static_cast<float>(p.scan_angle_rank)
                                     : static_cast<float>(p.extended_scan_angle * 0.006));
  to.return_number.push_back(legacy ? p.return_number : p.extended_return_number);
  to.return_count.push_back(legacy ? p.number_of_returns : p.extended_number_of_returns);
  to.classification.push_back(legacy ? p.classification : p.extended_classification);
  to.flags.push_back(flags_of(p, legacy));
  to.point_source_id.push_back(p.point_source_ID);
  to.scanner_channel.push_back(legacy ? std::uint8_t{0} : p.extended_scanner_channel);
  to.user_data.push_back(p.user_data);
  to.intensity.push_back(p.intensity);
  to.rgb.push_back({p.rgb[0], p.rgb[1], p.rgb[2]});
  to.nir.push_back(p.rgb[3]);
  std::array<std::uint8_t, 29> packet{};
  std::memcpy(packet.data(), p.wave_packet, packet.size());
  to.wave_packet.push_back(packet);
  to.extra_bytes.insert(to.extra_bytes.end(), p.extra_bytes, p.extra_bytes + p.num_extra_bytes);
}

}  // namespace

OracleCloud read_all_with_laszip(const std::filesystem::path& path) {
  OracleCloud result;
  laszip_POINTER reader = nullptr;
  laszip_create(&reader);
  laszip_BOOL compressed = 0;
  if (laszip_open_reader(reader, path.c_str(), &compressed) != 0) {
    result.problem = error_of(reader);
    laszip_destroy(reader);
    return result;
  }
  laszip_header_struct* header = nullptr;
  laszip_point_struct* point = nullptr;
  laszip_get_header_pointer(reader, &header);
  laszip_get_point_pointer(reader, &point);
  laszip_I64 count = 0;
  laszip_get_point_count(reader, &count);
  const std::uint64_t total = header->number_of_point_records != 0
                                  ? header->number_of_point_records
                                  : header->extended_number_of_point_records;
  const bool legacy = header->point_data_format < 6;
  result.points.extra_stride = static_cast<std::size_t>(std::max(point->num_extra_bytes, 0));
  for (std::uint64_t i = 0; i < total; ++i) {
    if (laszip_read_point(reader) != 0) {
      result.problem = error_of(reader);
      break;
    }
    add(*point, legacy, result.points);
  }
  laszip_close_reader(reader);
  laszip_destroy(reader);
  return result;
}

std::vector<std::filesystem::path> point_files_below(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  if (!std::filesystem::exists(folder)) return files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".las" || extension == ".laz") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace cornice::test
