// SPDX-License-Identifier: GPL-3.0-or-later
// From meshes to a hierarchy: the frame, then level after level.
// Li 2024, "Multi-scale simplification and visualization of large 3D models", ch. 3 and 5.2.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/mesh/mesh.h"
#include "hlod/build_block.h"
#include "hlod/build_leaves.h"
#include "hlod/file.h"

namespace cornice::hlod {

/// What is known of all input before any of it is sorted.
struct InputSummary {
  Box3d box;  ///< projected CRS, metres
  std::uint64_t triangles = 0;
  double plan_area_m2 = 0, area_m2 = 0;  ///< of all triangles
  std::uint32_t attributes = 0;          ///< that any of the meshes has
  std::string crs_text;                  ///< of the first that has one
};

/// Adds one mesh. Throws InputError where its reference system is another, or where its vertices
/// are not finite; `name` is for the message.
void summarise(const Mesh& mesh, const std::string& name, int threads, InputSummary& summary);

struct BuildOptions {
  Partition partition = Partition::kQuadtree;
  double triangles_per_cell = 11000;      ///< wanted where cell_side_m is not given
  std::optional<double> cell_side_m;      ///< of the finest level
  std::optional<int> levels;              ///< otherwise as many as end in one cell
  double edge_share = 0.25;               ///< s0, above 0, at most 0.45
  int normal_bits = 8;                    ///< 8 or 10
  std::uint64_t max_pieces = 20'000'000;  ///< that long triangles may be split into
  BlockOptions block;
};

/// Origin, cell size and levels for the input. Cell sides are powers of two of a metre, so that
/// heights and grids of decimal or binary steps lie on the lattice or within half a step of it.
/// Throws InputError for no triangles at all or an extent that the lattice cannot hold.
Header plan_header(const InputSummary& input, const BuildOptions& options);

struct LevelCounts {
  std::uint64_t cells = 0, triangles = 0, vertices = 0, blocks = 0, locked_vertices = 0;
  double error_max_m = 0;
};

/// Takes a finished part; called from several threads.
using PartSink = std::function<void(FinishedPart part)>;

/// Builds all levels above the leaves, which are given in the order of their keys, and hands every
/// cell of every level to the sink. Returns counts per level. The same parts for any number of
/// threads.
std::vector<LevelCounts> build_levels(std::vector<BuildCell> leaves, const Header& header,
                                      const BlockOptions& options, int threads,
                                      const PartSink& sink, Progress& progress = no_progress());

}  // namespace cornice::hlod
