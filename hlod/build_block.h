// SPDX-License-Identifier: GPL-3.0-or-later
// One step of the builder: the cells of a block in, simplified; their parents' cells out.
// Li 2024, "Multi-scale simplification and visualization of large 3D models", 3.2.4 and 3.2.5.
#pragma once

#include <vector>

#include "hlod/build_cell.h"
#include "hlod/build_parts.h"
#include "hlod/file.h"
#include "hlod/position_table.h"
#include "hlod/simplify.h"
#include "hlod/simplify_error.h"

namespace cornice::hlod {

/// How blocks are simplified.
struct BlockOptions {
  int side = 4;                  ///< cells along a block's edge, a multiple of 4
  double keep_share = 0.25;      ///< of the triangles
  double max_error_share = 1.0;  ///< no collapse moves the surface by more than this part of a cell
  double attribute_weight = 0;   ///< part of a cell's side that a change from black to white, or
                                ///< across the whole texture, counts as; 0: attributes do not count
};

/// Counts of one block.
struct BlockCounts {
  std::uint64_t triangles_in = 0, triangles_out = 0, locked_vertices = 0;
};

struct BlockResult {
  std::vector<FinishedPart> finished;  ///< the block's cells, in the order of their keys
  std::vector<BuildCell> parents;      ///< the cells of the next coarser level that lie in it
  BlockCounts counts;
};

/// Simplifies one block after the other; keeps its memory. Thread contract: one thread at a time.
class BlockBuilder {
 public:
  BlockBuilder(const Header& header, const BlockOptions& options)
      : header_(header), options_(options) {}

  /// All cells of one block, in the order of their keys; level above 0.
  BlockResult run(const std::vector<const BuildCell*>& cells);

 private:
  void assemble();
  void reserve();
  void resize_vertices(std::size_t count);
  std::uint32_t add_cell(std::size_t c, std::uint32_t count);
  std::uint32_t add_vertex(const BuildCell& cell, std::uint32_t vertex, std::uint32_t next);
  bool is_outside(const BuildCell& cell, std::uint32_t vertex) const;
  void simplify();
  void unify();
  void average();
  void make_parents(BlockResult& result);
  BuildCell make_parent(std::uint32_t parent);
  void finish_cells(BlockResult& result);

  Header header_;
  BlockOptions options_;
  const std::vector<const BuildCell*>* cells_ = nullptr;
  LatticePoint base_;  ///< coarse steps; mesh_.positions count from here
  SimplifyMesh mesh_;
  Simplifier simplifier_;
  StepError step_error_;
  PositionTable table_;
  PositionFilter filter_;
  PartMaker part_maker_;
  std::vector<std::size_t> begins_;         ///< per cell, in mesh_.triangles; one more at the end
  std::vector<CellKey> parent_keys_;        ///< cells of the next level, in their order
  std::vector<std::uint32_t> parent_cell_;  ///< per cell, in parent_keys_
  std::vector<std::uint32_t> to_;           ///< per cell's vertex, cell by cell: the block's vertex
  std::vector<std::size_t> to_begins_;      ///< per cell, in to_
  // Per vertex of the block:
  std::vector<LatticePoint> points_;    ///< steps of the cells' level
  std::vector<Float4> fine_;            ///< the same in coarse steps from base_
  std::vector<std::uint8_t> shared_;    ///< 1 where another cell may use it
  std::vector<CellVertex> data_;        ///< with coarse positions
  std::vector<Vec3f> sums_;             ///< of normals
  std::vector<std::uint32_t> left_;     ///< vertices that stay
  std::vector<std::uint32_t> kept_;     ///< vertices whose normals are new
  std::vector<std::uint32_t> place_;    ///< in the parent cell that is made
  std::vector<std::uint32_t> parents_;  ///< what it becomes, after those at one point are one
};

}  // namespace cornice::hlod
