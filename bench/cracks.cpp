// SPDX-License-Identifier: GPL-3.0-or-later
// Hierarchies seen by thousands of random cameras: whether any edge is open, or any two cells that
// touch are two levels apart.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/bench_json.h"
#include "bench/cracks/checker.h"
#include "bench/cracks/random_views.h"
#include "bench/cracks/subjects.h"
#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/mesh/surface_distance.h"

namespace {

using namespace cornice;
using namespace cornice::bench;

struct Settings {
  std::uint64_t cameras = 10'000;
  double size_m = 160.0;
  std::vector<std::filesystem::path> files;
};

/// Radii of any kind that a viewer may have: for an error on the screen, the thesis's, or any at
/// all; while cells are missing, or not.
hlod::Radii random_view(const hlod::Tree& tree, hlod::FinePoint eye, CounterRandom& random) {
  hlod::Radii radii;
  const double kind = random.uniform();
  if (kind < 0.5) {
    const double pixels = std::ldexp(0.5, static_cast<int>(random.bits() % 4));
    radii = hlod::radii_for_eye(tree, hlod::error_scale(pixels, 1280.0, 60.0), eye);
  } else if (kind < 0.75) {
    radii = hlod::radii_by_factor(tree.metric, random.uniform(1.0, 8.0));
  } else {
    radii = random_radii(tree.metric, random);
  }
  if (random.uniform() < 0.3) {
    hlod::hold_to_loaded(tree, random_residency(tree, random), eye, {}, radii);
  }
  return radii;
}

/// What is drawn now as a mesh in metres, relative to the lattice's origin.
Mesh drawn_mesh(const CrackChecker& checker, hlod::FinePoint eye) {
  const hlod::Lattice& lattice = checker.tree().lattice;
  const auto step = static_cast<float>(lattice.step(lattice.finest_level));
  Mesh mesh;
  for (const auto& corners : checker.triangles()) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const hlod::FinePoint p : corners)
      mesh.positions.push_back(step * (p + eye).cast<float>());
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

/// Largest two-sided distance of what is drawn to the finest level, as a share of the errors that
/// the drawn cells (and their parents, which they may be morphed to) are stored with.
double error_over_bound(const Hierarchy& hierarchy, std::uint64_t cameras, const Options& options) {
  CrackChecker checker(hierarchy);
  const hlod::Metric& metric = checker.tree().metric;
  hlod::Radii finest;
  for (std::size_t l = 0; l < finest.of.size(); ++l) finest.of[l] = std::int64_t{1} << 30 >> l;
  hlod::settle(finest, metric);
  checker.check({}, finest);
  const Mesh truth = drawn_mesh(checker, {});
  const TriangleTree truth_tree(truth.positions, truth.triangles, options.threads);
  double worst = 0.0;
  for (std::uint64_t i = 0; i < cameras; ++i) {
    CounterRandom random(options.seed, 2, i);
    const hlod::FinePoint eye = random_eye(checker.tree(), random);
    checker.check(eye, random_radii(metric, random));
    const Mesh mesh = drawn_mesh(checker, eye);
    if (mesh.triangles.empty() || checker.error_bound_m() <= 0.0) continue;
    const TriangleTree tree(mesh.positions, mesh.triangles, options.threads);
    const double distance = measure_distance(tree, truth_tree, 0.5f, options.threads).hausdorff_m();
    worst = std::max(worst, distance / checker.error_bound_m());
  }
  return worst;
}

struct Sum {
  Drawn drawn;
  std::uint64_t cameras_with_faults = 0;
  double parent_share = 0.0, edge_share = 0.0;
};

void add(Drawn& sum, const Drawn& d) {
  sum.cells += d.cells, sum.triangles += d.triangles, sum.degenerate += d.degenerate;
  sum.open_edges += d.open_edges, sum.crowded_edges += d.crowded_edges;
  sum.level_jumps += d.level_jumps;
}

Sum look(const Hierarchy& hierarchy, std::uint64_t cameras, const Options& options) {
  constexpr std::size_t kCamerasAtOnce = 250;
  Sum start;
  {
    const CrackChecker checker(hierarchy);
    start.parent_share = checker.parent_share(), start.edge_share = checker.edge_share();
  }
  return parallel_reduce<Sum>(
      cameras, kCamerasAtOnce, options.threads, start,
      [&](std::size_t begin, std::size_t end) {
        CrackChecker checker(hierarchy);
        Sum part;
        for (std::size_t i = begin; i < end; ++i) {
          CounterRandom random(options.seed, 1, i);
          const hlod::FinePoint eye = random_eye(checker.tree(), random);
          const Drawn drawn = checker.check(eye, random_view(checker.tree(), eye, random));
          add(part.drawn, drawn);
          part.cameras_with_faults += drawn.open_edges + drawn.level_jumps > 0 ? 1 : 0;
        }
        return part;
      },
      [](Sum& all, const Sum& part) {
        add(all.drawn, part.drawn);
        all.cameras_with_faults += part.cameras_with_faults;
      });
}

void measure(Settings settings, const Options& options, Result& result) {
  if (options.quick) settings.cameras = std::min<std::uint64_t>(settings.cameras, 600);
  std::vector<Subject> subjects;
  for (const auto& file : settings.files) {
    subjects.push_back({file.stem().string(), load_hierarchy(file)});
  }
  if (subjects.empty()) {
    const std::filesystem::path scene = std::filesystem::path(CORNICE_SCENES) / "cliff.yaml";
    subjects =
        made_subjects(scene, options.quick ? std::min(settings.size_m, 100.0) : settings.size_m,
                      options.seed, options.threads);
  }
  Drawn all;
  double worst_error = 0.0;
  const std::uint64_t each = (settings.cameras + subjects.size() - 1) / subjects.size();
  for (const Subject& subject : subjects) {
    const Sum sum = look(subject.hierarchy, each, options);
    const Drawn& d = sum.drawn;
    std::printf(
        "%-20s cameras %llu, with faults %llu; triangles %llu, vanished %llu; open edges %llu, "
        "level jumps %llu, crowded edges %llu; longest edge %.3f, way to a parent %.3f of the "
        "limit\n",
        subject.name.c_str(), static_cast<unsigned long long>(each),
        static_cast<unsigned long long>(sum.cameras_with_faults),
        static_cast<unsigned long long>(d.triangles), static_cast<unsigned long long>(d.degenerate),
        static_cast<unsigned long long>(d.open_edges),
        static_cast<unsigned long long>(d.level_jumps),
        static_cast<unsigned long long>(d.crowded_edges), sum.edge_share, sum.parent_share);
    std::fflush(stdout);
    result.figure("open_edges_" + subject.name, static_cast<double>(d.open_edges));
    const double over = error_over_bound(subject.hierarchy, options.quick ? 4 : 25, options);
    result.figure("error_over_bound_" + subject.name, over);
    worst_error = std::max(worst_error, over);
    add(all, d);
  }
  result.figure("open_edges", static_cast<double>(all.open_edges));
  result.figure("level_jumps", static_cast<double>(all.level_jumps));
  result.figure("crowded_edges", static_cast<double>(all.crowded_edges));
  result.figure("error_over_bound", worst_error);
  result.figure("cameras", static_cast<double>(each * subjects.size()));
  result.figure("vanished_share",
                static_cast<double>(all.degenerate) /
                    static_cast<double>(std::max<std::uint64_t>(1, all.triangles)));
  result.parameter("size_m", settings.size_m);
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  return run(
      "cracks", "Hierarchies drawn for random cameras", argc, argv,
      [&](CLI::App& app) {
        app.add_option("--cameras", settings.cameras, "of all subjects together");
        app.add_option("--size-m", settings.size_m, "side of the ground that is made up");
        app.add_option("--file", settings.files, "look at these .hlod files instead");
      },
      [&](const Options& options, Result& result) { measure(settings, options, result); });
}
