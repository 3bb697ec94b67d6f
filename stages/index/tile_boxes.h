// SPDX-License-Identifier: GPL-3.0-or-later
// Which part of the plan each tile answers for.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/base/vec.h"

namespace cornice::index {

/// A tile before its box is settled.
struct Footprint {
  Box2d bounds;                  ///< of its points
  std::optional<Box2d> nominal;  ///< what its name says
};

struct TileBoxes {
  std::vector<Box2d> boxes;  ///< one per footprint
  /// One per footprint: index of the tile that already answers for this ground, or npos.
  std::vector<std::size_t> inside;
};
inline constexpr std::size_t kNobody = static_cast<std::size_t>(-1);

/// Boxes on multiples of step_m, as index_survey describes them. The result does not depend on the
/// order of the footprints but for `inside`, where the earlier one stays.
TileBoxes lay_out(const std::vector<Footprint>& footprints, double step_m, double seam_m);

}  // namespace cornice::index
