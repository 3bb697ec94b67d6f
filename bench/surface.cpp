// SPDX-License-Identifier: GPL-3.0-or-later
// How far our surface lies from the ground that was flown over, and what a DEM makes of it.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/bench_json.h"
#include "bench/programs.h"
#include "bench/surface/accuracy.h"
#include "bench/surface/ground.h"
#include "core/io/ply.h"
#include "stages/poisson/band.h"
#include "stages/poisson/extract.h"
#include "stages/poisson/solve.h"

namespace {

using namespace cornice;
using namespace cornice::bench;

constexpr double kHeightMarginM = 16.0;

struct Settings {
  std::vector<std::string> scenes{"alp", "cliff"};
  double size_m = 200.0;
  double density = 20.0;
  double noise_m = 0.03;
  double step_m = 0.5;
  double weld = ExtractOptions{}.weld;
  std::filesystem::path meshes, poissonrecon;
};

/// The mesh of a ground in one piece.
Mesh reconstruct(const Ground& ground, const Settings& settings, int threads) {
  SolveOptions options;
  options.lattice.step_m = settings.step_m;
  options.threads = threads;
  Box3d domain;
  for (const Vec3f p : ground.points.positions) {
    domain.add(ground.points.origin + p.cast<double>());
  }
  domain.min.z -= kHeightMarginM, domain.max.z += kHeightMarginM;
  const Solution solved = solve_poisson(ground.points, domain, options, no_progress());
  ExtractOptions extract;
  extract.window = lattice_box(ground.extent, options.lattice);
  extract.threads = threads;
  extract.weld = settings.weld;
  const auto node = [&](double z) {
    return static_cast<std::int32_t>(std::floor(z / settings.step_m));
  };
  return extract_surface(FieldValues(solved.field, node(domain.min.z), node(domain.max.z)),
                         options.lattice, extract)
      .mesh;
}

void report(const std::string& name, const Accuracy& a, Result& result) {
  std::printf(
      "%-14s rms %.4f m (%zu), on overhangs %.4f m (%zu); back %.4f, %.4f m; there %.4f, "
      "of %.0f m2 of overhangs %.4f\n",
      name.c_str(), a.rms, a.samples, a.rms_overhang, a.overhang_samples, a.rms_back,
      a.rms_back_overhang, a.area_share, a.overhang_area_m2, a.overhang_area_share);
  result.figure("rms_m_" + name, a.rms);
  result.figure("rms_overhang_m_" + name, a.rms_overhang);
  result.figure("rms_back_m_" + name, a.rms_back);
  result.figure("rms_back_overhang_m_" + name, a.rms_back_overhang);
  result.figure("area_share_" + name, a.area_share);
  result.figure("overhang_area_share_" + name, a.overhang_area_share);
  result.figure("overhang_area_m2_" + name, a.overhang_area_m2);
}

/// What PoissonRecon makes of the same points, at the same width of the finest cells.
Mesh poissonrecon_mesh(const Ground& ground, const Settings& settings,
                       const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  const std::filesystem::path in = folder / "points.ply", out = folder / "mesh.ply";
  write_ply(in, ground.points);
  run_program({settings.poissonrecon, "--in", in, "--out", out, "--width",
               std::to_string(settings.step_m), "--pointWeight", "4"},
              folder / "poissonrecon.log");
  Mesh mesh = read_ply_mesh(out);
  mesh.origin = ground.points.origin;
  return mesh;
}

/// The worst of all scenes counts.
void take_worst(Accuracy& worst, const Accuracy& a) {
  worst.rms = std::max(worst.rms, a.rms);
  worst.rms_overhang = std::max(worst.rms_overhang, a.rms_overhang);
  worst.rms_back = std::max(worst.rms_back, a.rms_back);
  worst.overhang_area_share = std::min(worst.overhang_area_share, a.overhang_area_share);
}

void measure(Settings settings, const Options& options, Result& result) {
  if (options.quick) settings.size_m = std::min(settings.size_m, 60.0);
  const ScratchFolder work("surface");
  Accuracy worst, worst_dem;
  worst.overhang_area_share = worst_dem.overhang_area_share = 1.0;
  for (const std::string& scene : settings.scenes) {
    GroundPlan plan;
    plan.scene = std::filesystem::path(CORNICE_SCENES) / (scene + ".yaml");
    plan.size_m = settings.size_m;
    plan.density = settings.density;
    plan.noise_m = settings.noise_m;
    plan.seed = options.seed;
    const Ground ground = fly_ground(plan, own_folder(), work / scene, options.threads);
    AccuracyOptions judged;
    judged.threads = options.threads;
    const AccuracyJudge judge(ground, judged);
    const Mesh mesh = reconstruct(ground, settings, options.threads);
    if (!settings.meshes.empty()) write_ply(settings.meshes / (scene + ".ply"), mesh);
    const Accuracy ours = judge.judge(mesh);
    const Accuracy dem = judge.judge(dem_mesh(ground, settings.step_m));
    report(scene, ours, result);
    report("dem_" + scene, dem, result);
    if (!settings.poissonrecon.empty()) {
      const Mesh theirs = poissonrecon_mesh(ground, settings, work / "poissonrecon");
      report("poissonrecon_" + scene, judge.judge(theirs), result);
    }
    take_worst(worst, ours);
    take_worst(worst_dem, dem);
  }
  result.figure("rms_m", worst.rms);
  result.figure("rms_overhang_m", worst.rms_overhang);
  result.figure("rms_back_m", worst.rms_back);
  result.figure("overhang_area_share", worst.overhang_area_share);
  result.figure("dem_rms_overhang_m", worst_dem.rms_overhang);
  result.figure("dem_overhang_area_share", worst_dem.overhang_area_share);
  result.parameter("size_m", settings.size_m);
  result.parameter("density", settings.density);
  result.parameter("noise_m", settings.noise_m);
  result.parameter("step_m", settings.step_m);
  result.parameter("weld", settings.weld);
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  return run(
      "surface", "Distance of our surface from the simulated ground", argc, argv,
      [&](CLI::App& app) {
        app.add_option("--scenes", settings.scenes, "of samples/scenes")->delimiter(',');
        app.add_option("--size-m", settings.size_m, "side of the square flown over, whole metres");
        app.add_option("--density", settings.density, "points per square metre");
        app.add_option("--noise-m", settings.noise_m, "standard deviation of a point");
        app.add_option("--step-m", settings.step_m, "lattice step");
        app.add_option("--weld", settings.weld, "of the extraction");
        app.add_option("--meshes", settings.meshes, "folder for the meshes");
        app.add_option("--peer-poissonrecon", settings.poissonrecon, "the program")
            ->check(CLI::ExistingFile);
      },
      [&](const Options& options, Result& result) { measure(settings, options, result); });
}
