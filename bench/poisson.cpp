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
#include "stages/poisson/band.h"
#include "stages/poisson/extract.h"
#include "stages/poisson/solve.h"

namespace {

using namespace cornice;
using namespace cornice::bench;

/// A tile of depth 11 is 1024 m wide at 0.5 m.
constexpr double kTileM = 1024.0;
constexpr double kDensity = 20.0;
constexpr double kBorderM = 5.0, kFarM = 1.0;
/// What this kind of machine does at best (two cores): bytes streamed, nodes relaxed with 27 taps.
constexpr double kNodesPerSecond = 450e6, kSweepsPerPass = 7.0 / 4.0;

struct Settings {
  std::vector<double> millions{20.4, 1, 4, 16};
  std::vector<int> depths{11, 10, 9};
  double noise_m = 0.03, tilt_deg = 2.0;
  double peer_millions = 20.4, pcl_millions = 0.25;
  std::filesystem::path poissonrecon;
};

/// One reconstruction by our engine.
struct Run {
  Mesh mesh;
  SolveReport report;
  double solve_s = 0.0, extract_s = 0.0, gib = 0.0;
  int relaxations = 0;
};

Run reconstruct(const OrientedPoints& points, double step_m, int threads) {
  Run run;
  SolveOptions options;
  options.lattice.step_m = step_m;
  options.threads = threads;
  run.relaxations = options.relaxations;
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
  run.gib = static_cast<double>(peak_resident_bytes()) / (1024.0 * 1024.0 * 1024.0);
  return run;
}

void print(const Run& run, double millions, int depth, const HillsAccuracy& accuracy) {
  std::printf(
      "ours %.2f M points depth %d: solve %.2f s, extract %.2f s, peak so far %.2f GiB, "
      "%.2f M triangles, rms %.4f m\n",
      millions, depth, run.solve_s, run.extract_s, run.gib,
      1e-6 * static_cast<double>(run.mesh.triangles.size()), accuracy.rms_m);
  for (const StepSeconds& step : run.report.seconds) {
    std::printf("  %-32s %6.2f s, %.2f M points/s\n", step.step.c_str(), step.seconds,
                1e-6 * static_cast<double>(run.report.points) / step.seconds);
    if (step.step != "solving") continue;
    double relaxed = 0.0;
    for (const LevelReport& level : run.report.levels)
      relaxed += kSweepsPerPass * run.relaxations * static_cast<double>(level.unknowns);
    std::printf("  %-32s %.0f M nodes/s, %.2f of the bound\n", "", 1e-6 * relaxed / step.seconds,
                relaxed / step.seconds / kNodesPerSecond);
  }
}

std::string name_of(double millions, int depth) {
  return std::to_string(static_cast<int>(millions)) + "m_d" + std::to_string(depth);
}

/// Both from file to file on the same points, at the same width of the finest cells.
void compare_with_poissonrecon(const Settings& settings, const Options& options, Result& result) {
  const auto count = static_cast<std::size_t>(settings.peer_millions * 1e6);
  const Hills hills(std::sqrt(static_cast<double>(count) / kDensity));
  const ScratchFolder work("poisson");
  const std::filesystem::path in = work / "points.ply", ours = work / "ours.ply",
                              theirs = work / "theirs.ply";
  write_ply(
      in, hills.sample(count, settings.noise_m, settings.tilt_deg, options.seed, options.threads));
  const double our_s = seconds_of([&] {
    const OrientedPoints points = read_ply_points(in);
    write_ply(ours, reconstruct(points, 0.5, options.threads).mesh);
  });
  const double their_s = run_program({settings.poissonrecon, "--in", in, "--out", theirs, "--width",
                                      "0.5", "--pointWeight", "4"},
                                     work / "poissonrecon.log")
                             .seconds;
  Mesh their_mesh = read_ply_mesh(theirs);
  their_mesh.origin = hills.origin();
  const HillsAccuracy a = measure_accuracy(hills, their_mesh, kBorderM, kFarM);
  const HillsAccuracy b = measure_accuracy(hills, read_ply_mesh(ours), kBorderM, kFarM);
  std::printf(
      "PoissonRecon %.1f M points: %.1f s, %.2f M triangles, rms %.4f m; ours, file to "
      "file: %.1f s, rms %.4f m\n",
      settings.peer_millions, their_s, 1e-6 * static_cast<double>(their_mesh.triangles.size()),
      a.rms_m, our_s, b.rms_m);
  result.figure("ratio_poissonrecon", their_s / our_s);
  result.figure("poissonrecon_seconds", their_s);
  result.figure("poissonrecon_rms_m", a.rms_m);
  result.figure("file_to_file_seconds", our_s);
  result.figure("file_to_file_rms_m", b.rms_m);
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

void measure_case(const Settings& settings, const Options& options, double millions, int depth,
                  Result& result) {
  const auto count = static_cast<std::size_t>(millions * 1e6);
  const Hills hills(std::sqrt(static_cast<double>(count) / kDensity));
  const OrientedPoints points =
      hills.sample(count, settings.noise_m, settings.tilt_deg, options.seed, options.threads);
  const Run run = reconstruct(points, kTileM / std::ldexp(1.0, depth), options.threads);
  const HillsAccuracy accuracy = measure_accuracy(hills, run.mesh, kBorderM, kFarM);
  print(run, millions, depth, accuracy);
  const std::string name = name_of(millions, depth);
  result.figure("seconds_" + name, run.solve_s + run.extract_s);
  result.figure("solve_seconds_" + name, run.solve_s);
  result.figure("gib_" + name, run.gib);
  result.figure("triangles_" + name, static_cast<double>(run.mesh.triangles.size()));
  result.figure("rms_m_" + name, accuracy.rms_m);
}

void measure(Settings settings, const Options& options, Result& result) {
  if (options.quick) {
    settings.millions = {0.5};
    settings.depths = {11};
    settings.pcl_millions = 0.02;
    settings.peer_millions = 0.5;
  }
  // The largest first: the peak of the process is then its own.
  for (const int depth : settings.depths)
    measure_case(settings, options, settings.millions.front(), depth, result);
  for (std::size_t i = 1; i < settings.millions.size(); ++i)
    measure_case(settings, options, settings.millions[i], settings.depths.front(), result);
  compare_with_pcl(settings, options, result);
  if (!settings.poissonrecon.empty()) compare_with_poissonrecon(settings, options, result);
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
        app.add_option("--millions", settings.millions, "of points, the largest first")
            ->delimiter(',');
        app.add_option("--depths", settings.depths, "of a tile of 1024 m, 11 is 0.5 m")
            ->delimiter(',');
        app.add_option("--noise-m", settings.noise_m, "of the points along their normals");
        app.add_option("--tilt-deg", settings.tilt_deg, "mean error of the normals");
        app.add_option("--pcl-millions", settings.pcl_millions, "points that PCL gets, 0: none");
        app.add_option("--peer-millions", settings.peer_millions, "points that PoissonRecon gets");
        app.add_option("--peer-poissonrecon", settings.poissonrecon, "the program")
            ->check(CLI::ExistingFile);
      },
      [&](const Options& options, Result& result) { measure(settings, options, result); });
}
