// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/viewer/made_hierarchy.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "bench/grid_triangles.h"
#include "bench/value_noise.h"
#include "core/base/parallel.h"
#include "core/mesh/mesh.h"
#include "hlod/build.h"
#include "hlod/build_disk.h"
#include "hlod/file.h"

namespace cornice::bench {
namespace {

/// A tile of the height field: cells x cells squares of 1 m from (west, south) on, normals from
/// differences of heights, so that neighbours have the same along their border.
Mesh make_tile(int west, int south, int cells, std::uint64_t seed, int threads) {
  const auto side = static_cast<std::size_t>(cells) + 1, wide = side + 2;
  std::vector<float> heights(wide * wide);
  parallel_for(wide, 4, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin * wide; i < end * wide; ++i)
      heights[i] = static_cast<float>(mountain(west - 1.0 + static_cast<double>(i % wide),
                                               south - 1.0 + static_cast<double>(i / wide), seed));
  });
  Mesh mesh;
  mesh.origin = {2'600'000, 1'200'000, 1500};
  mesh.positions.reserve(side * side);
  mesh.normals.reserve(side * side);
  for (std::size_t row = 0; row < side; ++row) {
    for (std::size_t column = 0; column < side; ++column) {
      const std::size_t i = (row + 1) * wide + column + 1;
      mesh.positions.push_back({static_cast<float>(west) + static_cast<float>(column),
                                static_cast<float>(south) + static_cast<float>(row), heights[i]});
      mesh.normals.push_back(normalized(Vec3f{0.5f * (heights[i - 1] - heights[i + 1]),
                                              0.5f * (heights[i - wide] - heights[i + wide]), 1}));
    }
  }
  mesh.triangles = grid_triangles(side);
  return mesh;
}

}  // namespace

void make_hierarchy(const std::filesystem::path& path, std::uint64_t triangles,
                    const std::filesystem::path& folder, std::uint64_t seed, int threads) {
  constexpr int kTileCells = 1024;
  const int side = static_cast<int>(std::sqrt(static_cast<double>(triangles) / 2.0));
  const int tiles = (side + kTileCells - 1) / kTileCells, cells = side / tiles;
  const hlod::BuildOptions options;
  // What planning asks for is known without looking at the tiles: their box, with room for heights.
  hlod::InputSummary input;
  input.triangles =
      std::uint64_t(tiles) * std::uint64_t(tiles) * 2 * std::uint64_t(cells) * std::uint64_t(cells);
  const double metres = tiles * cells;
  input.box = {{2'600'000, 1'200'000, 900}, {2'600'000 + metres, 1'200'000 + metres, 2100}};
  input.plan_area_m2 = metres * metres;
  input.area_m2 = 1.5 * input.plan_area_m2;
  const hlod::Header header = hlod::plan_header(input, options);
  const hlod::WorkFolder work(folder / "work", "bench-viewer");
  {
    hlod::DiskLeaves leaves(work, header, options.max_pieces, threads);
    for (int tile = 0; tile < tiles * tiles; ++tile)
      leaves.add(make_tile(tile % tiles * cells, tile / tiles * cells, cells, seed, threads));
    leaves.finish(no_progress());
  }
  hlod::FileWriter writer(path, header);
  hlod::build_levels_on_disk(
      work, header, options.block, threads,
      [&](const hlod::Node& node, std::span<const std::byte> block) { writer.add(node, block); });
  writer.finish();
  work.remove();
}

}  // namespace cornice::bench
