// SPDX-License-Identifier: GPL-3.0-or-later
// Speed, memory and accuracy of the Poisson engine and the extraction, beside PCL and PoissonRecon.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/bench_json.h"
#include "bench/poisson/hills.h"
#include "bench/poisson/pcl_poisson.h"
#include "bench/programs.h"
#include "core/base/error.h"
#include "core/base/memory.h"
#include "core/io/ply.h"
#include "core/mesh/triangle_tree.h"
#include "stages/poisson/band.h"
#include "stages/poisson/extract.h"
#include "stages/poisson/solve.h"

namespace {

using namespace cornice;
using namespace cornice::bench;

/// A tile of depth 11 is 1024 m wide at 0.5 m.
constexpr double kTileM = 1024.0;
constexpr double kDensity = 20.0;
constexpr double kStepM = 0.5;
constexpr double kBorderM = 5.0, kFarM = 1.0;
/// What this kind of machine does at best (two cores): bytes streamed, nodes relaxed with 27 taps.
constexpr double kNodesPerSecond = 450e6, kSweepsPerPass = 7.0 / 4.0;

struct Settings {
  std::vector<double> millions{1, 4, 16, 20.4};
  std::vector<int> depths{11, 10, 9};
  double noise_m = 0.03, tilt_deg = 2.0;
  std::vector<double> peer_millions{20.4};
  double pcl_millions = 0.25, scaling_millions = 4.0;
  std::filesystem::path poissonrecon;
  std::filesystem::path points;
  std::vector<int> thread_counts{1, 2};
};

/// "20m"; below a million in thousands, "500k".
std::string size_name(double millions) {
  return millions < 1.0 ? std::to_string(std::lround(1e3 * millions)) + "k"
                        : std::to_string(static_cast<int>(millions)) + "m";
}

double gib(std::uint64_t bytes) { return static_cast<double>(bytes) / 0x1p30; }

/// One reconstruction by our engine.
struct Run {
  Mesh mesh;
  SolveReport report;
  double solve_s = 0.0, extract_s = 0.0, gib = 0.0;
};

Run reconstruct(const OrientedPoints& points, double step_m, int threads) {
  Run run;
  SolveOptions options;
  options.lattice.step_m = step_m;
  options.threads = threads;
  Box3d domain;
  for (const Vec3f p : points.positions) domain.add(points.origin + p.cast<double>());
  Solution solved;
  run.solve_s = seconds_of([&] { solved = solve_poisson(points, domain, options, no_progress()); });
  ExtractOptions extract;
  extract.window = lattice_box(domain.plan(), options.lattice);
  extract.threads = threads;
  const auto node = [&](double z) { return static_cast<std::int32_t>(std::floor(z / step_m)); };
  run.extract_s = seconds_of([&] {
    const FieldValues values(solved.field, node(domain.min.z - 16), node(domain.max.z + 16));
    run.mesh = extract_surface(values, options.lattice, extract).mesh;
  });
  run.report = std::move(solved.report);
  run.gib = gib(peak_resident_bytes());
  return run;
}

void print(const Run& run, double millions, int depth, const HillsAccuracy* accuracy) {
  std::printf(
      "ours %.2f M points depth %d: solve %.2f s, extract %.2f s, peak so far %.2f GiB, "
      "%.2f M triangles",
      millions, depth, run.solve_s, run.extract_s, run.gib,
      1e-6 * static_cast<double>(run.mesh.triangles.size()));
  if (accuracy) std::printf(", rms %.4f m", accuracy->rms_m);
  std::printf("\n");
  for (const StepSeconds& step : run.report.seconds) {
    std::printf("  %-32s %6.2f s, %.2f M points/s\n", step.step.c_str(), step.seconds,
                1e-6 * static_cast<double>(run.report.points) / step.seconds);
    if (step.step != "solving") continue;
    double relaxed = 0.0;
    for (const LevelReport& level : run.report.levels)
      relaxed += kSweepsPerPass * level.passes * static_cast<double>(level.unknowns);
    std::printf("  %-32s %.0f M nodes/s, %.2f of the bound\n", "", 1e-6 * relaxed / step.seconds,
                relaxed / step.seconds / kNodesPerSecond);
  }
}

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
  if (distances.empty()) throw RunError("PoissonRecon", "has no surface to compare with");
  std::sort(distances.begin(), distances.end());
  const auto within = std::lower_bound(distances.begin(), distances.end(), 0.2 * step_m);
  return {static_cast<double>(within - distances.begin()) / static_cast<double>(distances.size()),
          distances[(distances.size() - 1) * 999 / 1000]};
}

/// Both from file to file on the same points, at the same width of the finest cells.
void compare_with_poissonrecon(const Settings& settings, const Options& options, double millions,
                               Result& result) {
  const auto count = static_cast<std::size_t>(millions * 1e6);
  const Hills hills(std::sqrt(static_cast<double>(count) / kDensity));
  const ScratchFolder work("poisson");
  const std::filesystem::path in = work / "points.ply", ours = work / "ours.ply",
                              theirs = work / "theirs.ply";
  write_ply(
      in, hills.sample(count, settings.noise_m, settings.tilt_deg, options.seed, options.threads));
  const double our_s = seconds_of([&] {
    const OrientedPoints points = read_ply_points(in);
    write_ply(ours, reconstruct(points, kStepM, options.threads).mesh);
  });
  const ProgramCost cost = run_program({settings.poissonrecon, "--in", in, "--out", theirs,
                                        "--width", std::to_string(kStepM), "--pointWeight", "4"},
                                       work / "poissonrecon.log");
  Mesh their_mesh = read_ply_mesh(theirs);
  their_mesh.origin = hills.origin();
  const Mesh our_mesh = read_ply_mesh(ours);
  const HillsAccuracy a = measure_accuracy(hills, their_mesh, kBorderM, kFarM);
  const HillsAccuracy b = measure_accuracy(hills, our_mesh, kBorderM, kFarM);
  const MeshDistance apart = distance_between(our_mesh, their_mesh, hills, kStepM, options.threads);
  std::printf(
      "PoissonRecon %.1f M points: %.1f s, %.2f GiB, %.2f M triangles, rms %.4f m; ours, file to "
      "file: %.1f s, rms %.4f m; %.5f of ours within 0.2 steps of theirs, 99.9 %% within %.4f m\n",
      millions, cost.seconds, gib(cost.peak_resident_bytes),
      1e-6 * static_cast<double>(their_mesh.triangles.size()), a.rms_m, our_s, b.rms_m,
      apart.share_within_fifth_step, apart.at_999_m);
  const std::string name = "_" + size_name(millions);
  result.figure("ratio_poissonrecon" + name, cost.seconds / our_s);
  result.figure("poissonrecon_seconds" + name, cost.seconds);
  result.figure("poissonrecon_gib" + name, gib(cost.peak_resident_bytes));
  result.figure("poissonrecon_triangles" + name, static_cast<double>(their_mesh.triangles.size()));
  result.figure("poissonrecon_rms_m" + name, a.rms_m);
  result.figure("file_to_file_seconds" + name, our_s);
  result.figure("file_to_file_rms_m" + name, b.rms_m);
  result.figure("share_within_fifth_step" + name, apart.share_within_fifth_step);
  if (millions == settings.peer_millions.front())
    result.figure("ratio_poissonrecon", cost.seconds / our_s);
}

void compare_with_pcl(const Settings& settings, const Options& options, Result& result) {
  const auto count = static_cast<std::size_t>(settings.pcl_millions * 1e6);
  if (count == 0) return;
  const Hills hills(std::sqrt(static_cast<double>(count) / kDensity));
  const OrientedPoints points =
      hills.sample(count, settings.noise_m, settings.tilt_deg, options.seed, options.threads);
  // PCL's cube is 1.1 times as wide as the points.
  const int depth = static_cast<int>(std::lround(std::log2(1.1 * hills.side_m() / 0.5)));
  Mesh mesh;
  const double their_s = seconds_of([&] { mesh = pcl_poisson(points, depth); });
  Run run;
  const double our_s = seconds_of([&] { run = reconstruct(points, 0.5, options.threads); });
  const HillsAccuracy a = measure_accuracy(hills, mesh, kBorderM, kFarM);
  const HillsAccuracy b = measure_accuracy(hills, run.mesh, kBorderM, kFarM);
  std::printf(
      "PCL %.2f M points depth %d: %.1f s, %.2f M triangles, rms %.4f m; ours %.2f s, rms "
      "%.4f m\n",
      settings.pcl_millions, depth, their_s, 1e-6 * static_cast<double>(mesh.triangles.size()),
      a.rms_m, our_s, b.rms_m);
  result.figure("ratio_pcl", their_s / our_s);
  result.figure("pcl_rms_m", a.rms_m);
}

void add_steps(const Run& run, const std::string& name, Result& result) {
  for (const StepSeconds& step : run.report.seconds) {
    std::string key = step.step;
    std::replace(key.begin(), key.end(), ' ', '_');
    result.figure("step_seconds_" + key + "_" + name, step.seconds);
  }
  result.figure("step_seconds_extracting_" + name, run.extract_s);
}

void measure_case(const Settings& settings, const Options& options, double millions, int depth,
                  Result& result) {
  const auto count = static_cast<std::size_t>(millions * 1e6);
  const Hills hills(std::sqrt(static_cast<double>(count) / kDensity));
  const OrientedPoints points =
      hills.sample(count, settings.noise_m, settings.tilt_deg, options.seed, options.threads);
  const Run run = reconstruct(points, kTileM / std::ldexp(1.0, depth), options.threads);
  const HillsAccuracy accuracy = measure_accuracy(hills, run.mesh, kBorderM, kFarM);
  print(run, millions, depth, &accuracy);
  const std::string name = size_name(millions) + "_d" + std::to_string(depth);
  result.figure("seconds_" + name, run.solve_s + run.extract_s);
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
    result.figure("seconds_" + name, run.solve_s + run.extract_s);
  }
}

/// Oriented points from a file.
void measure_points(const Settings& settings, const Options& options, Result& result) {
  if (settings.points.empty()) return;
  const OrientedPoints points = read_ply_points(settings.points);
  const Run run = reconstruct(points, kStepM, options.threads);
  print(run, 1e-6 * static_cast<double>(points.positions.size()), 11, nullptr);
  result.figure("seconds_points", run.solve_s + run.extract_s);
  result.figure("gib_points", run.gib);
  result.figure("triangles_points", static_cast<double>(run.mesh.triangles.size()));
  add_steps(run, "points", result);
}

void measure(Settings settings, const Options& options, Result& result) {
  if (options.quick) {
    settings.millions = {0.5};
    settings.depths = {11};
    settings.pcl_millions = 0.02;
    settings.peer_millions = {0.1};
    settings.scaling_millions = 0.1;
  }
  // Ever more points, so that the peak of the process is always the latest run's own.
  std::sort(settings.millions.begin(), settings.millions.end());
  std::sort(settings.depths.rbegin(), settings.depths.rend());
  for (const double millions : settings.millions)
    measure_case(settings, options, millions, settings.depths.front(), result);
  for (std::size_t d = 1; d < settings.depths.size(); ++d)
    measure_case(settings, options, settings.millions.back(), settings.depths[d], result);
  measure_threads(settings, options, result);
  measure_points(settings, options, result);
  compare_with_pcl(settings, options, result);
  if (!settings.poissonrecon.empty()) {
    for (const double millions : settings.peer_millions)
      compare_with_poissonrecon(settings, options, millions, result);
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
        app.add_option("--pcl-millions", settings.pcl_millions, "points that PCL gets, 0: none");
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
