// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <variant>

#include "core/base/atomic_file.h"
#include "core/geo/globe.h"
#include "stages/flightlines/lines_fields.h"
#include "stages/flightlines/lines_output.h"

namespace cornice::flightlines {
namespace {

using nlohmann::json;

/// Decimal digits that a value is known to: files stay small and readable.
double rounded(double value, double step) { return std::round(value / step) * step; }

json nodes_json(const FlightLine& line) {
  json nodes = json::array();
  for (const TrajectoryNode& node : line.nodes)
    nodes.push_back({node.gps_time_s, node.position.x, node.position.y, node.position.z,
                     node.standard_error_m.x, node.standard_error_m.y, node.standard_error_m.z,
                     node.bridged ? 1 : 0});
  return nodes;
}

json ends_json(const FlightLine& line, const Globe& globe) {
  json ends = json::object();
  if (line.nodes.empty()) return ends;
  const auto first = globe.at(line.nodes.front().position);
  const auto last = globe.at(line.nodes.back().position);
  if (!first || !last) return ends;
  const double convergence = 0.5 * (first->convergence_deg + last->convergence_deg);
  const double azimuth = std::fmod(line.along_azimuth_deg + convergence + 360.0, 360.0);
  ends = {{"first_latitude_deg", first->latitude_deg},
          {"first_longitude_deg", first->longitude_deg},
          {"last_latitude_deg", last->latitude_deg},
          {"last_longitude_deg", last->longitude_deg},
          {"convergence_deg", convergence},
          {"along_true_azimuth_deg", azimuth}};
  return ends;
}

json checks_json(const LineEstimate& estimate) {
  json checks = json::array();
  for (const AcceptCheck& check : estimate.checks)
    checks.push_back({{"name", check.name},
                      {"value", check.value},
                      {"low", check.low},
                      {"high", check.high},
                      {"passed", check.passed}});
  return checks;
}

json object_of(const Fields& fields) {
  json object = json::object();
  for (const Field& field : fields) {
    std::visit([&](const auto& value) { object[field.name] = value; }, field.value);
  }
  return object;
}

json line_json(const LineEstimate& e, const Globe& globe) {
  const FlightLine& line = e.line;
  json object = object_of(line_fields(e));
  object.update(ends_json(line, globe));
  // A GeoPackage has no truth values.
  object["channel_in_user_data"] = line.channel_in_user_data;
  object["has_time"] = line.has_time;
  object["scan_model"] = scan_model_name(e.scan_model);
  object["angle_step_deg"] = e.angle_step_deg;
  object["accept_test"] = checks_json(e);
  object["remarks"] = e.remarks;
  object["nodes"] = nodes_json(line);
  return object;
}

json overlap_json(const OverlapPair& pair) {
  json object = object_of(overlap_fields(pair));
  for (const char* const name : {"median_dz_m", "spread_m"}) {
    object[name] = rounded(object[name].get<double>(), 1e-4);
  }
  return object;
}

json invalid_json(const InvalidCounts& counts) {
  json object = json::object();
  for (std::size_t i = 0; i < kInvalidKinds; ++i)
    object[invalid_name(static_cast<Invalid>(i))] = counts[i];
  return object;
}

std::string format(const char* text, auto... values) {
  char buffer[400];
  std::snprintf(buffer, sizeof buffer, text, values...);
  return buffer;
}

}  // namespace

void write_json(const std::filesystem::path& path, const SurveyLines& survey) {
  const Globe globe(survey.crs);
  json lines = json::array();
  for (const LineEstimate& estimate : survey.lines) lines.push_back(line_json(estimate, globe));
  json overlaps = json::array();
  for (const OverlapPair& pair : survey.overlaps) overlaps.push_back(overlap_json(pair));
  json tiles = json::array();
  for (const TileCounts& tile : survey.tiles)
    tiles.push_back({{"file", tile.file.filename().string()},
                     {"points", tile.points},
                     {"valid_points", tile.valid_points},
                     {"invalid", invalid_json(tile.invalid)},
                     {"problem", tile.problem}});
  const json document = {{"format", "cornice flight lines"},
                         {"version", 1},
                         {"crs", survey.crs.text()},
                         {"points", survey.points},
                         {"valid_points", survey.valid_points},
                         {"invalid_pulses", invalid_json(survey.invalid)},
                         {"overlaps", overlaps},
                         {"tiles", tiles},
                         {"lines", lines}};
  write_file_atomically(path, document.dump(1) + "\n");
}

std::vector<std::string> describe(const SurveyLines& survey) {
  std::vector<std::string> text;
  for (const LineEstimate& e : survey.lines) {
    const FlightLine& line = e.line;
    text.push_back(format(
        "line %u: id %u channel %u, %.3f..%.3f s, %llu points, azimuth %.2f along, %.2f +- %.2f "
        "across, %.0f m above ground, %.1f m/s, angles %.1f..%.1f sign %+d, beams from %s%s%s",
        line.id, unsigned{line.point_source_id}, unsigned{line.scanner_channel}, line.first_time_s,
        line.last_time_s, static_cast<unsigned long long>(e.points), line.along_azimuth_deg,
        line.across_azimuth_deg, line.across_standard_error_deg, e.height_m, e.speed_ms,
        e.min_angle_deg, e.max_angle_deg, line.scan_angle_sign, beam_source_name(line.beam_source),
        line.beam_reason.empty() ? "" : ": ", line.beam_reason.c_str()));
    if (!e.checks.empty()) {
      std::string checks = format("  path by %s, accept test:", e.method.c_str());
      for (const AcceptCheck& c : e.checks)
        checks += format(" %s %.3g %s", c.name.c_str(), c.value, c.passed ? "ok;" : "FAILED;");
      text.push_back(checks);
    }
    for (const std::string& remark : e.remarks) text.push_back("  " + remark);
  }
  for (const OverlapPair& pair : survey.overlaps)
    text.push_back(format("lines %u and %u: height mismatch %+.3f m, spread %.3f m, %llu cells",
                          pair.first_line, pair.second_line, pair.median_dz_m, pair.spread_m,
                          static_cast<unsigned long long>(pair.cells)));
  return text;
}

std::vector<std::string> step_downs(const SurveyLines& survey) {
  std::vector<std::string> text;
  for (const LineEstimate& e : survey.lines) {
    if (e.line.beam_source != BeamSource::kTrajectory)
      text.push_back(format("line %u (id %u): beams are taken %s, not from the sensor's path: %s",
                            e.line.id, unsigned{e.line.point_source_id},
                            e.line.beam_source == BeamSource::kAngles
                                ? "from the recorded scan angles"
                                : "as vertical",
                            e.line.beam_reason.c_str()));
    else if (e.line.scan_angle_sign == 0)
      text.push_back(
          format("line %u (id %u): sign of the scan angle is not known; its path does "
                 "not use it",
                 e.line.id, unsigned{e.line.point_source_id}));
  }
  if (survey.split.timeless_dropped > 0)
    text.push_back(std::to_string(survey.split.timeless_dropped) +
                   " points without GPS time belong to no line");
  if (survey.split.week_rollovers > 0)
    text.push_back("times cross the end of a GPS week; they go on above 604800");
  if (survey.channel_in_user_data)
    text.push_back("user data tells two channels apart; height mismatches are left out");
  if (survey.sample_halvings > 0)
    text.push_back(format("sample of pulses halved %d times to stay within the memory",
                          static_cast<int>(survey.sample_halvings)));
  return text;
}

}  // namespace cornice::flightlines
