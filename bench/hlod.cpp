// SPDX-License-Identifier: GPL-3.0-or-later
// Speed of the hierarchy's builder, and size of its files: a made mountain, or a mesh from a file.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bench/bench_json.h"
#include "bench/grid_triangles.h"
#include "bench/programs.h"
#include "bench/value_noise.h"
#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/io/ply.h"
#include "hlod/build.h"
#include "hlod/build_disk.h"
#include "hlod/file.h"
#include "hlod/simplify.h"

#ifdef CORNICE_HAS_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

namespace {

using namespace cornice;
using namespace cornice::bench;

/// A height field of 1 m steps with the normals of its surface, its corner far from the origin.
Mesh make_grid(std::size_t triangles, std::uint64_t seed, int threads) {
  const auto side = static_cast<std::size_t>(std::sqrt(static_cast<double>(triangles) / 2.0)) + 1;
  Mesh mesh;
  mesh.origin = {2'600'000, 1'200'000, 1500};
  mesh.positions.resize(side * side);
  mesh.normals.resize(side * side);
  parallel_for(side, 8, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      for (std::size_t column = 0; column < side; ++column) {
        const auto x = static_cast<double>(column), y = static_cast<double>(row);
        mesh.positions[row * side + column] = Vec3d{x, y, mountain(x, y, seed)}.cast<float>();
      }
    }
  });
  parallel_for(side, 8, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      for (std::size_t column = 0; column < side; ++column) {
        const auto z = [&](std::size_t r, std::size_t c) {
          return mesh.positions[std::min(r, side - 1) * side + std::min(c, side - 1)].z;
        };
        const float dx = z(row, column + 1) - z(row, column - (column > 0));
        const float dy = z(row + 1, column) - z(row - (row > 0), column);
        mesh.normals[row * side + column] = normalized(Vec3f{-0.5f * dx, -0.5f * dy, 1});
      }
    }
  });
  mesh.triangles = grid_triangles(side);
  return mesh;
}

struct Own {
  std::filesystem::path mesh;
  std::filesystem::path nxsbuild;
  std::string partition = "quadtree";
};

struct Times {
  double leaves = 0, levels = 0, all = 0;
};

/// From a mesh in memory to the levels; to a file as well where `path` is not empty.
Times build(const Mesh& mesh, const Own& own, int threads, const std::filesystem::path& path,
            std::vector<hlod::LevelCounts>& counts) {
  hlod::BuildOptions options;
  if (own.partition == "octree") options.partition = hlod::Partition::kOctree;
  hlod::InputSummary input;
  Times times;
  times.all = seconds_of([&] {
    hlod::summarise(mesh, "mesh", threads, input);
    const hlod::Header header = hlod::plan_header(input, options);
    hlod::LeafMaker maker(header, options.max_pieces, threads);
    hlod::LeafCounts leaf_counts;
    std::vector<hlod::BuildCell> leaves;
    times.leaves = seconds_of([&] {
      std::vector<std::vector<hlod::BuildCell>> pieces;
      pieces.push_back(maker.pieces(mesh));
      leaves = hlod::finish_leaves(std::move(pieces), header, threads, leaf_counts);
    });
    std::unique_ptr<hlod::FileWriter> writer;
    if (!path.empty()) writer = std::make_unique<hlod::FileWriter>(path, header);
    times.levels = seconds_of([&] {
      counts = hlod::build_levels(std::move(leaves), header, options.block, threads,
                                  [&](hlod::FinishedPart part) {
                                    if (writer == nullptr) return;
                                    writer->add(part.node, encode_cell(part.mesh, header));
                                  });
    });
    if (writer != nullptr) writer->finish();
  });
  return times;
}

/// The same with cells on disk.
double build_on_disk(const Mesh& mesh, const std::filesystem::path& folder, int threads) {
  hlod::BuildOptions options;
  hlod::InputSummary input;
  return seconds_of([&] {
    hlod::summarise(mesh, "mesh", threads, input);
    const hlod::Header header = hlod::plan_header(input, options);
    const hlod::WorkFolder work(folder / "work", "bench");
    hlod::DiskLeaves leaves(work, header, options.max_pieces, threads);
    leaves.add(mesh);
    leaves.finish(no_progress());
    hlod::FileWriter writer(folder / "disk.hlod", header);
    hlod::build_levels_on_disk(
        work, header, options.block, threads,
        [&](const hlod::Node& node, std::span<const std::byte> block) { writer.add(node, block); });
    writer.finish();
  });
}

struct GridError {
  double rms = 0, largest = 0;
  double folded = 0;  ///< triangles that look down
};

/// Vertical distances between a height field of 1 m steps and triangles over it, every 0.5 m.
GridError grid_error(const Mesh& grid, const std::vector<Triangle>& triangles) {
  const auto side = static_cast<int>(std::sqrt(static_cast<double>(grid.positions.size())) + 0.5);
  const auto height = [&](int x, int y) { return double{grid.positions[y * side + x].z}; };
  GridError error;
  double squares = 0, samples = 0;
  for (const Triangle& t : triangles) {
    const Vec3d a = grid.positions[t[0]].cast<double>(), b = grid.positions[t[1]].cast<double>(),
                c = grid.positions[t[2]].cast<double>();
    const double area = cross(b - a, c - a).z;
    error.folded += area <= 0;
    if (area == 0) continue;
    const auto low = [](double p, double q, double r) {
      return static_cast<int>(std::ceil(2 * std::min({p, q, r})));
    };
    const auto high = [](double p, double q, double r) {
      return static_cast<int>(std::floor(2 * std::max({p, q, r})));
    };
    for (int j = low(a.y, b.y, c.y); j <= high(a.y, b.y, c.y); ++j) {
      for (int i = low(a.x, b.x, c.x); i <= high(a.x, b.x, c.x); ++i) {
        const Vec3d p{0.5 * i, 0.5 * j, 0};
        const double u = cross(p - a, c - a).z / area, v = cross(b - a, p - a).z / area;
        if (u < -1e-9 || v < -1e-9 || u + v > 1 + 1e-9) continue;
        const int x = std::min(i / 2, side - 2), y = std::min(j / 2, side - 2);
        const double fx = p.x - x, fy = p.y - y;
        const double far = height(x + 1, y + 1), near = height(x, y);
        const double ground =
            fx >= fy ? near + fx * (height(x + 1, y) - near) + fy * (far - height(x + 1, y))
                     : near + fy * (height(x, y + 1) - near) + fx * (far - height(x, y + 1));
        const double apart = std::abs(a.z + u * (b.z - a.z) + v * (c.z - a.z) - ground);
        squares += apart * apart;
        samples += 1;
        error.largest = std::max(error.largest, apart);
      }
    }
  }
  error.rms = std::sqrt(squares / samples);
  return error;
}

void add_error(const std::string& whose, const GridError& error, double seconds, double triangles,
               Result& result) {
  result.figure(whose + "_rms_m", error.rms);
  result.figure(whose + "_max_m", error.largest);
  result.figure(whose + "_folded", error.folded);
  result.figure(whose + "_triangles_per_s", triangles / seconds);
}

/// A grid to a quarter of its triangles as one block: ours, and meshoptimizer's where it is there.
void compare_simplifiers(const Options& options, Result& result) {
  const Mesh grid = make_grid(options.quick ? 200'000 : 2'000'000, options.seed, options.threads);
  const std::size_t target = grid.triangles.size() / 4;
  hlod::SimplifyMesh mesh;
  mesh.positions = grid.positions;
  mesh.locked.assign(grid.positions.size(), 0);
  mesh.triangles = grid.triangles;
  hlod::Simplifier simplifier;
  const double seconds =
      seconds_of([&] { simplifier.run(mesh, {.target_triangles = target, .in_plan = true}); });
  std::erase_if(mesh.triangles, [](const Triangle& t) { return t[0] == hlod::kNone; });
  const auto count = static_cast<double>(grid.triangles.size());
  add_error("simplify", grid_error(grid, mesh.triangles), seconds, count, result);
#ifdef CORNICE_HAS_MESHOPTIMIZER
  std::vector<unsigned> indices;
  for (const Triangle& t : grid.triangles) indices.insert(indices.end(), t.begin(), t.end());
  std::vector<unsigned> simplified(indices.size());
  float reported = 0;
  const double peer_seconds = seconds_of([&] {
    simplified.resize(meshopt_simplify(simplified.data(), indices.data(), indices.size(),
                                       &grid.positions.front().x, grid.positions.size(),
                                       sizeof(Vec3f), 3 * target, 1e9f, 0, &reported));
  });
  std::vector<Triangle> triangles;
  for (std::size_t i = 0; i < simplified.size(); i += 3) {
    triangles.push_back({simplified[i], simplified[i + 1], simplified[i + 2]});
  }
  add_error("meshoptimizer", grid_error(grid, triangles), peer_seconds, count, result);
#endif
}

void measure(const Options& options, const Own& own, Result& result) {
  const Mesh mesh = own.mesh.empty() ? make_grid(options.quick ? 200'000 : 10'000'000, options.seed,
                                                 options.threads)
                                     : read_ply_mesh(own.mesh);
  const auto triangles = static_cast<double>(mesh.triangles.size());
  result.parameter("triangles", static_cast<std::int64_t>(mesh.triangles.size()));
  result.parameter("partition", own.partition);
  const ScratchFolder folder("hlod");
  std::vector<hlod::LevelCounts> counts;
  const Times levels = build(mesh, own, 1, {}, counts);
  result.figure("triangles_per_s_core_build", triangles / levels.levels);
  result.figure("triangles_per_s_core_leaves", triangles / levels.leaves);
  const Times whole = build(mesh, own, 1, folder / "one.hlod", counts);
  result.figure("triangles_per_s_core", triangles / whole.all);
  const Times two = build(mesh, own, 2, folder / "two.hlod", counts);
  result.figure("speedup_2_threads", whole.all / two.all);
  double all = 0;
  for (const hlod::LevelCounts& level : counts) all += static_cast<double>(level.triangles);
  result.figure("triangles_ratio", all / triangles);
  const auto bytes = static_cast<double>(std::filesystem::file_size(folder / "one.hlod"));
  result.figure("bytes_per_triangle", bytes / triangles);
  const double disk = build_on_disk(mesh, folder.path(), 1);
  result.figure("triangles_per_s_core_out_of_core", triangles / disk);
  if (!own.nxsbuild.empty()) {
    write_ply(folder / "mesh.ply", mesh);
    const ProgramCost cost = run_program({own.nxsbuild.string(), (folder / "mesh.ply").string(),
                                          "-o", (folder / "mesh.nxs").string()},
                                         folder / "nxsbuild.log");
    result.figure("ratio_nxsbuild", cost.seconds / two.all);
  }
  compare_simplifiers(options, result);
}

}  // namespace

int main(int argc, char** argv) {
  Own own;
  return run(
      "hlod", "Speed of the hierarchy's builder, size and error of its levels", argc, argv,
      [&](CLI::App& app) {
        app.add_option("--mesh", own.mesh, "PLY mesh instead of a made height field");
        app.add_option("--peer-nxsbuild", own.nxsbuild, "Nexus's builder, to be compared with");
        app.add_option("--partition", own.partition, "quadtree or octree")
            ->check(CLI::IsMember({"quadtree", "octree"}));
      },
      [&](const Options& options, Result& result) { measure(options, own, result); });
}
