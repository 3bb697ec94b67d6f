// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/index/survey_index.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/base/error.h"
#include "core/base/input_file.h"
#include "core/geo/crs.h"
#include "core/geo/product_name.h"
#include "core/io/las.h"
#include "stages/index/box_finder.h"
#include "stages/index/tile_boxes.h"

namespace cornice::index {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::string tile_name(const fs::path& path) {
  std::string name = path.filename().string();
  const std::string small = lower(name);
  for (const char* ending : {".copc.laz", ".las.zip", ".laz.zip", ".laz", ".las"}) {
    if (small.ends_with(ending)) return name.substr(0, name.size() - std::string(ending).size());
  }
  return name;
}

std::string product_of(const std::optional<ProductName>& name) {
  if (!name) return "any";
  if (name->product == Product::kSwissSurface3d) return "swisssurface3d";
  return name->product == Product::kLidarHdPoints ? "lidarhd" : "any";
}

bool is_number(const Box3d& box) {
  return std::isfinite(box.min.x) && std::isfinite(box.min.y) && std::isfinite(box.max.x) &&
         std::isfinite(box.max.y) && std::isfinite(box.min.z) && std::isfinite(box.max.z) &&
         !box.empty();
}

/// A tile as its header has it, and its CRS.
struct Opened {
  IndexedTile tile;
  Crs crs;
  std::optional<Box2d> nominal;
};

Opened open_tile(const fs::path& file, const std::string& crs_override) {
  check_utf8_name(file);
  Opened opened;
  IndexedTile& tile = opened.tile;
  tile.path = file;
  tile.name = tile_name(file);
  std::error_code ignored;
  tile.bytes = fs::is_regular_file(file, ignored) ? fs::file_size(file, ignored) : 0;
  const auto name = parse_product_name(file.filename().string());
  tile.product = product_of(name);
  try {
    LasOpenOptions options;
    options.crs_override = crs_override;
    const LasInfo info = read_las_info(file, options);
    opened.crs = info.crs;
    tile.crs = info.crs.text();
    tile.points = info.point_count;
    tile.bounds = info.bounds;
    if (!info.data_problem.empty())
      tile.problem = info.data_problem;
    else if (info.point_count == 0)
      tile.problem = "has no points; leave it out";
    else if (info.crs.metres_per_unit == 0.0)
      tile.problem = "is in degrees (" + info.crs.text() + "); reproject it to metres";
    else if (!is_number(info.bounds))
      tile.problem = "its header has no bounds; write it anew";
  } catch (const InputError& error) {
    tile.problem = error.problem();
  }
  // A crop keeps its tile's name: it answers for the tile's ground only where it lies in it.
  if (name && !name->tile.empty() && tile.problem.empty()) {
    const Box2d grown = name->tile.grown(1.0);
    const Box2d plan = tile.bounds.plan();
    if (grown.contains(plan.min_x, plan.min_y) && grown.contains(plan.max_x, plan.max_y))
      opened.nominal = name->tile;
  }
  return opened;
}

bool is_one_file(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return fs::equivalent(a, b, ignored);
}

void refuse_equal_names(std::vector<Opened>& tiles) {
  std::map<std::string, fs::path> seen;
  for (Opened& opened : tiles) {
    IndexedTile& tile = opened.tile;
    const auto [place, is_new] = seen.emplace(tile.name, tile.path);
    if (!is_new && tile.problem.empty())
      tile.problem = is_one_file(tile.path, place->second)
                         ? "is given twice; it counts once"
                         : "has the name of " + place->second.string() + "; rename one of them";
  }
}

/// Keeps the tiles of the most frequent CRS; returns that.
Crs settle_crs(std::vector<Opened>& tiles) {
  std::vector<std::pair<Crs, std::size_t>> systems;
  for (const Opened& opened : tiles) {
    if (!opened.tile.problem.empty()) continue;
    const auto known = std::find_if(systems.begin(), systems.end(), [&](const auto& entry) {
      return same_crs(entry.first, opened.crs);
    });
    if (known == systems.end())
      systems.emplace_back(opened.crs, 1);
    else
      ++known->second;
  }
  if (systems.empty()) return {};
  const Crs chosen =
      std::max_element(systems.begin(), systems.end(), [](const auto& a, const auto& b) {
        return a.second < b.second;
      })->first;
  const auto named = [](const Crs& crs) -> std::string {
    return crs.empty() ? "no known system" : crs.horizontal_epsg == 0 ? crs.name : crs.text();
  };
  for (Opened& opened : tiles) {
    if (!opened.tile.problem.empty() || same_crs(chosen, opened.crs)) continue;
    opened.tile.problem =
        "is in " + named(opened.crs) + ", the survey in " + named(chosen) +
        "; reproject it, or name the survey's own (crs, --crs) if the file is wrong";
  }
  return chosen;
}

void settle_boxes(std::vector<IndexedTile>& tiles, const std::vector<Opened>& opened,
                  const IndexOptions& options, std::vector<std::string>& warnings) {
  std::vector<std::size_t> usable;
  std::vector<Footprint> footprints;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    if (!tiles[i].problem.empty()) continue;
    usable.push_back(i);
    footprints.push_back({tiles[i].bounds.plan(), opened[i].nominal});
  }
  const TileBoxes boxes = lay_out(footprints, options.step_m, options.seam_m);
  for (std::size_t i = 0; i < usable.size(); ++i) {
    IndexedTile& tile = tiles[usable[i]];
    tile.box = boxes.boxes[i];
    if (boxes.inside[i] != kNobody)
      tile.problem = "covers the ground of " + tiles[usable[boxes.inside[i]]].path.string() +
                     "; leave one of them out";
    else if (tile.box.empty() || tile.box.width() <= 0.0 || tile.box.height() <= 0.0)
      tile.problem = "has no ground of its own, other tiles cover it; leave it out";
  }
  for (std::size_t i = 0; i < usable.size(); ++i) {
    const IndexedTile& tile = tiles[usable[i]];
    const Box2d out = tile.bounds.plan();
    const double beyond = std::max({tile.box.min_x - out.min_x, out.max_x - tile.box.max_x,
                                    tile.box.min_y - out.min_y, out.max_y - tile.box.max_y});
    if (tile.problem.empty() && beyond > options.seam_m)
      warnings.push_back(tile.path.string() + ": overlaps other tiles by up to " +
                         std::to_string(std::lround(2.0 * beyond)) +
                         " m; the overlap is cut in its middle");
  }
}

void find_neighbours(std::vector<IndexedTile>& tiles, double halo_m) {
  std::vector<std::size_t> usable;
  std::vector<Box2d> boxes;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    if (!tiles[i].problem.empty()) continue;
    usable.push_back(i);
    boxes.push_back(tiles[i].box);
  }
  const BoxFinder finder(boxes);
  for (std::size_t i = 0; i < usable.size(); ++i)
    for (const std::size_t j : finder.touching(boxes[i].grown(halo_m)))
      if (j != i) tiles[usable[i]].neighbours.push_back(usable[j]);
}

json box_json(const Box2d& b) { return {b.min_x, b.min_y, b.max_x, b.max_y}; }

json tile_json(const IndexedTile& tile, const std::vector<IndexedTile>& all) {
  json neighbours = json::array();
  for (const std::size_t j : tile.neighbours) neighbours.push_back(all[j].name);
  json object = {{"name", tile.name},        {"path", tile.path.string()}, {"bytes", tile.bytes},
                 {"points", tile.points},    {"product", tile.product},    {"crs", tile.crs},
                 {"neighbours", neighbours}, {"problem", tile.problem}};
  if (!tile.bounds.empty()) object["heights"] = {tile.bounds.min.z, tile.bounds.max.z};
  if (tile.problem.empty()) object["box"] = box_json(tile.box);
  return object;
}

}  // namespace

SurveyIndex index_survey(const std::vector<fs::path>& files, const IndexOptions& options,
                         Progress& progress) {
  if (!options.crs.empty()) crs_from_text(options.crs);
  std::vector<Opened> opened;
  progress.begin("reading headers", files.size());
  for (const fs::path& file : files) {
    opened.push_back(open_tile(file, options.crs));
    progress.advance(1);
  }
  progress.end();
  std::stable_sort(opened.begin(), opened.end(), [](const Opened& a, const Opened& b) {
    return std::pair(a.tile.name, a.tile.path) < std::pair(b.tile.name, b.tile.path);
  });
  refuse_equal_names(opened);
  SurveyIndex survey;
  survey.options = options;
  survey.crs = settle_crs(opened).text();
  for (const Opened& tile : opened) survey.tiles.push_back(tile.tile);
  settle_boxes(survey.tiles, opened, options, survey.warnings);
  find_neighbours(survey.tiles, options.halo_m);
  const auto first_usable =
      std::find_if(survey.tiles.begin(), survey.tiles.end(),
                   [](const IndexedTile& tile) { return tile.problem.empty(); });
  if (first_usable == survey.tiles.end())
    throw InputError(survey.tiles.front().path.string(),
                     survey.tiles.front().problem + " (no tile is usable)");
  return survey;
}

std::string to_json(const SurveyIndex& survey) {
  json tiles = json::array();
  for (const IndexedTile& tile : survey.tiles) tiles.push_back(tile_json(tile, survey.tiles));
  const json document = {
      {"format", "cornice survey 1"},    {"crs", survey.crs}, {"step_m", survey.options.step_m},
      {"halo_m", survey.options.halo_m}, {"tiles", tiles},    {"warnings", survey.warnings}};
  return document.dump(2) + "\n";
}

}  // namespace cornice::index
