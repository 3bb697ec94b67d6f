// SPDX-License-Identifier: GPL-3.0-or-later
// Cells as they are stored: in parts that 16 bits can index.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hlod/build_cell.h"
#include "hlod/file.h"

namespace cornice::hlod {

/// A cell part with its parents, ready to be stored.
struct FinishedPart {
  CellMesh mesh;
  Node node;
};

/// Turns cells into parts; keeps its memory. Thread contract: one thread at a time.
class PartMaker {
 public:
  /// The parts of a cell, in the order of its triangles; none where it is empty. `parents` names
  /// for each of the cell's vertices one of `parent_data`; empty for a root.
  void add_parts(const BuildCell& cell, std::span<const std::uint32_t> parents,
                 std::span<const CellVertex> parent_data, std::vector<FinishedPart>& parts);

 private:
  bool take_whole(const BuildCell& cell, CellMesh& mesh);
  std::size_t take_part(const BuildCell& cell, std::size_t begin, CellMesh& mesh);
  void add_parents(std::span<const std::uint32_t> parents, std::span<const CellVertex> parent_data,
                   CellMesh& mesh);

  std::vector<std::uint32_t> vertex_;  ///< of the part: the cell's vertex
  std::vector<std::uint32_t> place_;   ///< of the cell's vertex, in the part
  std::vector<std::uint32_t> stamp_;   ///< part that place_ is for
  std::vector<std::uint32_t> parent_place_, parent_stamp_;
  std::uint32_t part_ = 0;
};

}  // namespace cornice::hlod
