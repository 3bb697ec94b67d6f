// SPDX-License-Identifier: GPL-3.0-or-later
// bench-dem-vs-lidar: one tile as a DEM and as the surface that our chain makes of its LiDAR, both
// against the ground that was flown over; and real points against the DEM of their place.
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "bench/bench_json.h"
#include "bench/compare/truth.h"
#include "bench/programs.h"
#include "bench/survey_run/survey_run.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/io/las.h"
#include "core/io/ply.h"
#include "core/mesh/triangle_tree.h"
#include "stages/compare/sampling.h"

namespace {

using namespace cornice;
using namespace cornice::bench;
namespace fs = std::filesystem;

constexpr double kTruthStepM = 0.5, kPointsDemStepM = 1.0;
/// Ground within this of a surface is there.
constexpr double kPresentM = 0.15;
/// Ground with a measured point as near as this was seen.
constexpr float kSeenM = 0.3f;
constexpr double kSampleM = 0.5, kInsideM = 2.0;
constexpr double kRangeM = 100.0;
constexpr std::uint8_t kGroundClass = 2;

struct Own {
  std::vector<std::string> scenes{"alp", "cliff"};
  double tile_m = 0.0;  ///< 0: 200, or 60 with --quick
};

PointCloud points_of(const fs::path& tile, int threads) {
  LasReadOptions options;
  options.attributes = Attribute::kClassification;
  options.threads = threads;
  return read_las(read_las_info(tile), options).points;
}

/// Mean height of a pixel's ground points: how a DEM is made of a cloud.
Raster points_dem(const PointCloud& points, const Box2d& extent, const Crs& crs) {
  Raster dem;
  dem.step = kPointsDemStepM;
  dem.west = extent.min_x, dem.north = extent.max_y;
  dem.width = static_cast<int>(std::lround(extent.width() / dem.step));
  dem.height = static_cast<int>(std::lround(extent.height() / dem.step));
  dem.crs = crs;
  const auto pixels = static_cast<std::size_t>(dem.width) * static_cast<std::size_t>(dem.height);
  std::vector<double> sum(pixels, 0.0), count(pixels, 0.0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points.classification[i] != kGroundClass) continue;
    const Vec3d p = points.position(i);
    const double col = std::floor((p.x - dem.west) / dem.step);
    const double row = std::floor((dem.north - p.y) / dem.step);
    if (col < 0.0 || row < 0.0 || col >= dem.width || row >= dem.height) continue;
    const std::size_t at = static_cast<std::size_t>(row) * static_cast<std::size_t>(dem.width) +
                           static_cast<std::size_t>(col);
    sum[at] += p.z;
    count[at] += 1.0;
  }
  for (std::size_t i = 0; i < pixels; ++i) {
    dem.values.push_back(count[i] > 0.0 ? static_cast<float>(sum[i] / count[i]) : dem.no_data);
  }
  return dem;
}

/// Places of the true ground, one for each kSampleM squared of its area, and what the scanner saw
/// of them: nothing is known of the rest, and no surface can be blamed for it.
struct Truth {
  Vec3d origin;
  std::vector<compare::Sample> seen;
  double seen_share = 0.0, overhang_seen_share = 0.0;
};

Truth true_places(const TrueGround& ground, const PointCloud& points, int threads) {
  const Mesh mesh = ground.scene->ground_mesh(kTruthStepM, ground.extent.grown(-kInsideM));
  compare::Surface surface;
  surface.origin = mesh.origin;
  surface.positions = mesh.positions;
  surface.triangles = mesh.triangles;
  surface.normals = compare::vertex_normals(mesh.positions, mesh.triangles);
  surface.curvature.assign(mesh.positions.size(), 0.0f);
  std::vector<compare::Sample> all;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    compare::sample_triangle(surface, t, kSampleM, 1, all);
  }
  std::vector<Vec3f> places;
  std::vector<Triangle> dots;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto v = static_cast<std::uint32_t>(i);
    places.push_back((points.position(i) - mesh.origin).cast<float>());
    dots.push_back({v, v, v});
  }
  const TriangleTree measured(places, dots, threads);
  NearestQuery query;
  query.max_distance_sq = kSeenM * kSeenM;
  Truth truth;
  truth.origin = mesh.origin;
  double hanging = 0.0, hanging_seen = 0.0;
  for (const compare::Sample& sample : all) {
    const bool is_seen = measured.nearest(sample.position, query).found();
    if (is_seen) truth.seen.push_back(sample);
    if (!(sample.normal.z < 0.0f)) continue;
    hanging += 1.0;
    if (is_seen) hanging_seen += 1.0;
  }
  truth.seen_share = static_cast<double>(truth.seen.size()) / static_cast<double>(all.size());
  if (hanging > 0.0) truth.overhang_seen_share = hanging_seen / hanging;
  return truth;
}

compare::Statistics distances_to(const Mesh& mesh, const Truth& truth, int threads) {
  const TriangleTree tree(mesh.positions, mesh.triangles, threads);
  std::vector<NearestPoint> nearest(truth.seen.size());
  const Vec3d shift = truth.origin - mesh.origin;
  parallel_for(nearest.size(), 4096, threads, [&](std::size_t begin, std::size_t end) {
    NearestQuery query;
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3d at = truth.seen[i].position.cast<double>() + shift;
      nearest[i] = tree.nearest(at.cast<float>(), query);
      query.guess = nearest[i].triangle;
    }
  });
  compare::Statistics statistics(kRangeM, {kPresentM});
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    const Vec3f normal = truth.seen[i].normal;
    statistics.add(compare::place_of(normal, 0.0f, normal.z < 0.0f),
                   std::sqrt(static_cast<double>(nearest[i].distance_sq)));
  }
  return statistics;
}

fs::path first_file(const fs::path& folder, const std::string& extension) {
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == extension) return entry.path();
  }
  throw RunError(folder.string(), "holds no " + extension + " file");
}

struct Cost {
  double seconds = 0.0, cpu_seconds = 0.0;
};

/// One mesh against the truth: a row of the table, and its figures.
void judge(const std::string& name, const fs::path& path, const Truth& truth, Cost cost,
           const Options& options, Result& result) {
  const Mesh mesh = read_ply_mesh(path);
  const compare::Statistics from_truth = distances_to(mesh, truth, options.threads);
  const compare::Summary all = from_truth.all().summary();
  const compare::Summary hanging = from_truth.group(compare::Grouping::kOverhang, 1).summary();
  const auto triangles = static_cast<double>(mesh.triangles.size());
  std::printf("%-18s %8.0f triangles %7.2f s (CPU %.2f)  rms %.3f m, within 0.15 m %.3f; by slope",
              name.c_str(), triangles, cost.seconds, cost.cpu_seconds, all.rms,
              all.completeness[0]);
  result.figure("triangles_" + name, triangles);
  result.figure("megabytes_" + name, static_cast<double>(fs::file_size(path)) / 1e6);
  result.figure("seconds_" + name, cost.seconds);
  result.figure("cpu_seconds_" + name, cost.cpu_seconds);
  result.figure("rms_m_" + name, all.rms);
  result.figure("within_15cm_" + name, all.completeness[0]);
  const std::vector<std::string>& slopes = compare::group_names(compare::Grouping::kSlope);
  for (std::size_t i = 0; i < slopes.size(); ++i) {
    const compare::Summary s = from_truth.group(compare::Grouping::kSlope, i).summary();
    if (s.count == 0) continue;
    std::printf(" %s: %.3f", slopes[i].c_str(), s.rms);
    result.figure("rms_m_" + name + "_slope_" + slopes[i], s.rms);
  }
  if (hanging.count > 0) {
    std::printf("  overhang kept %.3f", hanging.completeness[0]);
    result.figure("overhang_kept_" + name, hanging.completeness[0]);
  }
  std::printf("\n");
  std::fflush(stdout);
}

/// Of all programs run and waited for.
double programs_cpu_s() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

void measure_scene(const std::string& scene, double tile_m, const fs::path& folder,
                   const Options& options, Result& result) {
  SurveyRunPlan plan;
  plan.scene = scene;
  plan.tile_m = tile_m;
  plan.seed = options.seed;
  plan.threads = options.threads;
  const SurveyRun run = run_survey(plan, own_folder(), CORNICE_SCENES, folder / "run");
  const TrueGround ground = true_ground(scene, tile_m, options.seed, options.threads);
  const fs::path tile = first_file(folder / "run/survey", ".laz");
  const PointCloud points = points_of(tile, options.threads);
  const Truth truth = true_places(ground, points, options.threads);
  std::printf("%s: the scanner saw %.3f of the ground, %.3f of what overhangs\n", scene.c_str(),
              truth.seen_share, truth.overhang_seen_share);
  result.figure("seen_share_" + scene, truth.seen_share);
  result.figure("overhang_seen_share_" + scene, truth.overhang_seen_share);
  judge("lidar_" + scene, first_file(folder / "run/output/mesh", ".ply"), truth,
        {run.seconds(), run.cpu_seconds()}, options, result);
  const auto judge_dem = [&](const std::string& name, const fs::path& dem) {
    const double before = programs_cpu_s();
    const double seconds =
        run_program({own_folder() / "cornice-dem", dem, "-o", folder / ("mesh_" + name),
                     "--no-progress", "--threads", std::to_string(options.threads)},
                    folder / "dem.log")
            .seconds;
    judge(name + "_" + scene, first_file(folder / ("mesh_" + name), ".ply"), truth,
          {seconds, programs_cpu_s() - before}, options, result);
  };
  for (const char* step : {"0.5", "1", "2"}) {
    const fs::path dem = folder / (std::string("dem_") + step + ".tif");
    write_true_dem(ground, std::stod(step), dem);
    judge_dem(std::string("dem_") + step + "m", dem);
  }
  const fs::path dem = folder / "dem_points.tif";
  write_cog(dem, points_dem(points, ground.extent, read_las_info(tile).crs));
  judge_dem("dem_points_1m", dem);
}

/// Ground points of a real tile against one surface of their place.
void judge_by_points(const std::string& name, const fs::path& surface, const fs::path& points,
                     double seconds, const Options& options, Result& result) {
  compare::Options compared;
  compared.threads = options.threads;
  compared.classes = {kGroundClass};
  compared.tolerances_m = {kPresentM};
  const compare::Result r = compare_files(surface, points, compared);
  const compare::Summary s = r.directions[1].statistics.all().summary();
  const compare::SourceFacts& facts = r.sides[0].facts;
  std::printf(
      "%-16s %9llu triangles %8.2f MB %7.2f s  %llu ground points: median %.3f m, NMAD %.3f m, "
      "rms %.3f m, within 0.15 m %.3f\n",
      name.c_str(), static_cast<unsigned long long>(facts.triangles),
      static_cast<double>(facts.file_bytes) / 1e6, seconds,
      static_cast<unsigned long long>(s.count), s.median, s.nmad, s.rms, s.completeness[0]);
  result.figure("triangles_" + name, static_cast<double>(facts.triangles));
  if (seconds > 0.0) result.figure("seconds_" + name, seconds);
  result.figure("median_m_" + name, s.median);
  result.figure("nmad_m_" + name, s.nmad);
  result.figure("rms_m_" + name, s.rms);
  result.figure("within_15cm_" + name, s.completeness[0]);
}

/// A real tile and the terrain raster that its producer made of it.
void measure_real(const std::string& name, const fs::path& dem, const fs::path& points,
                  const fs::path& folder, const Options& options, Result& result) {
  if (!fs::exists(dem) || !fs::exists(points)) {
    std::printf("%s: not here, left out\n", name.c_str());
    return;
  }
  judge_by_points("dem_" + name, dem, points, 0.0, options, result);
  fs::create_directories(folder);
  std::ofstream(folder / "survey.yaml")
      << "tiles: [\"" << points.string() << "\"]\noutput: output\nproduct: lidarhd\n";
  const double seconds =
      run_program({own_folder() / "cornice", "run", folder / "survey.yaml", "--no-progress",
                   "--until", "stitch", "--threads", std::to_string(options.threads)},
                  folder / "run.log")
          .seconds;
  judge_by_points("lidar_" + name, first_file(folder / "output/mesh", ".ply"), points, seconds,
                  options, result);
}

void body(const Own& own, const Options& options, Result& result) {
  const ScratchFolder folder("dem-vs-lidar");
  const double tile_m = own.tile_m > 0.0 ? own.tile_m : options.quick ? 60.0 : 200.0;
  result.parameter("tile_m", tile_m);
  result.parameter("truth_step_m", kTruthStepM);
  for (const std::string& scene : own.scenes) {
    fs::create_directories(folder / scene);
    measure_scene(scene, tile_m, folder / scene, options, result);
  }
  const fs::path data = CORNICE_TEST_DATA;
  const fs::path near = data / "ign_tiles_50m", far = data / "ign_adjacent_1km";
  measure_real("real_50cm", near / "DTM_77055_627760_50CM.tif",
               near / "test_data_77055_627760_LA93_IGN69.laz", folder / "near", options, result);
  measure_real("real_5m", far / "test_mns_hydro_2023_0299_6802_LA93_IGN69_5m.tif",
               far / "test_semis_2023_0299_6802_LA93_IGN69.laz", folder / "far", options, result);
}

}  // namespace

int main(int argc, char** argv) {
  Own own;
  return cornice::bench::run(
      "dem-vs-lidar", "One tile as a DEM and as our LiDAR mesh, against the truth", argc, argv,
      [&](CLI::App& app) {
        app.add_option("--scenes", own.scenes, "of samples/scenes; none: the real data alone")
            ->delimiter(',');
        app.add_option("--tile-m", own.tile_m, "side of the tile, whole metres");
      },
      [&](const Options& options, Result& result) { body(own, options, result); });
}
