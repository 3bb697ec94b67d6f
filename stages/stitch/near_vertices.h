// SPDX-License-Identifier: GPL-3.0-or-later
// Nearest vertices of other tiles' borders. FLANN stays behind this.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "stages/stitch/edge_grid.h"

namespace cornice::stitch {

/// For each loose vertex, in their order: by tile, the nearest vertex of it that it may join,
/// within the tolerance. Ties go to the lesser number.
std::vector<std::map<std::uint32_t, std::uint32_t>> nearest_vertices(const LooseBorders& loose,
                                                                     double tolerance_m);

}  // namespace cornice::stitch
