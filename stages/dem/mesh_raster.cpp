// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/dem/mesh_raster.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "core/base/error.h"
#include "core/io/ply.h"
#include "stages/dem/layers.h"

namespace cornice::dem {
namespace {

namespace fs = std::filesystem;

constexpr float kNothing = -9999.0f;

std::uint64_t bytes_of(const Mesh& mesh) {
  return mesh.positions.size() * (sizeof(Vec3f) * 2 + Layers::kBytesPerVertex) +
         mesh.triangles.size() * 12;
}

Box2d plan_of(const Mesh& mesh) {
  Box2d box;
  if (mesh.triangles.empty()) return box;
  for (const Vec3f& p : mesh.positions) {
    box.add(mesh.origin.x + static_cast<double>(p.x), mesh.origin.y + static_cast<double>(p.y));
  }
  return box;
}

/// The pixels of a block in projected metres, half a pixel around: what a mesh must touch to
/// matter.
Box2d box_of(const RasterGrid& grid, const PixelRect& block) {
  const auto east = [&](std::int64_t col) {
    return grid.west + static_cast<double>(col) * grid.step;
  };
  const auto north = [&](std::int64_t row) {
    return grid.north - static_cast<double>(row) * grid.step;
  };
  Box2d box;
  box.add(east(block.col), north(block.row));
  box.add(east(block.end_col()), north(block.end_row()));
  return box.grown(0.5 * grid.step);
}

void write_block(CogWriter& out, const Layers& layers, const PixelRect& block) {
  const auto write = [&](int band, const std::vector<float>& values) {
    out.write(band, static_cast<int>(block.col), static_cast<int>(block.row),
              static_cast<int>(block.width), static_cast<int>(block.height), values.data());
  };
  write(0, layers.highest(kNothing));
  write(1, layers.lowest(kNothing));
  write(2, layers.mean(kNothing));
  write(3, layers.counts());
}

std::vector<PixelRect> blocks_of(const RasterGrid& grid, std::int64_t side) {
  std::vector<PixelRect> blocks;
  for (std::int64_t row = 0; row < grid.height; row += side) {
    for (std::int64_t col = 0; col < grid.width; col += side) {
      blocks.push_back(
          {col, row, std::min(side, grid.width - col), std::min(side, grid.height - row)});
    }
  }
  return blocks;
}

}  // namespace

const Mesh& MeshCache::get(const fs::path& path) {
  const auto found = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const Entry& entry) { return entry.path == path; });
  if (found != entries_.end()) {
    entries_.splice(entries_.begin(), entries_, found);
    return entries_.front().mesh;
  }
  // The file says how much is coming; what must go for it goes before.
  const PlyInfo info = read_ply_info(path);
  const std::uint64_t coming =
      info.count("vertex") * (sizeof(Vec3f) * 2 + Layers::kBytesPerVertex) +
      info.count("face") * 12;
  while (!entries_.empty() && held_bytes_ + coming > limit_bytes_) {
    held_bytes_ -= entries_.back().bytes;
    entries_.pop_back();
  }
  entries_.push_front({path, read_ply_mesh(path), coming});
  held_bytes_ += coming;
  Mesh& mesh = entries_.front().mesh;
  // Only the shape is wanted.
  mesh.normals = {};
  mesh.float_properties = {};
  mesh.byte_properties = {};
  return mesh;
}

std::vector<MeshPlace> find_meshes(const std::vector<fs::path>& paths, MeshCache& cache,
                                   std::string& crs_text, Progress& progress) {
  std::vector<MeshPlace> places;
  const fs::path* first = nullptr;
  progress.begin("meshes", paths.size());
  for (const fs::path& path : paths) {
    check_cancelled(progress);
    const Mesh& mesh = cache.get(path);
    places.push_back({path, plan_of(mesh), bytes_of(mesh)});
    progress.advance(1);
    if (mesh.triangles.empty()) continue;
    if (first == nullptr) {
      first = &path;
      crs_text = mesh.crs_text;
    } else if (mesh.crs_text != crs_text) {
      throw InputError(path.string(),
                       "is in " + (mesh.crs_text.empty() ? "no CRS" : mesh.crs_text) + ", but " +
                           first->string() + " is in " + (crs_text.empty() ? "none" : crs_text) +
                           "; name meshes of one system");
    }
  }
  progress.end();
  if (first == nullptr)
    throw InputError(paths.front().string(), "has no triangles; nothing to raster");
  return places;
}

RasterGrid grid_around(const std::vector<MeshPlace>& meshes, double step) {
  Box2d box;
  for (const MeshPlace& mesh : meshes) {
    if (mesh.box.empty()) continue;
    box.add(mesh.box.min_x, mesh.box.min_y);
    box.add(mesh.box.max_x, mesh.box.max_y);
  }
  const double west = std::floor(box.min_x / step), north = std::ceil(box.max_y / step);
  const double width = std::max(1.0, std::ceil(box.max_x / step) - west);
  const double height = std::max(1.0, north - std::floor(box.min_y / step));
  constexpr double kMost = 1e7;
  if (width > kMost || height > kMost) {
    char text[200];
    std::snprintf(text, sizeof text,
                  "the raster would have %.6g x %.6g pixels, from %.9g, %.9g to %.9g, %.9g in east "
                  "and north; say a larger one, or leave out what lies far off",
                  width, height, box.min_x, box.min_y, box.max_x, box.max_y);
    throw UsageError("--step", text);
  }
  return {static_cast<int>(width), static_cast<int>(height), west * step, north * step, step};
}

LayerCounts write_layers(const fs::path& path, const RasterGrid& grid, const Crs& crs,
                         const std::vector<MeshPlace>& meshes, MeshCache& cache, int block_side,
                         int threads, Progress& progress) {
  CogWriter out(path, grid, crs, {"highest", "lowest", "mean", "layers"}, kNothing);
  LayerCounts counts;
  counts.pixels = static_cast<std::uint64_t>(grid.width) * static_cast<std::uint64_t>(grid.height);
  const std::vector<PixelRect> blocks = blocks_of(grid, block_side);
  counts.blocks = blocks.size();
  progress.begin("blocks", blocks.size());
  for (const PixelRect& block : blocks) {
    check_cancelled(progress);
    Layers layers(grid, block);
    const Box2d box = box_of(grid, block);
    for (const MeshPlace& mesh : meshes) {
      if (!mesh.box.empty() && mesh.box.intersects(box)) layers.add(cache.get(mesh.path), threads);
    }
    counts.covered += layers.pixels_with(1);
    counts.folded += layers.pixels_with(2);
    write_block(out, layers, block);
    progress.advance(1);
  }
  progress.end();
  out.commit();
  return counts;
}

}  // namespace cornice::dem
