// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/geo/crs.h"
#include "core/io/geopackage.h"
#include "stages/simulate/truth.h"

namespace cornice::simulate {
namespace {

using nlohmann::ordered_json;

double right_of(double heading_deg) { return std::fmod(heading_deg + 90.0, 360.0); }

/// Fields of a line in the order of docs/formats/flight_lines.md, then those of truth alone.
ordered_json fields_of(const LineTruth& truth, const LinesHeader& header) {
  const SurveyLine& line = truth.line;
  const double last = truth.tally.last_time_s < truth.tally.first_time_s
                          ? truth.tally.last_time_s + kWeekS
                          : truth.tally.last_time_s;
  return {{"id", line.id},
          {"point_source_id", line.point_source_id},
          {"scanner_channel", line.user_data != 0 ? line.user_data : line.recorded_channel},
          {"channel_in_user_data", line.user_data != 0},
          {"has_time", true},
          {"first_time_s", truth.tally.first_time_s},
          {"last_time_s", last},
          {"along_azimuth_deg", truth.course_deg},
          {"across_azimuth_deg", right_of(truth.heading_deg)},
          {"across_standard_error_deg", 0.0},
          {"scan_angle_sign", line.angle_sign},
          {"beam_source", "trajectory"},
          {"beam_reason", ""},
          {"pass", line.pass + 1},
          {"channel", line.channel},
          {"cross_line", truth.is_cross_line},
          {"heading_deg", truth.heading_deg},
          {"speed_ms", truth.speed_ms},
          {"height_m", truth.height_m},
          {"points", truth.tally.points},
          {"lowest_angle_deg", truth.tally.lowest_angle_deg},
          {"highest_angle_deg", truth.tally.highest_angle_deg},
          {"offset_x_m", line.offset.x},
          {"offset_y_m", line.offset.y},
          {"offset_z_m", line.offset.z},
          {"scanner", header.scanner},
          {"tilt_deg", header.tilt_deg[static_cast<std::size_t>(line.channel)]},
          {"field_of_view_deg", header.field_of_view_deg},
          {"pulse_rate", header.pulse_rate}};
}

Fields package_fields(const ordered_json& object) {
  Fields fields;
  for (const auto& [name, value] : object.items()) {
    if (value.is_string())
      fields.push_back({name, value.get<std::string>()});
    else if (value.is_number_float())
      fields.push_back({name, value.get<double>()});
    else if (value.is_boolean())
      fields.push_back({name, std::int64_t{value.get<bool>()}});
    else
      fields.push_back({name, value.get<std::int64_t>()});
  }
  return fields;
}

GeometryPoint point_of(const LineTruth::Node& node) { return {node.position, node.time_s}; }

void add_lines(GeoPackage& package, const std::vector<LineTruth>& lines,
               const LinesHeader& header) {
  const Fields sample = lines.empty() ? Fields{} : package_fields(fields_of(lines.front(), header));
  package.begin_layer("lines", GeometryKind::kLineStringZM, sample);
  for (const LineTruth& line : lines) {
    std::vector<GeometryPoint> path;
    for (const LineTruth::Node& node : line.nodes) path.push_back(point_of(node));
    package.add(package_fields(fields_of(line, header)), path);
  }
}

void add_nodes(GeoPackage& package, const std::vector<LineTruth>& lines) {
  const auto fields = [](int line, double time) {
    return Fields{{"line", std::int64_t{line}}, {"gps_time_s", time}, {"error_x_m", 0.0},
                  {"error_y_m", 0.0},           {"error_z_m", 0.0},   {"bridged", std::int64_t{0}}};
  };
  package.begin_layer("nodes", GeometryKind::kPointZ, fields(0, 0.0));
  for (const LineTruth& line : lines)
    for (const LineTruth::Node& node : line.nodes)
      package.add(fields(line.line.id, node.time_s), {point_of(node)});
}

}  // namespace

void write_lines_json(const std::filesystem::path& path, const std::vector<LineTruth>& lines,
                      const LinesHeader& header) {
  ordered_json document{{"format", "cornice flight lines"},
                        {"version", 1},
                        {"crs", header.crs_text},
                        {"lines", ordered_json::array()}};
  for (const LineTruth& line : lines) {
    ordered_json object = fields_of(line, header);
    ordered_json& nodes = object["nodes"] = ordered_json::array();
    for (const LineTruth::Node& node : line.nodes)
      nodes.push_back(
          {node.time_s, node.position.x, node.position.y, node.position.z, 0.0, 0.0, 0.0, 0});
    document["lines"].push_back(std::move(object));
  }
  write_file_atomically(path, document.dump() + "\n");
}

void write_lines_geopackage(const std::filesystem::path& path, const std::vector<LineTruth>& lines,
                            const LinesHeader& header) {
  GeoPackage package(path, crs_from_text(header.crs_text));
  add_lines(package, lines, header);
  add_nodes(package, lines);
  package.finish();
}

}  // namespace cornice::simulate
