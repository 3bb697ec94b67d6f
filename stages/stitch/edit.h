// SPDX-License-Identifier: GPL-3.0-or-later
// Carries out the plan on one tile.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/mesh/mesh.h"
#include "stages/stitch/border.h"
#include "stages/stitch/plan.h"
#include "stages/stitch/shared.h"

namespace cornice::stitch {

/// A tile after the plan.
struct EditedTile {
  Mesh mesh;
  /// Row in the mesh and class of each vertex that other tiles have, too; by row.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> shared;
  std::uint64_t flipped_edges = 0;  ///< to mend thin and folded triangles at the border
};

/// Places of the plan that each tile has: positions in Plan::places.
std::vector<std::vector<std::uint32_t>> places_by_tile(const Borders& borders, const Plan& plan);

/// `tile` is tile number `number` of `borders`; `places` are its places. What lies away from the
/// border stays as it is, and comes first in the order it had.
EditedTile edit_tile(Mesh tile, std::uint32_t number, const Borders& borders, const Plan& plan,
                     const std::vector<std::uint32_t>& places, const SharedAttributes& shared);

}  // namespace cornice::stitch
