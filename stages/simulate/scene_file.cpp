// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/scene_file.h"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <numbers>
#include <set>

#include "core/base/error.h"

namespace cornice::simulate {
namespace {

/// One mapping of the file: typed look-ups with limits, and an error for every key nobody asked
/// for.
class Section {
 public:
  Section(std::string file, YAML::Node node, std::string path)
      : file_(std::move(file)), node_(std::move(node)), path_(std::move(path)) {
    if (!node_.IsMap()) fail(node_, path_, "must be a mapping of keys to values");
  }

  [[noreturn]] void fail(const YAML::Node& where, const std::string& key,
                         const std::string& problem) const {
    throw InputError(file_,
                     "line " + std::to_string(where.Mark().line + 1) + ": " + key + ": " + problem);
  }

  bool has(const char* key) {
    known_.insert(key);
    return static_cast<bool>(node_[key]);
  }

  void number(const char* key, double& value, double low, double high) {
    if (!has(key)) return;
    value = as_number(node_[key], path_of(key), low, high);
  }
  void required_number(const char* key, double& value, double low, double high) {
    require(key);
    number(key, value, low, high);
  }

  void text(const char* key, std::string& value) {
    require(key);
    if (!node_[key].IsScalar()) fail(node_[key], path_of(key), "must be text");
    value = node_[key].Scalar();
  }

  void place(const char* key, Vec2d& value) {
    require(key);
    value = as_place(node_[key], path_of(key));
  }

  void places(const char* key, std::vector<Vec2d>& values, std::size_t at_least) {
    require(key);
    const YAML::Node list = node_[key];
    if (!list.IsSequence() || list.size() < at_least) {
      fail(list, path_of(key),
           "must be a list of at least " + std::to_string(at_least) + " places [east, north]");
    }
    for (const YAML::Node& item : list) values.push_back(as_place(item, path_of(key)));
  }

  Section section(const char* key) {
    require(key);
    return {file_, node_[key], path_of(key)};
  }

  template <class Shape, class Read>
  void list(const char* key, std::vector<Shape>& shapes, Read read) {
    if (!has(key)) return;
    const YAML::Node items = node_[key];
    if (!items.IsSequence()) fail(items, path_of(key), "must be a list");
    for (const YAML::Node& item : items) {
      Section section(file_, item, path_of(key));
      read(section, shapes.emplace_back());
      section.finish();
    }
  }

  /// Every key must have been asked for by now.
  void finish() const {
    for (const auto& entry : node_) {
      const std::string key = entry.first.Scalar();
      if (known_.contains(key)) continue;
      std::string accepted;
      for (const std::string& name : known_) accepted += (accepted.empty() ? "" : ", ") + name;
      fail(entry.first, path_of(key.c_str()), "unknown key; known are " + accepted);
    }
  }

 private:
  std::string path_of(const char* key) const { return path_.empty() ? key : path_ + "." + key; }

  void require(const char* key) {
    if (!has(key)) fail(node_, path_of(key), "is missing");
  }

  double as_number(const YAML::Node& node, const std::string& key, double low, double high) const {
    double value = 0.0;
    if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value)) {
      fail(node, key, "must be a number");
    }
    if (value < low || value > high) {
      char range[96];
      std::snprintf(range, sizeof range, "is %g, must be in [%g, %g]", value, low, high);
      fail(node, key, range);
    }
    return value;
  }

  Vec2d as_place(const YAML::Node& node, const std::string& key) const {
    if (!node.IsSequence() || node.size() != 2) fail(node, key, "must be [east, north] in metres");
    return {as_number(node[0], key, -1e5, 1e5), as_number(node[1], key, -1e5, 1e5)};
  }

  std::string file_;
  YAML::Node node_;
  std::string path_;
  std::set<std::string> known_;
};

void read_noise(Section& top, const char* key, NoiseShape& noise) {
  if (!top.has(key)) return;
  Section section = top.section(key);
  section.required_number("height_m", noise.height_m, 0, 3000);
  section.required_number("wavelength_m", noise.wavelength_m, 8, 20000);
  section.finish();
}

void read_ground(Section& top, SceneDescription& scene) {
  top.list("ridges", scene.ridges, [](Section& s, RidgeShape& ridge) {
    s.place("from", ridge.from);
    s.place("to", ridge.to);
    s.required_number("height_m", ridge.height_m, 0, 4000);
    s.required_number("half_width_m", ridge.half_width_m, 10, 10000);
  });
  read_noise(top, "hills", scene.hills);
  read_noise(top, "mountains", scene.mountains);
  read_noise(top, "detail", scene.detail);
  if (top.has("slope")) {
    Section s = top.section("slope");
    s.required_number("percent", scene.slope_percent, 0, 100);
    s.required_number("azimuth_deg", scene.slope_azimuth_deg, 0, 360);
    s.finish();
  }
  if (top.has("erosion")) {
    Section s = top.section("erosion");
    s.required_number("incision", scene.erosion.incision, 0, 5);
    s.number("step_m", scene.erosion.step_m, 2, 32);
    s.number("soft_deg", scene.erosion.soft_deg, 5, 80);
    s.number("hard_deg", scene.erosion.hard_deg, 5, 85);
    s.finish();
  }
  if (top.has("roughness")) {
    Section s = top.section("roughness");
    s.number("rock_m", scene.rock_roughness_m, 0, 0.5);
    s.number("soil_m", scene.soil_roughness_m, 0, 0.5);
    s.finish();
  }
  if (top.has("strata")) {
    Section s = top.section("strata");
    s.number("thickness_m", scene.strata.thickness_m, 4, 100);
    s.required_number("depth_m", scene.strata.depth_m, 0, 3);
    s.number("dip_deg", scene.strata.dip_deg, 0, 60);
    s.number("dip_azimuth_deg", scene.strata.dip_azimuth_deg, 0, 360);
    s.number("min_slope_deg", scene.strata.min_slope_deg, 20, 85);
    s.finish();
  }
}

void read_rock(Section& top, SceneDescription& scene) {
  top.list("walls", scene.walls, [](Section& s, WallShape& wall) {
    s.place("at", wall.at);
    s.required_number("azimuth_deg", wall.azimuth_deg, 0, 360);
    s.required_number("length_m", wall.length_m, 20, 5000);
    s.required_number("height_m", wall.height_m, 2, 1000);
    s.required_number("run_m", wall.run_m, 3, 1000);
    s.required_number("back_m", wall.back_m, 20, 5000);
    s.number("lean_m", wall.lean_m, 0, 60);
  });
  top.list("fins", scene.fins, [](Section& s, FinShape& fin) {
    s.place("at", fin.at);
    s.required_number("azimuth_deg", fin.azimuth_deg, 0, 360);
    s.required_number("length_m", fin.length_m, 10, 500);
    s.required_number("height_m", fin.height_m, 4, 200);
    s.required_number("half_width_m", fin.half_width_m, 3, 100);
    s.number("hole_width_m", fin.hole_width_m, 0, 100);
    s.number("hole_height_m", fin.hole_height_m, 0, 100);
  });
  top.list("caves", scene.caves, [](Section& s, CaveShape& cave) {
    s.place("at", cave.at);
    s.required_number("azimuth_deg", cave.azimuth_deg, 0, 360);
    s.required_number("above_m", cave.above_m, 0, 500);
    s.required_number("width_m", cave.width_m, 3, 100);
    s.required_number("height_m", cave.height_m, 3, 100);
    s.required_number("depth_m", cave.depth_m, 3, 200);
  });
}

void read_cover(Section& top, SceneDescription& scene) {
  top.list("rivers", scene.rivers, [](Section& s, RiverShape& river) {
    s.places("course", river.course, 2);
    s.required_number("width_m", river.width_m, 2, 500);
    s.required_number("bank_m", river.bank_m, 4, 500);
    s.number("level_m", river.level_m, -500, 4000);
    s.number("fall_per_km_m", river.fall_per_km_m, 0, 200);
  });
  if (top.has("forest")) {
    Section s = top.section("forest");
    ForestShape& forest = scene.forest;
    s.required_number("trees_per_ha", forest.trees_per_ha, 0, 2000);
    s.number("below_m", forest.below_m, -500, 5000);
    s.number("max_slope_deg", forest.max_slope_deg, 1, 60);
    s.number("tree_height_m", forest.tree_height_m, 3, 45);
    s.number("crown_radius_m", forest.crown_radius_m, 0.5, 6);
    s.number("cover", forest.cover, 0, 1);
    s.number("patch_m", forest.patch_m, 10, 2000);
    s.number("returns_per_m", forest.returns_per_m, 0.01, 10);
    s.finish();
  }
  top.list("villages", scene.villages, [](Section& s, VillageShape& village) {
    s.place("at", village.at);
    s.required_number("radius_m", village.radius_m, 10, 1000);
    double houses = 0;
    s.required_number("houses", houses, 1, 500);
    village.houses = static_cast<int>(houses);
  });
}

}  // namespace

Vec2d azimuth_direction(double azimuth_deg) {
  const double radians = azimuth_deg * std::numbers::pi / 180.0;
  return {std::sin(radians), std::cos(radians)};
}

SceneDescription read_scene_file(const std::filesystem::path& file) {
  YAML::Node root;
  try {
    root = YAML::LoadFile(file.string());
  } catch (const YAML::BadFile&) {
    throw InputError(file.string(),
                     "cannot be read; give a scene file such as samples/scenes/alp.yaml");
  } catch (const YAML::Exception& error) {
    throw InputError(file.string(),
                     "line " + std::to_string(error.mark.line + 1) + ": not YAML: " + error.msg);
  }
  SceneDescription scene;
  Section top(file.string(), root, "");
  double version = 0;
  top.required_number("cornice_scene", version, 1, 1);
  top.text("name", scene.name);
  if (top.has("size_m")) {
    Section size = top.section("size_m");
    size.required_number("east", scene.size_m[0], 50, 20000);
    size.required_number("north", scene.size_m[1], 50, 20000);
    size.finish();
  }
  top.required_number("base_m", scene.base_m, -400, 8000);
  top.number("grid_m", scene.grid_m, 0.5, 4);
  top.number("repeat_m", scene.repeat_m, 0, 20000);
  read_ground(top, scene);
  read_rock(top, scene);
  read_cover(top, scene);
  top.finish();
  return scene;
}

}  // namespace cornice::simulate
