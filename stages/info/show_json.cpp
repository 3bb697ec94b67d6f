// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <nlohmann/json.hpp>

#include "stages/info/show.h"
#include "stages/info/wording.h"

namespace cornice::info {
namespace {

using Json = nlohmann::ordered_json;

template <class T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json crs_json(const Crs& crs, const std::string& source) {
  if (crs.empty()) return nullptr;
  Json json = {{"text", crs.text()},
               {"name", crs.name},
               {"horizontal_epsg", crs.horizontal_epsg},
               {"vertical_epsg", crs.vertical_epsg},
               {"has_vertical", crs.has_vertical},
               {"metres_per_unit", crs.metres_per_unit},
               {"vertical_metres_per_unit", crs.vertical_metres_per_unit}};
  if (!source.empty()) json["source"] = source;
  return json;
}

Json box_json(const Box3d& box) {
  if (box.empty()) return nullptr;
  return {{"min", {box.min.x, box.min.y, box.min.z}}, {"max", {box.max.x, box.max.y, box.max.z}}};
}

/// Counts that are not 0, by their index.
template <class Counts>
Json counts_json(const Counts& counts) {
  Json json = Json::object();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] != 0) json[std::to_string(i)] = counts[i];
  }
  return json;
}

const char* time_kind_id(TimeKind kind) {
  switch (kind) {
    case TimeKind::kNone:
      return "none";
    case TimeKind::kWeekSeconds:
      return "week_seconds";
    case TimeKind::kAdjustedStandard:
      return "adjusted_standard";
    case TimeKind::kStandard:
      return "standard";
  }
  return "none";
}

const char* header_time_id(GpsTimeType type) {
  switch (type) {
    case GpsTimeType::kNone:
      return "none";
    case GpsTimeType::kWeekSeconds:
      return "week_seconds";
    case GpsTimeType::kAdjustedStandard:
      return "adjusted_standard";
  }
  return "none";
}

Json time_json(const TimeFacts& time) {
  Json json = {{"has_field", time.has_field},
               {"header_type", header_time_id(time.header_type)},
               {"type", time_kind_id(time.kind)},
               {"min_s", or_null(time.min_s)},
               {"max_s", or_null(time.max_s)},
               {"good_min_s", or_null(time.good_min_s)},
               {"good_max_s", or_null(time.good_max_s)},
               {"good", time.good},
               {"zero", time.zero},
               {"negative", time.negative},
               {"not_finite", time.not_finite},
               {"steps_back", time.steps_back}};
  if (time.good_min_s && !date_of(*time.good_min_s, time.kind).empty()) {
    json["first_date"] = date_of(*time.good_min_s, time.kind);
    json["last_date"] = date_of(*time.good_max_s, time.kind);
  }
  return json;
}

Json line_json(const LineFacts& line) {
  return {{"point_source_id", line.point_source_id},
          {"channel", line.channel},
          {"points", line.points},
          {"first_s", or_null(line.first_s)},
          {"last_s", or_null(line.last_s)},
          {"passes", line.passes}};
}

Json header_json(const LasInfo& header) {
  Json extra = Json::array();
  for (const ExtraByte& attribute : header.extra_bytes) {
    extra.push_back({{"name", attribute.name},
                     {"description", attribute.description},
                     {"data_type", attribute.data_type},
                     {"bytes", attribute.size}});
  }
  return {{"version", "1." + std::to_string(header.version_minor)},
          {"point_format", header.point_format},
          {"record_bytes", header.record_bytes},
          {"zipped", header.zipped},
          {"points", header.point_count},
          {"scale", {header.scale.x, header.scale.y, header.scale.z}},
          {"offset", {header.offset.x, header.offset.y, header.offset.z}},
          {"bounds", box_json(header.bounds)},
          {"global_encoding", header.global_encoding},
          {"file_source_id", header.file_source_id},
          {"system_identifier", header.system_identifier},
          {"generating_software", header.generating_software},
          {"creation_day", header.creation_day},
          {"creation_year", header.creation_year},
          {"extra_bytes", std::move(extra)}};
}

Json facts_json(const PointFacts& facts) {
  Json lines = Json::array();
  for (const LineFacts& line : facts.lines) lines.push_back(line_json(line));
  return {{"header", header_json(facts.header)},
          {"points", facts.readable},
          {"complete", facts.problem.empty()},
          {"bounds", box_json(facts.bounds)},
          {"bounds_agree", facts.bounds_agree},
          {"density_per_m2", or_null(facts.density_per_m2)},
          {"occupied_m2", facts.occupied_m2},
          {"cell_m", facts.cell_m},
          {"crs", crs_json(facts.header.crs, facts.header.crs_source)},
          {"classes", counts_json(facts.classes)},
          {"by_return", counts_json(facts.by_return)},
          {"by_number_of_returns", counts_json(facts.by_return_count)},
          {"by_channel", counts_json(facts.by_channel)},
          {"flags",
           {{"withheld", facts.withheld},
            {"overlap", facts.overlap},
            {"synthetic", facts.synthetic},
            {"key_point", facts.key_points}}},
          {"intensity", {facts.intensity_min, facts.intensity_max}},
          {"gps_time", time_json(facts.time)},
          {"scan_angle",
           {{"min_deg", or_null(facts.angle.min_deg)},
            {"max_deg", or_null(facts.angle.max_deg)},
            {"distinct", facts.angle.distinct},
            {"unit_deg", facts.angle.unit_deg},
            {"whole_degrees", facts.angle.whole_degrees}}},
          {"lines", std::move(lines)},
          {"lines_complete", facts.lines_complete},
          {"copies", facts.copies},
          {"copies_estimated", facts.copies_estimated}};
}

Json facts_json(const PlyFacts& facts) {
  Json elements = Json::array();
  for (const PlyInfo::Element& element : facts.header.elements) {
    Json properties = Json::array();
    for (const auto& [name, type] : element.properties) {
      properties.push_back({{"name", name}, {"type", type}});
    }
    elements.push_back(
        {{"name", element.name}, {"count", element.count}, {"properties", std::move(properties)}});
  }
  const Vec3d origin = facts.header.origin;
  return {{"encoding", facts.header.format},  {"elements", std::move(elements)},
          {"vertices", facts.vertices},       {"faces", facts.faces},
          {"has_normals", facts.has_normals}, {"origin", {origin.x, origin.y, origin.z}},
          {"bounds", box_json(facts.bounds)}, {"crs", crs_json(facts.crs, "")}};
}

Json facts_json(const RasterFacts& facts) {
  Json bounds = nullptr;
  if (facts.has_position) {
    bounds = {{"min", {facts.bounds.min_x, facts.bounds.min_y}},
              {"max", {facts.bounds.max_x, facts.bounds.max_y}}};
  }
  return {{"layout", facts.layout},
          {"compression", facts.compression},
          {"width", facts.width},
          {"height", facts.height},
          {"bands", facts.bands},
          {"overviews", facts.overviews},
          {"type", facts.type},
          {"step", {facts.step_x, std::abs(facts.step_y)}},
          {"bounds", bounds},
          {"crs", crs_json(facts.crs, "")},
          {"no_data", or_null(facts.no_data)},
          {"valid", facts.valid},
          {"min", or_null(facts.min)},
          {"max", or_null(facts.max)}};
}

Json outcome_json(const Outcome& outcome) {
  Json json = {{"path", outcome.path.string()}};
  if (!outcome.facts) {
    json["error"] = outcome.error;
    return json;
  }
  const FileFacts& file = *outcome.facts;
  json["kind"] = kind_name(file);
  json["bytes"] = file.bytes;
  json.update(std::visit([](const auto& facts) { return facts_json(facts); }, file.facts));
  json["defects"] = Json::array();
  for (const Defect& defect : file.defects) {
    json["defects"].push_back({{"id", defect.id}, {"text", defect.text}});
  }
  return json;
}

}  // namespace

std::string json_text(const std::vector<Outcome>& outcomes) {
  Json files = Json::array();
  for (const Outcome& outcome : outcomes) files.push_back(outcome_json(outcome));
  const Json document = {{"format", "cornice info 1"}, {"files", std::move(files)}};
  // Names in files may hold any bytes; what is no UTF-8 is replaced rather than refused.
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace cornice::info
