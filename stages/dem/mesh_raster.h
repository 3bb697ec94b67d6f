// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes of a survey to a raster of their layers, block by block.
#pragma once

#include <cstdint>
#include <filesystem>
#include <list>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/base/vec.h"
#include "core/geo/crs.h"
#include "core/io/cog_writer.h"
#include "core/mesh/mesh.h"

namespace cornice::dem {

/// A mesh file and where it lies.
struct MeshPlace {
  std::filesystem::path path;
  Box2d box;                ///< empty where it has no triangles
  std::uint64_t bytes = 0;  ///< of the mesh in memory
};

/// Keeps the meshes read last, as far as they fit.
class MeshCache {
 public:
  explicit MeshCache(std::uint64_t limit_bytes) : limit_bytes_(limit_bytes) {}
  /// Valid until the next call. Throws InputError.
  const Mesh& get(const std::filesystem::path& path);

 private:
  struct Entry {
    std::filesystem::path path;
    Mesh mesh;
    std::uint64_t bytes = 0;
  };
  std::uint64_t limit_bytes_;
  std::uint64_t held_bytes_ = 0;
  std::list<Entry> entries_;  ///< last used first
};

/// Reads every mesh once. `crs_text` gets the CRS that all have; throws InputError where one has
/// another, and where none has a triangle.
std::vector<MeshPlace> find_meshes(const std::vector<std::filesystem::path>& paths,
                                   MeshCache& cache, std::string& crs_text, Progress& progress);

/// The grid of `step` metres whose lines are multiples of it and whose pixels cover all meshes.
/// Throws UsageError where it would have more pixels than a raster can.
RasterGrid grid_around(const std::vector<MeshPlace>& meshes, double step);

/// What a raster of layers holds.
struct LayerCounts {
  std::uint64_t pixels = 0;
  std::uint64_t covered = 0;  ///< with a surface
  std::uint64_t folded = 0;   ///< with more than one layer
  std::uint64_t blocks = 0;
};

/// Writes the bands highest, lowest, mean and layers of the meshes, atomically. Blocks have
/// `block_side` pixels a side, a multiple of CogWriter::kBlockSide. Where no surface is the heights
/// are -9999 and there are 0 layers.
LayerCounts write_layers(const std::filesystem::path& path, const RasterGrid& grid, const Crs& crs,
                         const std::vector<MeshPlace>& meshes, MeshCache& cache, int block_side,
                         int threads, Progress& progress);

}  // namespace cornice::dem
