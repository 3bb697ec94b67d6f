// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/poisson/run.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>

#include "bench/bench_json.h"
#include "core/base/memory.h"
#include "stages/poisson/band.h"
#include "stages/poisson/extract.h"
#include "stages/poisson/samples.h"

namespace cornice::bench {
namespace {

/// What two such cores do at best: bytes streamed, nodes relaxed with 27 taps.
constexpr double kBytesPerSecond = 14e9, kNodesPerSecond = 450e6;
/// Four colours to and fro, the last one once.
constexpr double kSweepsPerPass = 7.0 / 4.0;
constexpr double kHeightMarginM = 16.0;
constexpr double kPointBytes = 28.0, kWordBytes = 8.0;  ///< position, normal, quality; sorting key
constexpr double kSampleBytes = sizeof(poisson::Sample);
constexpr double kNodeBytes = 4.0, kBrickBytes = kNodeBytes * kBrickNodes;
/// Of a brick beside its nodes: key, neighbours, active rows.
constexpr double kBrickHeadBytes = 12.0 + 108.0 + 64.0;

double cpu_now() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Sums over levels.
struct Counts {
  double cells = 0.0, bricks = 0.0, relaxed = 0.0, finest_cells = 0.0;
};

Counts count(const SolveReport& report) {
  Counts counts;
  for (const LevelReport& level : report.levels) {
    counts.cells += static_cast<double>(level.cells);
    counts.bricks += static_cast<double>(level.bricks);
    counts.relaxed += kSweepsPerPass * level.passes * static_cast<double>(level.unknowns);
  }
  if (!report.levels.empty()) counts.finest_cells = static_cast<double>(report.levels[0].cells);
  return counts;
}

/// Bytes that a step cannot do without: everything it is given read once, its result written once.
double least_bytes(const std::string& step, const Counts& counts, const Run& run) {
  if (step == "gathering points") {
    // Read to be placed, sorted by key, read again to be summed.
    return static_cast<double>(run.report.points) * (2.0 * kPointBytes + 2.0 * kWordBytes) +
           counts.finest_cells * kSampleBytes;
  }
  if (step == "estimating density") return 3.0 * counts.cells * kSampleBytes;
  if (step == "choosing nodes")
    return counts.cells * kSampleBytes + counts.bricks * (2.0 * kBrickBytes + kBrickHeadBytes);
  if (step == "splatting normals")
    return counts.cells * kSampleBytes + 2.0 * counts.bricks * kBrickBytes;
  if (step == "finding the level of the surface")
    return counts.finest_cells * kSampleBytes + counts.bricks * kBrickBytes;
  if (step == "extracting") {
    return counts.bricks * kBrickBytes +
           static_cast<double>(run.mesh.positions.size()) * 2.0 * sizeof(Vec3f) +
           static_cast<double>(run.mesh.triangles.size()) * 12.0;
  }
  return 0.0;
}

}  // namespace

Run reconstruct(const OrientedPoints& points, double step_m, int threads) {
  Run run;
  SolveOptions options;
  options.lattice.step_m = step_m;
  options.threads = threads;
  Box3d domain;
  for (const Vec3f p : points.positions) domain.add(points.origin + p.cast<double>());
  Solution solved;
  const double begin = cpu_now();
  run.solve_s = seconds_of([&] { solved = solve_poisson(points, domain, options, no_progress()); });
  ExtractOptions extract;
  extract.window = lattice_box(domain.plan(), options.lattice);
  extract.threads = threads;
  const auto node = [&](double z) { return static_cast<std::int32_t>(std::floor(z / step_m)); };
  run.extract_s = seconds_of([&] {
    const FieldValues values(solved.field, node(domain.min.z - kHeightMarginM),
                             node(domain.max.z + kHeightMarginM));
    run.mesh = extract_surface(values, options.lattice, extract).mesh;
  });
  run.cpu_s = cpu_now() - begin;
  run.report = std::move(solved.report);
  run.gib = static_cast<double>(peak_resident_bytes()) / 0x1p30;
  return run;
}

std::vector<StepBound> step_bounds(const Run& run) {
  const Counts counts = count(run.report);
  std::vector<StepSeconds> steps = run.report.seconds;
  steps.push_back({"extracting", run.extract_s});
  std::vector<StepBound> bounds;
  for (const StepSeconds& step : steps) {
    const double bound_s = step.step == "solving"
                               ? counts.relaxed / kNodesPerSecond
                               : least_bytes(step.step, counts, run) / kBytesPerSecond;
    bounds.push_back({step.step, step.seconds, bound_s});
  }
  return bounds;
}

void print(const Run& run, const std::string& name) {
  std::printf(
      "ours %s: solve %.2f s, extract %.2f s, %.2f s of processors, peak so far %.2f GiB, "
      "%.2f M triangles\n",
      name.c_str(), run.solve_s, run.extract_s, run.cpu_s, run.gib,
      1e-6 * static_cast<double>(run.mesh.triangles.size()));
  std::printf("  %-34s %8s %8s %6s\n", "step", "seconds", "bound", "times");
  for (const StepBound& step : step_bounds(run)) {
    std::printf("  %-34s %8.2f %8.2f %6.1f\n", step.step.c_str(), step.seconds, step.bound_s,
                step.bound_s > 0.0 ? step.seconds / step.bound_s : 0.0);
  }
  std::fflush(stdout);
}

}  // namespace cornice::bench
