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
#include "hlod/build_memory.h"
#include "hlod/file.h"

namespace cornice::hlod {

/// What is known of all input before any of it is sorted.
struct InputSummary {
  Box3d box;  ///< projected CRS, metres
  std::uint64_t triangles = 0;
  double plan_area_m2 = 0, area_m2 = 0;  ///< of all triangles
  std::uint32_t attributes = 0;          ///< that any of the meshes has
  std::string crs_text;                  ///< of the first that has one
  /// Largest coordinate of a triangle's corner relative to its mesh's origin, metres: as coarse as
  /// floats are there.
  float farthest_m = 0;
};

/// Adds one mesh, or the next piece of one; the box is that of its triangles. Pieces that are all
/// of the same multiple of 131072 triangles but the last sum up as the whole does, bit for bit.
/// Throws InputError where its reference system is another, or where its vertices are not finite or
/// no metres; `name` is for the message.
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
/// Takes a cell of the next coarser level; called from several threads, in any order.
using CellSink = std::function<void(BuildCell cell)>;

/// The cells of one level, in memory or on disk. Safe to read from several threads, each cell by
/// one of them.
class CellSource {
 public:
  struct Info {
    CellKey key;
    float error_m = 0;
    std::uint64_t triangles = 0, vertices = 0;
  };
  virtual ~CellSource() = default;
  /// In the order of their keys.
  virtual const std::vector<Info>& infos() const = 0;
  /// The cell that infos()[index] is about; asked for once.
  virtual BuildCell take(std::size_t index) = 0;
};

/// Cells in memory.
class CellsInMemory : public CellSource {
 public:
  /// In any order. Cells that do not know who shares their vertices learn it.
  CellsInMemory(std::vector<BuildCell> cells, const Header& header, int threads);
  const std::vector<Info>& infos() const override { return infos_; }
  BuildCell take(std::size_t index) override { return std::move(cells_[index]); }

 private:
  std::vector<BuildCell> cells_;
  std::vector<Info> infos_;
};

/// Counts of cells, triangles and vertices and the largest error; no blocks.
LevelCounts count_level(const std::vector<CellSource::Info>& cells);

/// What of a level shall be built.
struct LevelTask {
  int threads = 0;
  /// Blocks to leave out; none where empty. Given the block's cells' keys.
  std::function<bool(const std::vector<CellKey>& cells)> skips;
  MemoryGate* gate = nullptr;  ///< for the blocks that are worked on at a time; none: no limit
};

/// Simplifies the cells of one level above 0. The same cells and parts for any number of threads.
LevelCounts build_level(CellSource& source, const Header& header, const BlockOptions& options,
                        const LevelTask& task, const CellSink& parents, const PartSink& parts,
                        Progress& progress = no_progress());

/// Hands over the cells of level 0, which have no parents.
LevelCounts finish_roots(CellSource& source, const PartSink& parts);

/// Builds all levels above the given cells, all of one level, in memory, and hands every part of
/// every level to the sink. Returns counts per level.
std::vector<LevelCounts> build_levels(std::vector<BuildCell> cells, const Header& header,
                                      const BlockOptions& options, int threads,
                                      const PartSink& sink, Progress& progress = no_progress());

}  // namespace cornice::hlod
