// SPDX-License-Identifier: GPL-3.0-or-later
// Speed, shapes and error of remeshing: a made mountain, or a mesh from a file.
#include "stages/remesh/remesh.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>

#include "bench/bench_json.h"
#include "bench/grid_triangles.h"
#include "bench/value_noise.h"
#include "core/base/memory.h"
#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/io/ply.h"

namespace {

using namespace cornice;
using namespace cornice::bench;

/// Ridges and gullies down to boulders, in metres; steep, with walls where it folds.
double mountain(double x, double y, std::uint64_t seed) {
  double z = 0.0, amplitude = 90.0, wavelength = 400.0;
  for (std::uint64_t octave = 0; octave < 8; ++octave) {
    const double n = value_noise(x / wavelength, y / wavelength, seed + octave, 7);
    z += amplitude * (octave < 5 ? 1.0 - 2.0 * std::sqrt(n * n + 0.01) : n);
    amplitude *= 0.36;
    wavelength *= 0.5;
  }
  // A wall of 40 m that winds across.
  const double s = x - 0.5 * y - 60.0 * std::sin(y / 90.0) - 150.0;
  return z + 20.0 * std::tanh(s / 3.0);
}

/// A jittered lattice of 0.38 m, with 4 mm of noise: as many triangles a
/// square metre as a reconstruction at 0.5 m, a surface as smooth as screened Poisson makes it.
Mesh make_mountain(std::size_t triangles, std::uint64_t seed, int threads) {
  constexpr double kStep = 0.38;
  const auto side = static_cast<std::size_t>(std::sqrt(static_cast<double>(triangles) / 2.0)) + 1;
  Mesh mesh;
  mesh.positions.resize(side * side);
  mesh.normals.resize(side * side, {0, 0, 1});
  parallel_for(side, 8, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      for (std::size_t column = 0; column < side; ++column) {
        const std::size_t i = row * side + column;
        CounterRandom random(seed, 1, i);
        const double x = kStep * static_cast<double>(column) + 0.1 * random.uniform(-1, 1);
        const double y = kStep * static_cast<double>(row) + 0.1 * random.uniform(-1, 1);
        mesh.positions[i] =
            Vec3d{x, y, mountain(x, y, seed) + 0.004 * random.normal()}.cast<float>();
      }
    }
  });
  mesh.triangles = grid_triangles(side);
  return mesh;
}

struct Own {
  std::filesystem::path input;
  std::filesystem::path output;
  std::size_t triangles = 6000000;
  double max_error_m = 0.05;
};

void measure(const Own& own, const Options& options, Result& figures) {
  const std::size_t count =
      options.quick ? std::min<std::size_t>(own.triangles, 300000) : own.triangles;
  const Mesh mesh = own.input.empty() ? make_mountain(count, options.seed, options.threads)
                                      : read_ply_mesh(own.input);
  remesh::Options how;
  how.threads = options.threads;
  how.max_error_m = own.max_error_m;
  const std::uint64_t before = peak_resident_bytes();
  remesh::Result result;
  const double seconds = seconds_of([&] { result = remesh::remesh(mesh, how); });
  const auto per_second = static_cast<double>(mesh.triangles.size()) / seconds;
  figures.figure("triangles_per_s", per_second);
  figures.figure("share_min_angle_20", result.figures.quality.share_min_angle_20());
  figures.figure("share_min_angle_20_inner", result.figures.inner_quality.share_min_angle_20());
  figures.figure("hausdorff_m", result.figures.hausdorff_m());
  figures.figure("triangles_out", static_cast<double>(result.mesh.triangles.size()));
  figures.figure("triangles_decimated", static_cast<double>(result.figures.decimated_triangles));
  figures.figure("mean_radius_ratio", result.figures.quality.mean_radius_ratio);
  figures.figure("smallest_angle_deg", result.figures.quality.smallest_angle_deg);
  figures.figure("repair_rounds", result.figures.repair_rounds);
  for (const remesh::Step& one : result.figures.steps) {
    figures.figure("seconds_" + one.name, one.seconds);
  }
  figures.figure("bytes_per_triangle", static_cast<double>(peak_resident_bytes() - before) /
                                           static_cast<double>(mesh.triangles.size()));
  figures.parameter("triangles", static_cast<std::int64_t>(mesh.triangles.size()));
  figures.parameter("max_error_m", own.max_error_m);
  if (!own.output.empty()) write_ply(own.output, result.mesh);
}

}  // namespace

int main(int argc, char** argv) {
  Own own;
  return run(
      "remesh", "Input triangles a second, shapes and distance of remeshing", argc, argv,
      [&](CLI::App& app) {
        app.add_option("--input", own.input, "mesh to remesh instead of the made one, .ply");
        app.add_option("--output", own.output, "where the result goes, .ply");
        app.add_option("--triangles", own.triangles, "of the made mountain");
        app.add_option("--max-error", own.max_error_m, "bound, metres");
      },
      [&](const Options& options, Result& figures) { measure(own, options, figures); });
}
