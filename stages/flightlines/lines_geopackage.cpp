// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <string>
#include <vector>

#include "core/geo/globe.h"
#include "core/io/geopackage.h"
#include "stages/flightlines/lines_fields.h"
#include "stages/flightlines/lines_output.h"

namespace cornice::flightlines {
namespace {

std::int64_t whole(std::uint64_t value) { return static_cast<std::int64_t>(value); }

Fields row_of(const LineEstimate& e, const Globe& globe) {
  const FlightLine& line = e.line;
  std::string remarks;
  for (const std::string& remark : e.remarks) remarks += (remarks.empty() ? "" : "; ") + remark;
  GlobePosition first, last;
  if (!line.nodes.empty()) {
    first = globe.at(line.nodes.front().position).value_or(GlobePosition{});
    last = globe.at(line.nodes.back().position).value_or(GlobePosition{});
  }
  const Fields on_globe{{"convergence_deg", 0.5 * (first.convergence_deg + last.convergence_deg)},
                        {"first_latitude_deg", first.latitude_deg},
                        {"first_longitude_deg", first.longitude_deg},
                        {"last_latitude_deg", last.latitude_deg},
                        {"last_longitude_deg", last.longitude_deg}};
  Fields row = line_fields(e);
  // Behind the azimuths, where whoever reads the table looks for them.
  const auto behind = std::find_if(
      row.begin(), row.end(), [](const Field& field) { return field.name == "scan_angle_sign"; });
  row.insert(behind, on_globe.begin(), on_globe.end());
  row.push_back({"remarks", remarks});
  return row;
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
  package.begin_layer("lines", GeometryKind::kLineStringZM, row_of({}, globe));
  for (const LineEstimate& estimate : survey.lines)
    package.add(row_of(estimate, globe), path_of(estimate.line));
  package.begin_layer("nodes", GeometryKind::kPointZM, node_fields({}, {}));
  for (const LineEstimate& estimate : survey.lines)
    for (const TrajectoryNode& node : estimate.line.nodes)
      package.add(node_fields(estimate.line, node), {point_of(node)});
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
