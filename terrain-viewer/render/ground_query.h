// SPDX-License-Identifier: GPL-3.0-or-later
// Where a vertical line meets the triangles of a packed cell.
#pragma once

#include <vector>

#include "hlod/lattice.h"
#include "terrain-viewer/stream/packed_cell.h"

namespace cornice::viewer {

/// Appends the heights, in steps of the cell's level from the lattice's origin, of all triangles of
/// the cell over the place (x, y), steps likewise. lowest: that of the cell's node.
void heights_at(const PackedCell& cell, hlod::LatticePoint lowest, double x, double y,
                std::vector<double>& heights);

}  // namespace cornice::viewer
