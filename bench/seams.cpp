// SPDX-License-Identifier: GPL-3.0-or-later
// Whether tiles that were solved apart meet, and how far from a mesh made in one piece.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/bench_json.h"
#include "bench/programs.h"
#include "bench/seams/tiled.h"
#include "bench/surface/ground.h"
#include "core/base/error.h"
#include "core/base/random.h"
#include "core/io/ply.h"

namespace {

using namespace cornice;
using namespace cornice::bench;

struct Settings {
  double size_m = 150.0;
  double density = 20.0;
  std::vector<std::filesystem::path> points;
  std::filesystem::path meshes;
  TilingOptions tiling;
};

/// `columns` x `rows` tiles over `box`, borders on whole centimetres as real tiles have them.
std::vector<Box2d> grid(const Box2d& box, int columns, int rows) {
  const auto x = [&](int c) {
    return box.min_x + std::round(100.0 * box.width() * c / columns) / 100.0;
  };
  const auto y = [&](int r) {
    return box.min_y + std::round(100.0 * box.height() * r / rows) / 100.0;
  };
  std::vector<Box2d> tiles;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) tiles.push_back({x(c), y(r), x(c + 1), y(r + 1)});
  }
  return tiles;
}

/// The northing of the steepest fall of the ground along a meridian: where the wall stands.
double wall_northing(const Ground& ground) {
  const Box2d box = ground.extent;
  const double x = 0.5 * (box.min_x + box.max_x);
  double steepest = 0.0, northing = 0.5 * (box.min_y + box.max_y);
  for (double y = box.min_y + 0.25 * box.height(); y < box.max_y - 0.25 * box.height(); y += 1.0) {
    const double rise =
        std::abs(ground.scene->ground_height(x, y + 1.0) - ground.scene->ground_height(x, y - 1.0));
    if (rise > steepest) steepest = rise, northing = y;
  }
  return northing;
}

/// One point in twenty of those in `box`, the others as they are.
OrientedPoints thinned(const OrientedPoints& points, const Box2d& box, std::uint64_t seed) {
  OrientedPoints kept;
  kept.origin = points.origin;
  for (std::size_t p = 0; p < points.positions.size(); ++p) {
    const Vec3d at = points.origin + points.positions[p].cast<double>();
    if (box.contains(at.x, at.y) && CounterRandom(seed, 5, p).uniform() >= 0.05) continue;
    kept.positions.push_back(points.positions[p]);
    kept.normals.push_back(points.normals[p]);
    kept.quality.push_back(points.quality[p]);
  }
  return kept;
}

class Bench {
 public:
  Bench(const Settings& settings, Result& result) : settings_(settings), result_(result) {}

  void measure(const std::string& name, const OrientedPoints& points,
               const std::vector<Box2d>& tiles) {
    const SeamReport seams = measure_seams(points, tiles, settings_.tiling);
    std::printf(
        "%-22s tiles %zu triangles %zu open %zu mismatched %zu turned %zu non-manifold %zu "
        "seam rms %.5f m largest %.4f m, all %.5f m\n",
        name.c_str(), tiles.size(), seams.triangles, seams.open_edges, seams.mismatched,
        seams.turned, seams.non_manifold, seams.rms_m, seams.largest_m, seams.rms_anywhere_m);
    std::fflush(stdout);
    result_.figure("open_edges_" + name, static_cast<double>(seams.open_edges));
    result_.figure("mismatched_vertices_" + name, static_cast<double>(seams.mismatched));
    result_.figure("seam_rms_m_" + name, seams.rms_m);
    open_ += seams.open_edges, mismatched_ += seams.mismatched, turned_ += seams.turned;
    non_manifold_ += seams.non_manifold;
    rms_m_ = std::max(rms_m_, seams.rms_m);
    if (!settings_.meshes.empty()) write_ply(settings_.meshes / (name + ".ply"), seams.joined);
  }

  void write() {
    result_.figure("open_edges", static_cast<double>(open_));
    result_.figure("mismatched_vertices", static_cast<double>(mismatched_));
    result_.figure("turned_normals", static_cast<double>(turned_));
    result_.figure("non_manifold", static_cast<double>(non_manifold_));
    result_.figure("seam_rms_m", rms_m_);
  }

 private:
  const Settings& settings_;
  Result& result_;
  std::size_t open_ = 0, mismatched_ = 0, turned_ = 0, non_manifold_ = 0;
  double rms_m_ = 0.0;
};

void measure_simulated(const Settings& settings, const Options& options, Bench& bench) {
  const ScratchFolder work("seams");
  GroundPlan plan;
  plan.scene = std::filesystem::path(CORNICE_SCENES) / "cliff.yaml";
  plan.size_m = settings.size_m;
  plan.density = settings.density;
  plan.seed = options.seed;
  const Ground ground = fly_ground(plan, own_folder(), work.path(), options.threads);
  const Box2d all = ground.extent;
  bench.measure("2x2", ground.points, grid(all, 2, 2));
  const double wall = wall_northing(ground);
  bench.measure("border_in_wall", ground.points,
                {{all.min_x, all.min_y, all.max_x, wall}, {all.min_x, wall, all.max_x, all.max_y}});
  const std::vector<Box2d> four = grid(all, 2, 2);
  bench.measure("density_1_20", thinned(ground.points, four[3], options.seed), four);
  if (options.quick) return;
  bench.measure("3x3", ground.points, grid(all, 3, 3));
  std::vector<Box2d> hole = grid(all, 3, 3);
  hole.erase(hole.begin() + 4);
  bench.measure("hole", ground.points, hole);
}

/// Tiles of a real survey that lie beside each other: each file's points are one tile.
void measure_real(const Settings& settings, Bench& bench) {
  if (settings.points.empty()) return;
  OrientedPoints all;
  std::vector<Box2d> tiles;
  for (const std::filesystem::path& path : settings.points) {
    const OrientedPoints part = read_ply_points(path);
    if (all.positions.empty()) all.origin = part.origin, all.crs_text = part.crs_text;
    const Vec3f shift = (part.origin - all.origin).cast<float>();
    Box2d box;
    for (std::size_t p = 0; p < part.positions.size(); ++p) {
      const Vec3f at = part.positions[p] + shift;
      box.add(all.origin.x + at.x, all.origin.y + at.y);
      all.positions.push_back(at);
      all.normals.push_back(part.normals[p]);
      all.quality.push_back(part.quality.empty() ? 1.0f : part.quality[p]);
    }
    tiles.push_back(box);
  }
  bench.measure("real", all, side_by_side(tiles, settings.tiling.step_m));
}

void measure(Settings settings, const Options& options, Result& result) {
  if (options.quick) settings.size_m = std::min(settings.size_m, 80.0);
  settings.tiling.threads = options.threads;
  Bench bench(settings, result);
  measure_simulated(settings, options, bench);
  measure_real(settings, bench);
  bench.write();
  result.parameter("size_m", settings.size_m);
  result.parameter("density", settings.density);
  result.parameter("step_m", settings.tiling.step_m);
  result.parameter("halo_m", settings.tiling.halo_m);
  result.parameter("band_m", settings.tiling.band_m);
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  return run(
      "seams", "Tiles solved apart, meeting", argc, argv,
      [&](CLI::App& app) {
        app.add_option("--size-m", settings.size_m, "side of the simulated survey, whole metres");
        app.add_option("--density", settings.density, "points per square metre");
        app.add_option("--step-m", settings.tiling.step_m, "lattice step");
        app.add_option("--halo-m", settings.tiling.halo_m, "points used around a tile");
        app.add_option("--band-m", settings.tiling.band_m, "of a border, blended");
        app.add_option("--points", settings.points,
                       "oriented points (PLY) of real tiles side by side, without halo");
        app.add_option("--meshes", settings.meshes, "folder for the joined meshes");
      },
      [&](const Options& options, Result& result) { measure(settings, options, result); });
}
