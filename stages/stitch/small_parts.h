// SPDX-License-Identifier: GPL-3.0-or-later
// Parts of the surface that are small over all tiles together. A tile alone cannot tell: what it
// has of a part may go on next door.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/mesh.h"
#include "stages/stitch/border.h"
#include "stages/stitch/plan.h"

namespace cornice::stitch {

struct SmallParts {
  std::vector<std::vector<std::uint32_t>> of_tile;  ///< parts that go, rising
  std::uint64_t count = 0;  ///< parts of the whole, those that several tiles share counted once
  double area_m2 = 0.0;     ///< of all of them
};

/// Parts of less than min_area_m2, those that `plan` joins taken together.
SmallParts find_small_parts(const Borders& borders, const Plan& plan, double min_area_m2);

/// Rows of the triangles that belong to `parts` (rising), numbered as in Border::part_areas_m2.
std::vector<std::uint32_t> triangles_of_parts(const Mesh& tile,
                                              const std::vector<std::uint32_t>& parts, int threads);

}  // namespace cornice::stitch
