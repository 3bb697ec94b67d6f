// SPDX-License-Identifier: GPL-3.0-or-later
// Which cell a triangle belongs to, and which block a cell is simplified in.
// Li 2024, "Multi-scale simplification and visualization of large 3D models", 3.2.3 and 3.2.4, on
// integers.
#pragma once

#include <cstdint>

#include "hlod/cell.h"

namespace cornice::hlod {

/// Cell of `level` that holds the barycentre of three points of that level's lattice. A barycentre
/// between cells belongs to the one with the higher numbers.
CellKey cell_of_triangle(LatticePoint a, LatticePoint b, LatticePoint c, int level, int cell_bits,
                         Partition partition);

/// The block of `side` x `side` (x `side`) cells that a cell of a level is simplified in. side:
/// even, at least 2. The grid of blocks is shifted so that the border of a block of one level lies
/// in the middle of a block of the next coarser one: no border stays locked twice.
///
///   level l    |   .   .   .   |   .   .   .   |       side 4: a block's border every 4 cells
///   level l-1  .       .   |   .       .       .   |
CellKey block_of_cell(const CellKey& cell, int side, Partition partition);

}  // namespace cornice::hlod
