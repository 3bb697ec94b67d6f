// SPDX-License-Identifier: GPL-3.0-or-later
// Speed, memory and accuracy of the Poisson engine and the extraction, beside PCL and PoissonRecon.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/bench_json.h"
#include "bench/poisson/hills.h"
#include "bench/poisson/pcl_poisson.h"
#include "bench/poisson/run.h"
#include "bench/programs.h"
#include "core/base/error.h"
#include "core/base/memory.h"
#include "core/io/ply.h"
#include "core/mesh/triangle_tree.h"

namespace {

using namespace cornice;
using namespace cornice::bench;

/// A tile of depth 11 is 1024 m wide at 0.5 m.
constexpr double kTileM = 1024.0;
constexpr double kDensity = 20.0;
constexpr double kStepM = 0.5;
constexpr double kBorderM = 5.0, kFarM = 1.0;

struct Settings {
  std::vector<double> millions{1, 4, 16, 20.4};
  std::vector<int> depths{11, 10, 9};
  double noise_m = 0.03, tilt_deg = 2.0;
  std::vector<double> peer_millions{20.4}, pcl_millions{0.25};
  std::vector<int> peer_depths{11};
  double scaling_millions = 4.0;
  std::filesystem::path poissonrecon;
  std::filesystem::path points;
  std::vector<int> thread_counts{1, 2};
};

/// "20m"; below a million in thousands, "500k".
std::string size_name(double millions) {
  return millions < 1.0 ? std::to_string(std::lround(1e3 * millions)) + "k"
                        : std::to_string(static_cast<int>(millions)) + "m";
}

/// "4m_d10"; depths are those of a tile of 1024 m, whatever the points cover.
std::string case_name(double millions, int depth) {
  return size_name(millions) + "_d" + std::to_string(depth);
}

double step_of(int depth) { return kTileM / std::ldexp(1.0, depth); }

double gib(std::uint64_t bytes) { return static_cast<double>(bytes) / 0x1p30; }

/// The largest distance that a share of the vertices and centroids of a mesh keep from another, of
/// those farther than kBorderM from its edge; those farther away than kFarM count as that.
struct MeshDistance {
  double share_within_fifth_step = 0.0;
  double at_999_m = 0.0;
};

MeshDistance distance_between(const Mesh& from, const Mesh& to, const Hills& hills, double step_m,
                              int threads) {
  const TriangleTree tree(to.positions, to.triangles, threads);
  NearestQuery query;
  query.max_distance_sq = static_cast<float>(kFarM * kFarM);
  const Vec3f shift = (from.origin - to.origin).cast<float>();
  const Vec3f corner = (from.origin - hills.origin()).cast<float>();
  const Box2d counted = Box2d{0.0, 0.0, hills.side_m(), hills.side_m()}.grown(-kBorderM);
  std::vector<double> distances;
  const auto add = [&](Vec3f p) {
    const Vec3f at = p + corner;
    if (!counted.contains(at.x, at.y)) return;
    const NearestPoint nearest = tree.nearest(p + shift, query);
    distances.push_back(nearest.found() ? std::sqrt(static_cast<double>(nearest.distance_sq))
                                        : kFarM);
  };
  for (const Vec3f p : from.positions) add(p);
  for (const auto& t : from.triangles)
    add((from.positions[t[0]] + from.positions[t[1]] + from.positions[t[2]]) * (1.0f / 3.0f));
  if (distances.empty()) throw RunError("bench-poisson", "there is no surface to compare");
  std::sort(distances.begin(), distances.end());
  const auto within = std::lower_bound(distances.begin(), distances.end(), 0.2 * step_m);
  return {static_cast<double>(within - distances.begin()) / static_cast<double>(distances.size()),
          distances[(distances.size() - 1) * 999 / 1000]};
}

/// Both from file to file on the same points, at the same width of the finest cells.
void compare_with_poissonrecon(const Settings& settings, const Options& options, double millions,
                               int depth, Result& result) {
  const auto count = static_cast<std::size_t>(millions * 1e6);
  const Hills hills(std::sqrt(static_cast<double>(count) / kDensity));
  const ScratchFolder work("poisson");
  const std::filesystem::path in = work / "points.ply", ours = work / "ours.ply",
                              theirs = work / "theirs.ply";
  write_ply(
      in, hills.sample(count, settings.noise_m, settings.tilt_deg, options.seed, options.threads));
  const std::clock_t before = std::clock();
  const double our_s = seconds_of([&] {
    const OrientedPoints points = read_ply_points(in);
    write_ply(ours, reconstruct(points, step_of(depth), options.threads).mesh);
  });
  const double our_cpu_s = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
  const ProgramCost cost =
      run_program({settings.poissonrecon, "--in", in, "--out", theirs, "--width",
                   std::to_string(step_of(depth)), "--pointWeight", "4"},
                  work / "poissonrecon.log");
  Mesh their_mesh = read_ply_mesh(theirs);
  their_mesh.origin = hills.origin();
  const Mesh our_mesh = read_ply_mesh(ours);
  const HillsAccuracy a = measure_accuracy(hills, their_mesh, kBorderM, kFarM);
  const HillsAccuracy b = measure_accuracy(hills, our_mesh, kBorderM, kFarM);
  const MeshDistance apart =
      distance_between(our_mesh, their_mesh, hills, step_of(depth), options.threads);
  const std::string name = "_" + case_name(millions, depth);
  std::printf(
      "PoissonRecon %s: %.1f s (%.1f s of processors), %.2f GiB, %.2f M triangles, rms %.4f m; "
      "ours, file to file: %.1f s (%.1f), rms %.4f m; %.5f of ours within 0.2 steps of theirs, "
      "99.9 %% within %.4f m\n",
      name.c_str() + 1, cost.seconds, cost.cpu_seconds, gib(cost.peak_resident_bytes),
      1e-6 * static_cast<double>(their_mesh.triangles.size()), a.rms_m, our_s, our_cpu_s, b.rms_m,
      apart.share_within_fifth_step, apart.at_999_m);
  std::fflush(stdout);
  result.figure("ratio_poissonrecon" + name, cost.seconds / our_s);
  result.figure("cpu_ratio_poissonrecon" + name, cost.cpu_seconds / our_cpu_s);
  result.figure("poissonrecon_seconds" + name, cost.seconds);
  result.figure("poissonrecon_cpu_seconds" + name, cost.cpu_seconds);
  result.figure("poissonrecon_gib" + name, gib(cost.peak_resident_bytes));
  result.figure("poissonrecon_triangles" + name, static_cast<double>(their_mesh.triangles.size()));
  result.figure("poissonrecon_rms_m" + name, a.rms_m);
  result.figure("file_to_file_seconds" + name, our_s);
  result.figure("file_to_file_cpu_seconds" + name, our_cpu_s);
  result.figure("file_to_file_rms_m" + name, b.rms_m);
  result.figure("share_within_fifth_step" + name, apart.share_within_fifth_step);
  if (millions == settings.peer_millions.front() && depth == settings.peer_depths.front())
    result.figure("ratio_poissonrecon", cost.seconds / our_s);
}

/// Both in memory. PCL's cube is 1.1 times as wide as the points and cut into a power of two, so
/// its cells are up to 1.4 times as wide, or as narrow, as ours.
void compare_with_pcl(const Settings& settings, const Options& options, double millions, int depth,
                      Result& result) {
  const auto count = static_cast<std::size_t>(millions * 1e6);
  const Hills hills(std::sqrt(static_cast<double>(count) / kDensity));
  const OrientedPoints points =
      hills.sample(count, settings.noise_m, settings.tilt_deg, options.seed, options.threads);
  const int their_depth =
      static_cast<int>(std::lround(std::log2(1.1 * hills.side_m() / step_of(depth))));
  const Run run = reconstruct(points, step_of(depth), options.threads);
  Mesh mesh;
  const double their_s = seconds_of([&] { mesh = pcl_poisson(points, their_depth); });
  const double their_gib = gib(peak_resident_bytes());
  const HillsAccuracy a = measure_accuracy(hills, mesh, kBorderM, kFarM);
  const HillsAccuracy b = measure_accuracy(hills, run.mesh, kBorderM, kFarM);
  const MeshDistance apart =
      distance_between(run.mesh, mesh, hills, step_of(depth), options.threads);
  const std::string name = "_" + case_name(millions, depth);
  std::printf(
      "PCL %s: %.1f s, peak so far %.2f GiB, %.2f M triangles, rms %.4f m; ours %.2f s, rms "
      "%.4f m; %.5f of ours within 0.2 steps of it\n",
      name.c_str() + 1, their_s, their_gib, 1e-6 * static_cast<double>(mesh.triangles.size()),
      a.rms_m, run.seconds(), b.rms_m, apart.share_within_fifth_step);
  std::fflush(stdout);
  result.figure("ratio_pcl" + name, their_s / run.seconds());
  result.figure("pcl_seconds" + name, their_s);
  result.figure("pcl_triangles" + name, static_cast<double>(mesh.triangles.size()));
  result.figure("pcl_rms_m" + name, a.rms_m);
}

void add_steps(const Run& run, const std::string& name, Result& result) {
  for (const StepBound& step : step_bounds(run)) {
    std::string key = step.step;
    std::replace(key.begin(), key.end(), ' ', '_');
    result.figure("step_seconds_" + key + "_" + name, step.seconds);
    result.figure("step_bound_seconds_" + key + "_" + name, step.bound_s);
  }
}

void measure_case(const Settings& settings, const Options& options, double millions, int depth,
                  Result& result) {
  const auto count = static_cast<std::size_t>(millions * 1e6);
  const Hills hills(std::sqrt(static_cast<double>(count) / kDensity));
  const OrientedPoints points =
      hills.sample(count, settings.noise_m, settings.tilt_deg, options.seed, options.threads);
  const Run run = reconstruct(points, step_of(depth), options.threads);
  const HillsAccuracy accuracy = measure_accuracy(hills, run.mesh, kBorderM, kFarM);
  const std::string name = case_name(millions, depth);
  print(run, name);
  std::printf("  rms %.4f m\n", accuracy.rms_m);
  result.figure("seconds_" + name, run.seconds());
  result.figure("cpu_seconds_" + name, run.cpu_s);
  result.figure("solve_seconds_" + name, run.solve_s);
  if (depth == settings.depths.front()) result.figure("gib_" + name, run.gib);
  add_steps(run, name, result);
  result.figure("triangles_" + name, static_cast<double>(run.mesh.triangles.size()));
  result.figure("rms_m_" + name, accuracy.rms_m);
}

/// The same points with each number of threads.
void measure_threads(const Settings& settings, const Options& options, Result& result) {
  const auto count = static_cast<std::size_t>(settings.scaling_millions * 1e6);
  const Hills hills(std::sqrt(static_cast<double>(count) / kDensity));
  const OrientedPoints points =
      hills.sample(count, settings.noise_m, settings.tilt_deg, options.seed, options.threads);
  for (const int threads : settings.thread_counts) {
    const Run run = reconstruct(points, kStepM, threads);
    const std::string name = size_name(settings.scaling_millions) + "_t" + std::to_string(threads);
    std::printf("ours %s: solve %.2f s, extract %.2f s\n", name.c_str(), run.solve_s,
                run.extract_s);
    result.figure("seconds_" + name, run.seconds());
  }
}

/// Oriented points from a file.
void measure_points(const Settings& settings, const Options& options, Result& result) {
  if (settings.points.empty()) return;
  const OrientedPoints points = read_ply_points(settings.points);
  const Run run = reconstruct(points, kStepM, options.threads);
  print(run, settings.points.filename());
  result.figure("seconds_points", run.seconds());
  result.figure("cpu_seconds_points", run.cpu_s);
  result.figure("gib_points", run.gib);
  result.figure("triangles_points", static_cast<double>(run.mesh.triangles.size()));
  add_steps(run, "points", result);
}

void measure(Settings settings, const Options& options, Result& result) {
  if (options.quick) {
    settings.millions = {0.5};
    settings.depths = {11};
    settings.pcl_millions = {0.02};
    settings.peer_millions = {0.1};
    settings.peer_depths = {11};
    settings.scaling_millions = 0.1;
  }
  // Ever more points, so that the peak of the process is always the latest run's own.
  std::sort(settings.millions.begin(), settings.millions.end());
  std::sort(settings.depths.rbegin(), settings.depths.rend());
  for (const int depth : settings.depths) {
    for (const double millions : settings.millions)
      measure_case(settings, options, millions, depth, result);
  }
  measure_threads(settings, options, result);
  measure_points(settings, options, result);
  for (const int depth : settings.peer_depths) {
    for (const double millions : settings.pcl_millions)
      compare_with_pcl(settings, options, millions, depth, result);
    for (const double millions : settings.peer_millions) {
      if (!settings.poissonrecon.empty())
        compare_with_poissonrecon(settings, options, millions, depth, result);
    }
  }
  result.parameter("density", kDensity);
  result.parameter("noise_m", settings.noise_m);
  result.parameter("tilt_deg", settings.tilt_deg);
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  return run(
      "poisson", "Speed, memory and accuracy of reconstruction", argc, argv,
      [&](CLI::App& app) {
        app.add_option("--millions", settings.millions, "of points")->delimiter(',');
        app.add_option("--depths", settings.depths, "of a tile of 1024 m, 11 is 0.5 m")
            ->delimiter(',');
        app.add_option("--noise-m", settings.noise_m, "of the points along their normals");
        app.add_option("--tilt-deg", settings.tilt_deg, "mean error of the normals");
        app.add_option("--pcl-millions", settings.pcl_millions, "points that PCL gets")
            ->delimiter(',')
            ->check(CLI::PositiveNumber);
        app.add_flag_callback(
            "--no-pcl", [&] { settings.pcl_millions.clear(); }, "leave PCL out");
        app.add_option("--peer-depths", settings.peer_depths, "that PCL and PoissonRecon get")
            ->delimiter(',');
        app.add_option("--thread-counts", settings.thread_counts, "to compare")->delimiter(',');
        app.add_option("--scaling-millions", settings.scaling_millions, "points for that");
        app.add_option("--points", settings.points, "oriented points (PLY) to reconstruct, too")
            ->check(CLI::ExistingFile);
        app.add_option("--peer-millions", settings.peer_millions, "points that PoissonRecon gets")
            ->delimiter(',');
        app.add_option("--peer-poissonrecon", settings.poissonrecon, "the program")
            ->check(CLI::ExistingFile);
      },
      [&](const Options& options, Result& result) { measure(settings, options, result); });
}
