// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/survey.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "core/base/error.h"
#include "core/io/ply.h"
#include "stages/stitch/match.h"

namespace cornice::stitch {
namespace {

namespace fs = std::filesystem;

/// Origins on this grid, and coordinates within 8 km of them, have all positions that two tiles
/// must share.
constexpr double kOriginGridM = 1.0 / 1024.0;
/// No position is finer than that.
constexpr double kFinestGridM = 1.0 / 16384.0;
/// Tiles that lie over each other by less are neighbours.
constexpr double kOverlapM = 1.0;

bool is_on_grid(double x) { return x / kOriginGridM == std::round(x / kOriginGridM); }

/// Multiples of this are the same in all tiles: a float has 24 bits.
double common_grid_m(double largest_coordinate_m) {
  const double bits = std::ceil(std::log2(std::max(largest_coordinate_m, 1.0)));
  return std::max(kFinestGridM, std::exp2(bits - 23.0));
}

struct Learned {
  fs::path path;
  Border border;
};

/// Follows from what is in a tile, then from its name.
bool comes_before(const Learned& a, const Learned& b) {
  const auto key = [](const Learned& l) {
    const Box3d& box = l.border.box;
    return std::make_tuple(box.min.x, box.min.y, box.min.z, box.max.x, box.max.y, box.max.z,
                           l.border.tile_triangles, l.border.tile_vertices);
  };
  return std::make_tuple(key(a), a.path.filename()) < std::make_tuple(key(b), b.path.filename());
}

void find_overlaps(Survey& survey) {
  const std::vector<Border>& tiles = survey.borders.tiles;
  for (std::size_t a = 0; a < tiles.size(); ++a) {
    for (std::size_t b = a + 1; b < tiles.size(); ++b) {
      if (tiles[a].box.empty() || tiles[b].box.empty()) continue;
      const double x = std::min(tiles[a].box.max.x, tiles[b].box.max.x) -
                       std::max(tiles[a].box.min.x, tiles[b].box.min.x);
      const double y = std::min(tiles[a].box.max.y, tiles[b].box.max.y) -
                       std::max(tiles[a].box.min.y, tiles[b].box.min.y);
      if (std::min(x, y) <= kOverlapM) continue;
      survey.overlaps.push_back(
          survey.paths[a].filename().string() + " and " + survey.paths[b].filename().string() +
          " lie over each other by " + std::to_string(std::lround(x)) + " x " +
          std::to_string(std::lround(y)) + " m; their surfaces are kept as they are");
    }
  }
}

}  // namespace

Mesh read_tile(const fs::path& path, bool* moved) {
  Mesh mesh = read_ply_mesh(path);
  const Vec3d old = mesh.origin;
  const bool is_off = !is_on_grid(old.x) || !is_on_grid(old.y) || !is_on_grid(old.z);
  if (moved != nullptr) *moved = is_off;
  if (!is_off) return mesh;
  mesh.origin = {std::round(old.x), std::round(old.y), std::round(old.z)};
  for (Vec3f& p : mesh.positions) p = (p.cast<double>() + (old - mesh.origin)).cast<float>();
  return mesh;
}

Survey learn_survey(const std::vector<fs::path>& paths, const Options& options,
                    Progress& progress) {
  Survey survey;
  std::vector<Learned> learned;
  fs::path crs_path;
  progress.begin("read borders", paths.size());
  for (const fs::path& path : paths) {
    check_cancelled(progress);
    bool moved = false;
    const Mesh mesh = read_tile(path, &moved);
    survey.moved_origins += moved;
    if (!mesh.crs_text.empty() && survey.crs_text.empty()) {
      survey.crs_text = mesh.crs_text;
      crs_path = path;
    } else if (!mesh.crs_text.empty() && mesh.crs_text != survey.crs_text) {
      throw InputError(path.string(), "its CRS " + mesh.crs_text + " is not that of " +
                                          crs_path.string() + ", " + survey.crs_text +
                                          "; stitch tiles of one CRS");
    }
    for (const Vec3f& p : mesh.positions) {
      survey.largest_coordinate_m =
          std::max({survey.largest_coordinate_m, std::abs(static_cast<double>(p.x)),
                    std::abs(static_cast<double>(p.y)), std::abs(static_cast<double>(p.z))});
    }
    learned.push_back({path, find_border(mesh, options.threads)});
    survey.empty_tiles += mesh.triangles.empty();
    progress.advance(1);
  }
  progress.end();
  std::sort(learned.begin(), learned.end(), comes_before);
  std::vector<Border> tiles;
  for (Learned& l : learned) {
    survey.paths.push_back(std::move(l.path));
    if (!l.border.box.empty()) {
      survey.box.add(l.border.box.min);
      survey.box.add(l.border.box.max);
    }
    tiles.push_back(std::move(l.border));
  }
  keep_edges_near_tiles(tiles, options.tolerance_m);
  survey.borders = number_borders(std::move(tiles));
  find_overlaps(survey);
  return survey;
}

SeamReport check_survey(const Survey& survey, const Options& options) {
  return check_seams(survey.borders, match_edges(survey.borders), options.tolerance_m);
}

StitchResult stitch_survey(const Survey& survey, const Options& options, const TileSink& sink,
                           Progress& progress) {
  StitchResult result;
  JoinOptions join;
  join.tolerance_m = options.tolerance_m;
  join.grid_m = common_grid_m(survey.largest_coordinate_m + options.tolerance_m);
  result.plan = plan_borders(survey.borders, match_edges(survey.borders), join);
  const SharedAttributes shared = share_attributes(survey.borders, result.plan);
  const auto places = places_by_tile(survey.borders, result.plan);
  result.shared_vertices = result.plan.class_count();
  std::vector<Border> written;
  progress.begin("write tiles", survey.paths.size());
  for (std::uint32_t t = 0; t < survey.paths.size(); ++t) {
    check_cancelled(progress);
    Mesh mesh = read_tile(survey.paths[t]);
    const Border& known = survey.borders.tiles[t];
    if (mesh.positions.size() != known.tile_vertices ||
        mesh.triangles.size() != known.tile_triangles) {
      throw InputError(survey.paths[t].string(), "was changed while it was being stitched");
    }
    EditedTile edited =
        edit_tile(std::move(mesh), t, survey.borders, result.plan, places[t], shared);
    result.flipped_edges += edited.flipped_edges;
    result.vertices += edited.mesh.positions.size();
    result.triangles += edited.mesh.triangles.size();
    written.push_back(find_border(edited.mesh, options.threads));
    sink(survey.paths[t], edited);
    progress.advance(1);
  }
  progress.end();
  keep_edges_near_tiles(written, options.tolerance_m);
  const Borders borders = number_borders(std::move(written));
  result.seams = check_seams(borders, match_edges(borders), options.tolerance_m);
  return result;
}

}  // namespace cornice::stitch
