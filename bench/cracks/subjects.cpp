// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/cracks/subjects.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "core/base/random.h"
#include "hlod/build.h"
#include "stages/simulate/scene.h"
#include "stages/simulate/survey.h"
#include "stages/simulate/survey_options.h"
#include "tests/support/meshes.h"

namespace cornice::bench {
namespace {

using namespace hlod;

Hierarchy build(const Mesh& mesh, Partition partition, int threads) {
  InputSummary input;
  summarise(mesh, "made up", threads, input);
  BuildOptions options;
  options.partition = partition;
  options.triangles_per_cell = 600;
  Hierarchy result;
  result.header = plan_header(input, options);
  LeafMaker maker(result.header, options.max_pieces, threads);
  std::vector<std::vector<BuildCell>> pieces;
  pieces.push_back(maker.pieces(mesh));
  LeafCounts counts = maker.counts();
  std::mutex mutex;
  std::vector<FinishedPart> parts;
  build_levels(finish_leaves(std::move(pieces), result.header, threads, counts), result.header,
               options.block, threads, [&](FinishedPart part) {
                 const std::lock_guard lock(mutex);
                 parts.push_back(std::move(part));
               });
  std::sort(parts.begin(), parts.end(), [](const FinishedPart& a, const FinishedPart& b) {
    return a.node.key != b.node.key ? a.node.key < b.node.key : a.node.part < b.node.part;
  });
  for (FinishedPart& part : parts) {
    // Through the codec, so that what is checked is what a viewer reads.
    const std::vector<std::byte> block = encode_cell(part.mesh, result.header);
    result.meshes.push_back(decode_cell(block, part.node, result.header));
    result.nodes.push_back(part.node);
  }
  return result;
}

/// Heights in steps of a centimetre, as elevation models have them, with a hole and a lake.
Mesh elevation_model(double size_m, std::uint64_t seed) {
  const int cells = static_cast<int>(size_m);
  Mesh mesh = test::height_mesh(0.0, 0.0, cells, 1.0, [&](double x, double y) {
    CounterRandom random(seed, static_cast<std::uint64_t>(x), static_cast<std::uint64_t>(y));
    const double hills = 40.0 * std::sin(0.021 * x) * std::cos(0.017 * y) +
                         9.0 * std::sin(0.11 * x + 0.07 * y) + 0.1 * random.normal();
    const bool is_lake = std::hypot(x - 0.3 * size_m, y - 0.3 * size_m) < 0.12 * size_m;
    return is_lake ? -20.0 : std::round(100.0 * hills) / 100.0;
  });
  std::erase_if(mesh.triangles, [&](const auto& t) {
    const Vec3f p = mesh.positions[t[0]];
    return std::hypot(p.x - 0.7 * size_m, p.y - 0.6 * size_m) < 0.08 * size_m;
  });
  mesh.origin = {2'600'000.0, 1'200'000.0, 0.0};
  return mesh;
}

Mesh scene_ground(const std::filesystem::path& file, double size_m, std::uint64_t seed,
                  int threads) {
  simulate::SurveyOptions survey;
  survey.scene_file = file;
  survey.seed = seed;
  survey.tile_m = std::floor(size_m);
  simulate::SceneOptions scene;
  scene.file = file, scene.seed = seed, scene.threads = threads;
  scene.extent = simulate::scene_extent(simulate::tile_grid(survey));
  const Box2d window = simulate::tile_grid(survey).extent();
  return simulate::Scene::build(scene)->ground_mesh(1.0, window);
}

}  // namespace

std::vector<Subject> made_subjects(const std::filesystem::path& scene, double size_m,
                                   std::uint64_t seed, int threads) {
  std::vector<std::pair<std::string, Mesh>> meshes;
  meshes.emplace_back("dem", elevation_model(size_m, seed));
  meshes.emplace_back("cliff", scene_ground(scene, size_m, seed, threads));
  meshes.emplace_back("overhang", test::overhang_mesh(0.7 * size_m, 0.7 * size_m, 12.0, 0.8));
  std::vector<Subject> subjects;
  for (const auto& [name, mesh] : meshes) {
    for (const Partition partition : {Partition::kQuadtree, Partition::kOctree}) {
      const std::string tree = partition == Partition::kOctree ? "_octree" : "_quadtree";
      subjects.push_back({name + tree, build(mesh, partition, threads)});
    }
  }
  return subjects;
}

}  // namespace cornice::bench
