// SPDX-License-Identifier: GPL-3.0-or-later
// How far our surface lies from the ground that was flown over, and what a DEM makes of it.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <numbers>
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
  double point_weight = SolveOptions{}.point_weight;
  bool split = false;
  std::filesystem::path meshes, poissonrecon;
};

/// What a reconstruction is given: the points as flown, or better ones.
struct Case {
  const char* suffix;
  Known known;
};
constexpr std::array kCases{Case{"", Known::kNothing}, Case{"_true_normals", Known::kNormals},
                            Case{"_true_places", Known::kPlaces}, Case{"_true_both", Known::kBoth}};

/// The mesh of a ground in one piece.
Mesh reconstruct(const OrientedPoints& points, const Box2d& extent, const Settings& settings,
                 int threads) {
  SolveOptions options;
  options.lattice.step_m = settings.step_m;
  options.point_weight = settings.point_weight;
  options.threads = threads;
  Box3d domain;
  for (const Vec3f p : points.positions) domain.add(points.origin + p.cast<double>());
  domain.min.z -= kHeightMarginM, domain.max.z += kHeightMarginM;
  const Solution solved = solve_poisson(points, domain, options, no_progress());
  ExtractOptions extract;
  extract.window = lattice_box(extent, options.lattice);
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

/// How our surface errs on each part of the ground.
void report_parts(const std::string& name, const std::vector<ErrorPart>& parts) {
  std::printf("  %-24s %-14s %9s %9s %9s\n", name.c_str(), "part", "samples", "rms m", "mean m");
  for (const ErrorPart& part : parts)
    std::printf("  %-24s %-14s %9zu %9.4f %+9.4f\n", "", part.name.c_str(), part.samples, part.rms,
                part.mean);
}

/// How far the estimated normals are from the ground's, in degrees.
void report_normals(const Ground& ground, const std::string& name, int threads, Result& result) {
  const OrientedPoints truth = with_known(ground, Known::kNormals, threads);
  std::array<std::vector<double>, 2> angles;
  for (std::size_t p = 0; p < truth.normals.size(); ++p) {
    const Vec3d own = ground.points.normals[p].cast<double>(), n = truth.normals[p].cast<double>();
    angles[n.z < 0.0].push_back(std::atan2(norm(cross(own, n)), dot(own, n)) * 180.0 /
                                std::numbers::pi);
  }
  for (const bool overhang : {false, true}) {
    std::vector<double>& of = angles[overhang];
    if (of.empty()) continue;
    std::sort(of.begin(), of.end());
    double squares = 0.0;
    for (const double a : of) squares += a * a;
    const double rms = std::sqrt(squares / static_cast<double>(of.size()));
    const auto at = [&](double share) {
      return of[static_cast<std::size_t>(share * static_cast<double>(of.size() - 1))];
    };
    std::printf(
        "  normals of %s %s: %zu, off by %.2f degrees rms, median %.2f, 90 %% %.2f, "
        "99 %% %.2f\n",
        name.c_str(), overhang ? "on overhangs" : "elsewhere", of.size(), rms, at(0.5), at(0.9),
        at(0.99));
    result.figure((overhang ? "normals_overhang_rms_deg_" : "normals_rms_deg_") + name, rms);
  }
}

/// A mesh, and what making it took from file to file.
struct Made {
  Mesh mesh;
  double seconds = 0.0, cpu_seconds = 0.0;
};

Made ours_from_file(const std::filesystem::path& in, const std::filesystem::path& out,
                    const Box2d& extent, const Settings& settings, int threads) {
  Made made;
  const std::clock_t before = std::clock();
  made.seconds = seconds_of([&] {
    made.mesh = reconstruct(read_ply_points(in), extent, settings, threads);
    write_ply(out, made.mesh);
  });
  made.cpu_seconds = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
  return made;
}

/// What PoissonRecon makes of the same points, at the same width of the finest cells.
Made theirs_from_file(const std::filesystem::path& in, const std::filesystem::path& out,
                      Vec3d origin, const Settings& settings) {
  const ProgramCost cost = run_program({settings.poissonrecon, "--in", in, "--out", out, "--width",
                                        std::to_string(settings.step_m), "--pointWeight", "4"},
                                       out.string() + ".log");
  Made made{read_ply_mesh(out), cost.seconds, cost.cpu_seconds};
  made.mesh.origin = origin;
  return made;
}

void report_cost(const std::string& name, const Made& made, Result& result) {
  std::printf("%-14s file to file %.1f s, %.1f s of processors, %.2f M triangles\n", name.c_str(),
              made.seconds, made.cpu_seconds,
              1e-6 * static_cast<double>(made.mesh.triangles.size()));
  std::fflush(stdout);
  result.figure("file_to_file_seconds_" + name, made.seconds);
  result.figure("file_to_file_cpu_seconds_" + name, made.cpu_seconds);
  result.figure("triangles_" + name, static_cast<double>(made.mesh.triangles.size()));
}

/// Reconstructs a ground from its points, or what is known better of them, and judges. With
/// PoissonRecon both programs get the same file.
Accuracy measure_case(const std::string& name, const Ground& ground, Known known,
                      const AccuracyJudge& judge, const Settings& settings, int threads,
                      Result& result) {
  const OrientedPoints points = with_known(ground, known, threads);
  Made ours;
  if (settings.poissonrecon.empty()) {
    ours.mesh = reconstruct(points, ground.extent, settings, threads);
  } else {
    const ScratchFolder work("surface-peer");
    write_ply(work / "points.ply", points);
    ours = ours_from_file(work / "points.ply", work / "ours.ply", ground.extent, settings, threads);
    const Made theirs =
        theirs_from_file(work / "points.ply", work / "theirs.ply", points.origin, settings);
    report_cost(name, ours, result);
    report_cost("poissonrecon_" + name, theirs, result);
    report("poissonrecon_" + name, judge.judge(theirs.mesh), result);
    if (settings.split) report_parts("poissonrecon_" + name, judge.parts(theirs.mesh));
    result.figure("ratio_poissonrecon_" + name, theirs.seconds / ours.seconds);
    result.figure("cpu_ratio_poissonrecon_" + name, theirs.cpu_seconds / ours.cpu_seconds);
  }
  const Accuracy accuracy = judge.judge(ours.mesh);
  report(name, accuracy, result);
  if (settings.split) report_parts(name, judge.parts(ours.mesh));
  if (!settings.meshes.empty()) {
    write_ply(settings.meshes / (name + ".ply"), ours.mesh);
    write_ply(settings.meshes / (name + ".points.ply"), points);
  }
  return accuracy;
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
    const Accuracy dem = judge.judge(dem_mesh(ground, settings.step_m));
    report("dem_" + scene, dem, result);
    if (settings.split) report_normals(ground, scene, options.threads, result);
    for (const Case& given : kCases) {
      if (given.known != Known::kNothing && !settings.split) continue;
      const Accuracy ours = measure_case(scene + given.suffix, ground, given.known, judge, settings,
                                         options.threads, result);
      if (given.known == Known::kNothing) take_worst(worst, ours);
    }
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
  result.parameter("point_weight", settings.point_weight);
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
        app.add_option("--point-weight", settings.point_weight, "of the solver");
        app.add_flag(
            "--split", settings.split,
            "also with the ground's own normals, with points on it and with both; by parts");
        app.add_option("--meshes", settings.meshes, "folder for the meshes and their points")
            ->check(CLI::ExistingDirectory);
        app.add_option("--peer-poissonrecon", settings.poissonrecon, "the program")
            ->check(CLI::ExistingFile);
      },
      [&](const Options& options, Result& result) { measure(settings, options, result); });
}
