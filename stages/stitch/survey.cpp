// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/survey.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <tuple>

#include "core/base/error.h"
#include "core/io/ply.h"
#include "core/mesh/select.h"
#include "stages/stitch/match.h"
#include "stages/stitch/small_parts.h"

namespace cornice::stitch {
namespace {

namespace fs = std::filesystem;

/// Origins on this grid, and coordinates within 8 km of them, have all positions that two tiles
/// must share.
constexpr double kOriginGridM = 1.0 / 1024.0;
/// No position is finer than that.
constexpr double kFinestGridM = 1.0 / 16384.0;

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

/// Two tiles whose boxes share ground, and how much of it both have surface on.
struct Pair {
  std::uint32_t a = 0, b = 0;
  Box2d box;
  double area_m2 = 0.0;
};

/// Pairs of tiles whose surfaces lie over each other, by more than half a metre of their border's
/// length. Boxes alone do not tell: tiles may meet along a line that bends.
std::vector<Pair> find_overlaps(const Survey& survey, Progress& progress) {
  const std::vector<Border>& tiles = survey.borders.tiles;
  std::vector<Pair> pairs;
  for (std::uint32_t a = 0; a < tiles.size(); ++a) {
    for (std::uint32_t b = a + 1; b < tiles.size(); ++b) {
      const Box2d box = shared_area(tiles[a].box, tiles[b].box);
      if (!box.empty()) pairs.push_back({a, b, box});
    }
  }
  std::vector<std::optional<Heights>> first(pairs.size());
  for (std::uint32_t t = 0; t < tiles.size(); ++t) {
    std::optional<Mesh> mesh;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      Pair& pair = pairs[i];
      if (pair.a != t && pair.b != t) continue;
      check_cancelled(progress);
      if (!mesh) mesh = read_tile(survey.paths[t]);
      Heights heights(pair.box);
      heights.add(*mesh);
      if (pair.a == t) {
        first[i] = std::move(heights);
      } else {
        pair.area_m2 = first[i]->area_shared_with(heights);
        first[i].reset();
      }
    }
  }
  std::erase_if(pairs, [](const Pair& pair) {
    return pair.area_m2 < 0.5 * std::max(pair.box.width(), pair.box.height());
  });
  return pairs;
}

std::string sentence(const Survey& survey, const Pair& pair) {
  return survey.paths[pair.b].filename().string() + " lies over " +
         survey.paths[pair.a].filename().string() + " on " +
         std::to_string(std::llround(pair.area_m2)) + " m2";
}

/// Cuts for tiles that lie over each other, or the refusal that the options ask for.
void settle_overlaps(Survey& survey, const Options& options, Progress& progress) {
  survey.cuts.resize(survey.paths.size());
  for (const Pair& pair : find_overlaps(survey, progress)) {
    const std::string subject = survey.paths[pair.b].string();
    const std::string what = "lies over " + survey.paths[pair.a].filename().string() + " on " +
                             std::to_string(std::llround(pair.area_m2)) + " m2";
    if (options.overlaps == Overlaps::kRefuse) {
      throw InputError(subject, what +
                                    "; give --overlaps cut, so that each keeps its side of the "
                                    "middle, or keep, or leave one out");
    }
    if (options.overlaps == Overlaps::kKeep) {
      survey.overlaps.push_back(sentence(survey, pair) + "; both are kept as they are");
      continue;
    }
    Cut a, b;
    if (!cut_apart(survey.borders.tiles[pair.a].box, survey.borders.tiles[pair.b].box, a, b)) {
      throw InputError(subject, what +
                                    ", more than half of it, so they are no neighbours that can "
                                    "be cut apart; leave one out");
    }
    survey.cuts[pair.a].push_back(a);
    survey.cuts[pair.b].push_back(b);
    survey.overlaps.push_back(sentence(survey, pair) + "; each keeps its side of the middle");
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

namespace {

/// Takes the CRS of a tile for that of the survey, or refuses it.
void learn_crs(const fs::path& path, const Mesh& mesh, Survey& survey, fs::path& crs_path) {
  if (mesh.crs_text.empty()) {
    ++survey.without_crs;
  } else if (survey.crs_text.empty()) {
    survey.crs_text = mesh.crs_text;
    crs_path = path;
  } else if (mesh.crs_text != survey.crs_text) {
    throw InputError(path.string(), "its CRS " + mesh.crs_text + " is not that of " +
                                        crs_path.string() + ", " + survey.crs_text +
                                        "; stitch tiles of one CRS");
  }
}

double largest_coordinate_m(const Mesh& mesh) {
  double largest = 0.0;
  for (const Vec3f& p : mesh.positions) {
    largest = std::max({largest, std::abs(static_cast<double>(p.x)),
                        std::abs(static_cast<double>(p.y)), std::abs(static_cast<double>(p.z))});
  }
  return largest;
}

Mesh without(const Mesh& mesh, const std::vector<std::uint32_t>& dropped) {
  std::vector<std::uint8_t> keep(mesh.triangles.size(), 1);
  for (const std::uint32_t t : dropped) {
    if (t < keep.size()) keep[t] = 0;
  }
  return select_triangles(mesh, keep);
}

/// A tile as cut, without the triangles that go.
Mesh read_own_part(const Survey& survey, std::uint32_t tile) {
  Mesh mesh = read_tile(survey.paths[tile]);
  if (!survey.cuts[tile].empty()) mesh = cut_mesh(mesh, survey.cuts[tile]);
  if (survey.dropped[tile].empty()) return mesh;
  return without(mesh, survey.dropped[tile]);
}

JoinOptions join_options(const Survey& survey, const Options& options) {
  return {options.tolerance_m, common_grid_m(survey.largest_coordinate_m + options.tolerance_m)};
}

/// Takes the parts out that are small over all tiles, and looks at what is left of their tiles.
void drop_small_parts(Survey& survey, const Options& options, Progress& progress) {
  std::vector<Border> tiles = survey.borders.tiles;
  keep_edges_near_tiles(tiles, options.tolerance_m);
  const Borders borders = number_borders(std::move(tiles));
  const SmallParts small = find_small_parts(
      borders, plan_borders(borders, match_edges(borders), join_options(survey, options)),
      options.min_area_m2);
  survey.small_parts = small.count;
  survey.small_parts_area_m2 = small.area_m2;
  for (std::uint32_t t = 0; t < survey.paths.size(); ++t) {
    if (small.of_tile[t].empty()) continue;
    check_cancelled(progress);
    const Mesh mesh = read_own_part(survey, t);
    survey.dropped[t] = triangles_of_parts(mesh, small.of_tile[t], options.threads);
    survey.borders.tiles[t] = find_border(without(mesh, survey.dropped[t]), options.threads);
  }
}

}  // namespace

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
    learn_crs(path, mesh, survey, crs_path);
    survey.largest_coordinate_m = std::max(survey.largest_coordinate_m, largest_coordinate_m(mesh));
    learned.push_back({path, find_border(mesh, options.threads)});
    survey.empty_tiles += mesh.triangles.empty();
    progress.advance(1);
  }
  progress.end();
  if (survey.without_crs == paths.size()) survey.without_crs = 0;
  std::sort(learned.begin(), learned.end(), comes_before);
  for (Learned& l : learned) {
    survey.paths.push_back(std::move(l.path));
    survey.borders.tiles.push_back(std::move(l.border));
  }
  survey.dropped.resize(survey.paths.size());
  settle_overlaps(survey, options, progress);
  std::vector<Border>& tiles = survey.borders.tiles;
  for (std::uint32_t t = 0; t < tiles.size(); ++t) {
    if (!survey.cuts[t].empty()) tiles[t] = find_border(read_own_part(survey, t), options.threads);
  }
  if (options.min_area_m2 > 0.0) drop_small_parts(survey, options, progress);
  for (std::uint32_t t = 0; t < tiles.size(); ++t) {
    if (tiles[t].box.empty()) continue;
    survey.box.add(tiles[t].box.min);
    survey.box.add(tiles[t].box.max);
  }
  keep_edges_near_tiles(tiles, options.tolerance_m);
  survey.borders = number_borders(std::move(tiles));
  return survey;
}

SeamReport check_survey(const Survey& survey, const Options& options) {
  return check_seams(survey.borders, match_edges(survey.borders), options.tolerance_m);
}

StitchResult stitch_survey(const Survey& survey, const Options& options, const TileSink& sink,
                           Progress& progress) {
  StitchResult result;
  result.plan =
      plan_borders(survey.borders, match_edges(survey.borders), join_options(survey, options));
  const SharedAttributes shared = share_attributes(survey.borders, result.plan);
  const auto places = places_by_tile(survey.borders, result.plan);
  result.shared_vertices = result.plan.class_count();
  std::vector<Border> written;
  progress.begin("write tiles", survey.paths.size());
  for (std::uint32_t t = 0; t < survey.paths.size(); ++t) {
    check_cancelled(progress);
    Mesh mesh = read_own_part(survey, t);
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
