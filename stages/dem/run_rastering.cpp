// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/geo/vertical_crs.h"
#include "core/io/ply.h"
#include "core/io/raster_file.h"
#include "stages/dem/command.h"
#include "stages/dem/layers.h"
#include "stages/dem/mesh_raster.h"

namespace cornice::dem {
namespace {

/// Of the memory, what blocks of the raster and meshes that several blocks need may take.
constexpr std::uint64_t kBlockShare = 4;
constexpr std::uint64_t kMeshShare = 2;
constexpr int kLargestBlock = 8192;
constexpr std::uint64_t kCacheBytes = std::uint64_t{64} << 20;

Crs crs_of(const Command& command, const std::string& text, Report& report) {
  Crs crs;
  try {
    const std::string& wanted = command.survey.crs.empty() ? text : command.survey.crs;
    if (!wanted.empty()) crs = crs_from_text(wanted);
  } catch (const UsageError& error) {
    if (!command.survey.crs.empty()) throw;
    throw InputError(command.meshes.front().string(),
                     "its CRS, " + text + ", is not known; tell it with --crs");
  }
  if (crs.empty()) {
    report.warn("the meshes have no CRS, and so the raster has none; tell it with --crs");
  } else if (!command.survey.vertical_crs.empty()) {
    crs = with_vertical(crs, command.survey.vertical_crs);
  }
  return crs;
}

RasterGrid grid_of(const Command& command, const std::vector<MeshPlace>& meshes, const Crs& crs) {
  if (command.like.empty()) return grid_around(meshes, *command.step_m);
  const RasterHead head = RasterFile(command.like).head();
  if (!head.crs.empty() && !crs.empty() && !same_crs(head.crs, crs)) {
    throw InputError(command.like.string(), "is in " + head.crs.name + ", but the meshes are in " +
                                                crs.name + "; name a raster of their system");
  }
  return {head.width, head.height, head.west, head.north, head.step};
}

/// The largest block that a share of the memory holds.
int block_side(std::uint64_t memory_bytes) {
  const auto pixels = static_cast<double>(memory_bytes / kBlockShare / Layers::kBytesPerPixel);
  const int blocks = static_cast<int>(std::sqrt(pixels)) / CogWriter::kBlockSide;
  return std::clamp(blocks * CogWriter::kBlockSide, CogWriter::kBlockSide, kLargestBlock);
}

}  // namespace

void run_rastering(const Command& command, StageContext& context) {
  Report& report = context.report;
  for (const auto& mesh : command.meshes) report.add_input(mesh);
  if (!command.like.empty()) report.add_input(command.like);
  const std::uint64_t limit = context.memory.limit_bytes();
  limit_raster_cache(std::min(kCacheBytes, limit / 8));
  std::uint64_t largest = 0;
  for (const auto& mesh : command.meshes) {
    largest = std::max(largest, std::filesystem::file_size(mesh));
  }
  // A mesh in memory is about as large as its file, and there is its copy on the raster's grid.
  context.memory.charge("the largest mesh and a block of the raster",
                        2 * largest + limit / kBlockShare);
  MeshCache cache(limit / kMeshShare);
  std::string crs_text;
  std::vector<MeshPlace> meshes;
  report.step("meshes",
              [&] { meshes = find_meshes(command.meshes, cache, crs_text, context.progress); });
  const Crs crs = crs_of(command, crs_text, report);
  const RasterGrid grid = grid_of(command, meshes, crs);
  LayerCounts counts;
  report.step("raster", [&] {
    counts = write_layers(command.output, grid, crs, meshes, cache, block_side(limit),
                          context.options.threads, context.progress);
  });
  if (counts.covered == 0) {
    report.warn("no pixel's centre has a surface; the meshes lie beside the raster");
  }
  report.count("meshes", meshes.size());
  report.count("pixels", counts.pixels);
  report.count("covered pixels", counts.covered);
  report.count("pixels with several layers", counts.folded);
  report.count("blocks", counts.blocks);
  report.quality("step_m", grid.step);
}

}  // namespace cornice::dem
