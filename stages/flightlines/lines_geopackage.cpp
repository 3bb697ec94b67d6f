// SPDX-License-Identifier: GPL-3.0-or-later
#include <string>
#include <vector>

#include "core/geo/globe.h"
#include "core/io/geopackage.h"
#include "stages/flightlines/lines_output.h"

namespace cornice::flightlines {
namespace {

std::int64_t whole(std::uint64_t value) { return static_cast<std::int64_t>(value); }

Fields line_fields(const LineEstimate& e, const Globe& globe) {
  const FlightLine& line = e.line;
  std::string remarks;
  for (const std::string& remark : e.remarks) remarks += (remarks.empty() ? "" : "; ") + remark;
  GlobePosition first, last;
  if (!line.nodes.empty()) {
    first = globe.at(line.nodes.front().position).value_or(GlobePosition{});
    last = globe.at(line.nodes.back().position).value_or(GlobePosition{});
  }
  return {{"id", std::int64_t(line.id)},
          {"point_source_id", std::int64_t{line.point_source_id}},
          {"scanner_channel", std::int64_t{line.scanner_channel}},
          {"channel_in_user_data", line.channel_in_user_data ? std::int64_t{1} : std::int64_t{0}},
          {"has_time", line.has_time ? std::int64_t{1} : std::int64_t{0}},
          {"first_time_s", line.first_time_s},
          {"last_time_s", line.last_time_s},
          {"along_azimuth_deg", line.along_azimuth_deg},
          {"along_standard_error_deg", e.along_standard_error_deg},
          {"across_azimuth_deg", line.across_azimuth_deg},
          {"across_standard_error_deg", line.across_standard_error_deg},
          {"perpendicular_deg", e.perpendicular_deg},
          {"convergence_deg", 0.5 * (first.convergence_deg + last.convergence_deg)},
          {"first_latitude_deg", first.latitude_deg},
          {"first_longitude_deg", first.longitude_deg},
          {"last_latitude_deg", last.latitude_deg},
          {"last_longitude_deg", last.longitude_deg},
          {"scan_angle_sign", std::int64_t{line.scan_angle_sign}},
          {"sign_from", e.sign_from},
          {"beam_source", std::string(beam_source_name(line.beam_source))},
          {"beam_reason", line.beam_reason},
          {"method", e.method},
          {"points", whole(e.points)},
          {"pulses_used", whole(e.pulses_used)},
          {"pairs_used", whole(e.pairs_used)},
          {"height_m", e.height_m},
          {"speed_ms", e.speed_ms},
          {"min_angle_deg", e.min_angle_deg},
          {"max_angle_deg", e.max_angle_deg},
          {"pulse_rate_hz", e.pulse_rate_hz},
          {"lean_deg", e.lean_deg},
          {"cone_deg", e.cone_deg},
          {"looks", std::int64_t{e.looks}},
          {"angle_offset_deg", e.angle_offset_deg},
          {"angle_residual_deg", e.angle_residual_deg},
          {"scan_residual_deg", e.scan_residual_deg},
          {"pair_residual", e.pair_residual},
          {"position_error_m", e.position_error_m},
          {"height_error_m", e.height_error_m},
          {"bridged_s", e.bridged_s},
          {"remarks", remarks}};
}

GeometryPoint point_of(const TrajectoryNode& node) { return {node.position, node.gps_time_s}; }

std::vector<GeometryPoint> path_of(const FlightLine& line) {
  std::vector<GeometryPoint> points;
  for (const TrajectoryNode& node : line.nodes) points.push_back(point_of(node));
  return points;
}

Fields node_fields(const FlightLine& line, const TrajectoryNode& node) {
  return {{"line", std::int64_t(line.id)},
          {"gps_time_s", node.gps_time_s},
          {"error_x_m", static_cast<double>(node.standard_error_m.x)},
          {"error_y_m", static_cast<double>(node.standard_error_m.y)},
          {"error_z_m", static_cast<double>(node.standard_error_m.z)},
          {"bridged", node.bridged ? std::int64_t{1} : std::int64_t{0}}};
}

void write_layers(GeoPackage& package, const SurveyLines& survey) {
  const Globe globe(survey.crs);
  package.begin_layer("lines", GeometryKind::kLineStringZM, line_fields({}, globe));
  for (const LineEstimate& estimate : survey.lines)
    package.add(line_fields(estimate, globe), path_of(estimate.line));
  package.begin_layer("nodes", GeometryKind::kPointZM, node_fields({}, {}));
  for (const LineEstimate& estimate : survey.lines)
    for (const TrajectoryNode& node : estimate.line.nodes)
      package.add(node_fields(estimate.line, node), {point_of(node)});
  const auto overlap_fields = [](const OverlapPair& pair) {
    return Fields{{"first_line", std::int64_t(pair.first_line)},
                  {"second_line", std::int64_t(pair.second_line)},
                  {"median_dz_m", pair.median_dz_m},
                  {"spread_m", pair.spread_m},
                  {"cells", whole(pair.cells)}};
  };
  package.begin_layer("overlaps", GeometryKind::kNone, overlap_fields({}));
  for (const OverlapPair& pair : survey.overlaps) package.add(overlap_fields(pair));
  package.begin_layer(
      "invalid_pulses", GeometryKind::kNone,
      {{"tile", std::string()}, {"reason", std::string()}, {"points", std::int64_t{0}}});
  for (const TileCounts& tile : survey.tiles)
    for (std::size_t i = 0; i < kInvalidKinds; ++i)
      if (tile.invalid[i] > 0)
        package.add({{"tile", tile.file.filename().string()},
                     {"reason", std::string(invalid_name(static_cast<Invalid>(i)))},
                     {"points", whole(tile.invalid[i])}});
}

}  // namespace

void write_geopackage(const std::filesystem::path& path, const SurveyLines& survey) {
  GeoPackage package(path, survey.crs);
  write_layers(package, survey);
  package.finish();
}

}  // namespace cornice::flightlines
