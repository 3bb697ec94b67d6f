// SPDX-License-Identifier: GPL-3.0-or-later
// Which part of every level a job of one region builds, so that the jobs' results join into what
// one job would have made.
#pragma once

#include <cstdint>
#include <vector>

#include "hlod/build.h"

namespace cornice::hlod {

/// Columns [first, last) of cells along x.
struct Columns {
  std::int32_t first = 0, last = 0;
  bool contains(std::int32_t i) const { return i >= first && i < last; }
  Columns grown() const { return {first - 1, last + 1}; }
};

/// Region `index` of `count`, counted from 0. It owns whole columns of cells of `level`, and all
/// finer cells in them. To simplify those it needs whole blocks, and so some cells of its
/// neighbours: the same blocks are then simplified by both, to the same bytes.
///
///   level        |  owned  |                every level's blocks reach a little farther
///   level + 1  |. owned .|
///   finest     |.. owned ...|
struct Region {
  int level = 0;
  Columns owned;  ///< of `level`
  /// Per level; empty below `level`. Cells in the columns beside them are needed, too, to know who
  /// shares vertices.
  std::vector<Columns> needed;

  /// Whether the cell, of this or a finer level, is the region's to store.
  bool owns(const CellKey& cell) const;
};

/// Throws UsageError where there are not as many columns of cells as regions.
Region plan_region(const Header& header, const Box3d& box, int block_side, int index, int count);

}  // namespace cornice::hlod
