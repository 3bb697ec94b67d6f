// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/compare/output.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "core/base/atomic_file.h"
#include "core/io/ply.h"
#include "core/mesh/mesh.h"
#include "stages/compare/legend.h"

namespace cornice::compare {
namespace {

const char* letter(Side side) { return side == Side::kA ? "a" : "b"; }

/// Looked along towards the faces that overhang, weighted by area; the default where there is none.
double heading_towards(const Result& result) {
  double east = 0.0, north = 0.0;
  for (const SideResult& side : result.sides) {
    for (const Overhang& o : side.overhangs) {
      east += o.area_m2 * std::sin(o.azimuth_deg * std::numbers::pi / 180.0);
      north += o.area_m2 * std::cos(o.azimuth_deg * std::numbers::pi / 180.0);
    }
  }
  if (east == 0.0 && north == 0.0) return ViewPlan{}.heading_deg;
  // A quarter off, so that the faces are seen at a slant.
  return std::atan2(-east, -north) * 180.0 / std::numbers::pi + 25.0;
}

template <class T>
void add_bytes(Mesh& mesh, const char* name, const std::vector<T>& values, std::size_t channel) {
  ByteProperty property{name, {}};
  property.values.reserve(values.size());
  for (const T& value : values) property.values.push_back(value[channel]);
  mesh.byte_properties.push_back(std::move(property));
}

}  // namespace

std::filesystem::path Output::file(const std::string& name) {
  files_.push_back(options_.folder / name);
  return files_.back();
}

void Output::write_mesh(const MeasuredPart& part, const std::vector<Rgb>& colours) {
  Mesh mesh;
  mesh.origin = part.surface.origin;
  const auto& sides = part.result.sides;
  const Crs& own = sides[index_of(part.side)].facts.crs;
  mesh.crs_text = (own.empty() ? sides[1 - index_of(part.side)].facts.crs : own).text();
  mesh.positions = part.surface.positions;
  mesh.normals = part.surface.normals;
  mesh.triangles = part.surface.triangles;
  mesh.float_properties.push_back({"difference", part.distances_m});
  for (float& d : mesh.float_properties.back().values) {
    if (std::isnan(d)) d = kNoDifference;
  }
  add_bytes(mesh, "red", colours, 0);
  add_bytes(mesh, "green", colours, 1);
  add_bytes(mesh, "blue", colours, 2);
  if (!part.overhang.empty()) {
    ByteProperty overhang{"overhang", std::vector<std::uint8_t>(mesh.positions.size(), 0)};
    for (std::size_t t = 0; t < part.overhang.size(); ++t) {
      if (part.overhang[t] == 0) continue;
      for (const std::uint32_t v : mesh.triangles[t]) overhang.values[v] = 1;
    }
    mesh.byte_properties.push_back(std::move(overhang));
  }
  const std::string folder = std::string("coloured_") + letter(part.side);
  std::filesystem::create_directories(options_.folder / folder);
  const std::filesystem::path path = file(folder + "/" + part.name + ".ply");
  if (!mesh.triangles.empty()) return write_ply(path, mesh);
  OrientedPoints points;
  points.origin = mesh.origin;
  points.crs_text = mesh.crs_text;
  points.normals = mesh.normals.empty()
                       ? std::vector<Vec3f>(mesh.positions.size(), Vec3f{0.0f, 0.0f, 1.0f})
                       : std::move(mesh.normals);
  points.positions = std::move(mesh.positions);
  points.float_properties = std::move(mesh.float_properties);
  points.byte_properties = std::move(mesh.byte_properties);
  write_ply(path, points);
}

void Output::draw(const MeasuredPart& part, const std::vector<Rgb>& colours) {
  const std::size_t s = index_of(part.side);
  if (!distance_views_[s]) {
    ViewPlan plan;
    const Box2d& common = part.result.common;
    plan.box = {{common.min_x, common.min_y, part.result.lowest_m},
                {common.max_x, common.max_y, part.result.highest_m}};
    plan.heading_deg =
        options_.heading_deg < 0.0 ? heading_towards(part.result) : options_.heading_deg;
    distance_views_[s] = std::make_unique<View>(plan);
    if (!part.result.sides[s].overhangs.empty()) overhang_views_[s] = std::make_unique<View>(plan);
  }
  distance_views_[s]->add(part.surface, colours);
  if (!overhang_views_[s]) return;
  const std::vector<Rgb> plain(part.surface.positions.size(), kGroundColour);
  overhang_views_[s]->add(part.surface, plain, part.overhang);
}

void Output::add(const MeasuredPart& part) {
  std::vector<Rgb> colours;
  colours.reserve(part.distances_m.size());
  for (const float d : part.distances_m) {
    colours.push_back(difference_colour(static_cast<double>(d), part.result.colour_range_m));
  }
  draw(part, colours);
  if (options_.meshes && !part.surface.positions.empty()) write_mesh(part, colours);
}

void Output::write_pictures(const Result& result) {
  const auto write = [&](const std::string& name, const Picture& picture, const Legend& legend,
                         const std::string& caption) {
    write_picture(file(name), with_legend(picture, legend, has_text_));
    figures_.push_back({name, caption});
  };
  Legend map{"Height of B above A", result.colour_range_m, {}, 0.0};
  const Picture plan =
      difference_map(result.difference, result.relief, result.colour_range_m, map.px_per_m);
  write("difference.png", plan, map, "Vertical difference B - A, north up. White: no data.");
  for (const Direction& direction : result.directions) {
    const std::size_t s = index_of(direction.from);
    if (!distance_views_[s]) continue;
    const std::string own = s == 0 ? "A" : "B", other = s == 0 ? "B" : "A";
    Legend legend{own + " by its distance from " + other,
                  result.colour_range_m,
                  {{kUnknownColour, "no " + other + " near"}},
                  distance_views_[s]->px_per_m()};
    write(std::string("distance_") + letter(direction.from) + ".png", distance_views_[s]->picture(),
          legend,
          "Surface " + own + ", coloured by the distance to the nearest point of " + other +
              ", seen obliquely.");
    distance_views_[s].reset();
    if (!overhang_views_[s]) continue;
    Legend key{"Overhangs of " + own,
               0.0,
               {{kOverhangColour, "below the horizon"}},
               overhang_views_[s]->px_per_m()};
    write(std::string("overhangs_") + letter(direction.from) + ".png",
          overhang_views_[s]->picture(), key,
          "Surface of " + own + " that looks below the horizon; no raster of heights holds it.");
    overhang_views_[s].reset();
  }
}

void Output::write_profiles(const Result& result) {
  int number = 0;
  for (const Profile& profile : result.profiles) {
    const std::string name = "profile_" + std::to_string(++number) + ".svg";
    std::array<std::string, 2> titles;
    for (const Side side : kSides) {
      titles[index_of(side)] =
          std::filesystem::path(result.sides[index_of(side)].facts.title).filename().string();
    }
    write_file_atomically(file(name), profile_svg(profile, titles));
    char text[160];
    std::snprintf(text, sizeof text, "Both surfaces from %.1f, %.1f to %.1f, %.1f.",
                  profile.line.east1, profile.line.north1, profile.line.east2, profile.line.north2);
    figures_.push_back({name, text});
  }
}

std::vector<std::string> Output::finish(const Result& result, const Options& options) {
  std::filesystem::create_directories(options_.folder);
  write_cog(file("difference.tif"), result.difference);
  for (const Side side : kSides) {
    const auto& gaps = result.gaps[index_of(side)];
    if (gaps) write_cog(file(std::string("layer_gap_") + letter(side) + ".tif"), *gaps);
  }
  write_pictures(result);
  write_profiles(result);
  write_overhangs(file("overhangs.gpkg"), result);
  write_file_atomically(file("overhangs.csv"), overhangs_csv(result));
  write_file_atomically(file("statistics.csv"), statistics_csv(result, options));
  write_file_atomically(file("comparison.json"), comparison_json(result, options));
  write_file_atomically(file("index.html"),
                        comparison_page(result, options, options_.folder, figures_));
  if (has_text_) return {};
  return {"no font found to write legends with; install fonts-dejavu-core"};
}

}  // namespace cornice::compare
