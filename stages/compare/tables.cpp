// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/io/geopackage.h"
#include "stages/compare/output.h"

namespace cornice::compare {
namespace {

using Json = nlohmann::ordered_json;

/// Millimetres are enough, and the same text everywhere.
double rounded(double value, double step = 1e-4) { return std::round(value / step) * step; }

std::string text_of(double value, int digits) {
  char text[48];
  std::snprintf(text, sizeof text, "%.*f", digits, value == 0.0 ? 0.0 : value);
  return text;
}

Json summary_json(const Summary& s, const Options& options) {
  Json json{{"count", s.count}, {"missing", s.missing}};
  if (s.count == 0) return json;
  json["mean_m"] = rounded(s.mean);
  json["rms_m"] = rounded(s.rms);
  json["standard_deviation_m"] = rounded(s.standard_deviation);
  json["median_m"] = rounded(s.median);
  json["nmad_m"] = rounded(s.nmad);
  json["lowest_m"] = rounded(s.lowest);
  json["highest_m"] = rounded(s.highest);
  for (std::size_t i = 0; i < kPercentiles.size(); ++i) {
    json["percentiles_m"][text_of(kPercentiles[i], 0)] = rounded(s.percentiles[i]);
  }
  for (std::size_t i = 0; i < options.tolerances_m.size(); ++i) {
    json["completeness"].push_back(
        {{"within_m", options.tolerances_m[i]}, {"share", rounded(s.completeness[i], 1e-6)}});
  }
  return json;
}

Json statistics_json(const Measurement& m, const Options& options) {
  Json json;
  for (const Grouping grouping : kGroupings) {
    if (grouping != Grouping::kAll && !m.by_place) continue;
    const std::vector<std::string>& names = group_names(grouping);
    for (std::size_t i = 0; i < names.size(); ++i) {
      const Json group = summary_json(m.statistics->group(grouping, i).summary(), options);
      if (grouping == Grouping::kAll) {
        json["all"] = group;
      } else {
        json[grouping_name(grouping)][names[i]] = group;
      }
    }
  }
  return json;
}

Json side_json(const SideResult& side) {
  Json json{{"path", side.facts.title},         {"kind", kind_name(side.facts.kind)},
            {"files", side.facts.files.size()}, {"file_bytes", side.facts.file_bytes},
            {"crs", side.facts.crs.text()},     {"vertices", side.facts.vertices},
            {"triangles", side.facts.triangles}};
  if (side.facts.kind == Kind::kDem) json["step_m"] = side.facts.step_m;
  if (side.facts.kind == Kind::kCloud) {
    json["points_used"] = side.points_used;
    return json;
  }
  json["area_m2"] = rounded(side.area_m2, 0.01);
  json["overhangs"] = side.overhangs.size();
  json["overhang_m2"] = rounded(side.overhang_m2, 0.01);
  json["layered_m2"] = rounded(side.layered_m2, 0.01);
  return json;
}

Json versions_json(const Result& result) {
  Json rows = Json::array();
  for (const Version& v : result.versions) {
    rows.push_back({{"path", v.title},
                    {"triangles", v.triangles},
                    {"file_bytes", v.file_bytes},
                    {"rms_from_b_m", rounded(v.distances.rms)},
                    {"missing", v.distances.missing}});
  }
  return rows;
}

}  // namespace

std::vector<Measurement> measurements_of(const Result& result) {
  std::vector<Measurement> all{{"vertical", "Vertical, B - A", &result.vertical, true}};
  for (const Direction& d : result.directions) {
    const bool from_a = d.from == Side::kA;
    all.push_back(
        {from_a ? "a_to_b" : "b_to_a",
         std::string(from_a ? "From A to the nearest of B" : "From B to the nearest of A") +
             (d.has_sign ? "" : " (no sign)"),
         &d.statistics, d.by_place});
  }
  if (result.m3c2) {
    all.push_back({"m3c2", "Along normals (M3C2)", &result.m3c2->statistics, true});
  }
  return all;
}

std::string comparison_json(const Result& result, const Options& options) {
  const Box2d& c = result.common;
  Json json{{"format", "cornice comparison"}, {"version", 1}};
  json["common"] = {c.min_x, c.min_y, c.max_x, c.max_y};
  json["grid"] = {{"step_m", result.difference.step},
                  {"width", result.difference.width},
                  {"height", result.difference.height}};
  json["spacing_m"] = options.spacing_m;
  json["max_distance_m"] = options.max_distance_m;
  json["a"] = side_json(result.sides[0]);
  json["b"] = side_json(result.sides[1]);
  for (const Measurement& m : measurements_of(result)) {
    json["statistics"][m.name] = statistics_json(m, options);
  }
  if (result.m3c2) {
    json["m3c2"] = {{"core_points", result.m3c2->core_points},
                    {"measured", result.m3c2->measured},
                    {"significant", result.m3c2->significant},
                    {"mean_detection_95_m", rounded(result.m3c2->mean_detection_95_m)}};
  }
  json["versions"] = versions_json(result);
  if (const auto triangles = triangles_for_error_of_a(result)) {
    json["triangles_for_error_of_a"] = std::llround(*triangles);
  }
  json["colour_range_m"] = result.colour_range_m;
  json["warnings"] = result.warnings;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string statistics_csv(const Result& result, const Options& options) {
  std::string csv =
      "measurement,grouping,group,count,missing,mean_m,rms_m,standard_deviation_m,"
      "median_m,nmad_m,lowest_m,highest_m";
  for (const double p : kPercentiles) csv += ",p" + text_of(p, 0) + "_m";
  for (const double t : options.tolerances_m) {
    char name[32];
    std::snprintf(name, sizeof name, ",within_%gm", t);
    csv += name;
  }
  csv += "\n";
  for (const Measurement& m : measurements_of(result)) {
    for (const Grouping grouping : kGroupings) {
      if (grouping != Grouping::kAll && !m.by_place) continue;
      const std::vector<std::string>& names = group_names(grouping);
      for (std::size_t i = 0; i < names.size(); ++i) {
        const Summary s = m.statistics->group(grouping, i).summary();
        csv += m.name + "," + grouping_name(grouping) + "," + names[i] + "," +
               std::to_string(s.count) + "," + std::to_string(s.missing);
        // Nothing was measured: the numbers stay empty.
        const auto cell = [&](double value, int digits) {
          csv += s.count == 0 ? "," : "," + text_of(value, digits);
        };
        for (const double value :
             {s.mean, s.rms, s.standard_deviation, s.median, s.nmad, s.lowest, s.highest}) {
          cell(value, 4);
        }
        for (const double value : s.percentiles) cell(value, 4);
        for (const double value : s.completeness) {
          csv += s.count + s.missing == 0 ? "," : "," + text_of(value, 6);
        }
        csv += "\n";
      }
    }
  }
  return csv;
}

std::string overhangs_csv(const Result& result) {
  std::string csv =
      "side,id,east_m,north_m,height_m,area_m2,plan_m2,depth_m,length_m,rise_m,"
      "azimuth_deg,steepest_deg\n";
  for (const Side side : kSides) {
    int id = 0;
    for (const Overhang& o : result.sides[index_of(side)].overhangs) {
      csv += std::string(side == Side::kA ? "a" : "b") + "," + std::to_string(++id);
      for (const double value :
           {o.centre.x, o.centre.y, o.centre.z, o.area_m2, o.plan_m2, o.depth_m, o.length_m,
            o.height_m, o.azimuth_deg, o.steepest_deg}) {
        csv += "," + text_of(value, 2);
      }
      csv += "\n";
    }
  }
  return csv;
}

void write_overhangs(const std::filesystem::path& path, const Result& result) {
  const Crs& own = result.sides[0].facts.crs;
  GeoPackage package(path, own.empty() ? result.sides[1].facts.crs : own);
  const auto fields = [](const char* side, std::int64_t id, const Overhang& o) {
    return Fields{{"side", std::string(side)},
                  {"number", id},
                  {"area_m2", rounded(o.area_m2)},
                  {"plan_m2", rounded(o.plan_m2)},
                  {"depth_m", rounded(o.depth_m)},
                  {"length_m", rounded(o.length_m)},
                  {"rise_m", rounded(o.height_m)},
                  {"azimuth_deg", rounded(o.azimuth_deg)},
                  {"steepest_deg", rounded(o.steepest_deg)}};
  };
  for (const bool boxes : {false, true}) {
    package.begin_layer(boxes ? "overhang_boxes" : "overhangs",
                        boxes ? GeometryKind::kPolygon : GeometryKind::kPointZ, fields("a", 0, {}));
    for (const Side side : kSides) {
      std::int64_t id = 0;
      for (const Overhang& o : result.sides[index_of(side)].overhangs) {
        const Fields values = fields(side == Side::kA ? "a" : "b", ++id, o);
        const Box3d& b = o.box;
        if (boxes) {
          package.add(values, {{{b.min.x, b.min.y, 0.0}},
                               {{b.max.x, b.min.y, 0.0}},
                               {{b.max.x, b.max.y, 0.0}},
                               {{b.min.x, b.max.y, 0.0}}});
        } else {
          package.add(values, {{o.centre}});
        }
      }
    }
  }
  package.finish();
}

}  // namespace cornice::compare
