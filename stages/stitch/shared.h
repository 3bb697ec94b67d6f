// SPDX-License-Identifier: GPL-3.0-or-later
// Attributes of vertices that several tiles have: one value for all of them.
#pragma once

#include <vector>

#include "core/mesh/mesh.h"
#include "stages/stitch/border.h"
#include "stages/stitch/plan.h"

namespace cornice::stitch {

/// Per class of the plan: the mean over its places, each tile counting once, so that no edge shows
/// in the shading; of the code "source" the largest. Tiles without an attribute have no say in it.
/// `normals` is zero where no tile
/// has normals, or where they cancel out.
struct SharedAttributes {
  std::vector<Vec3f> normals;
  std::vector<FloatProperty> floats;
  std::vector<ByteProperty> bytes;
};
SharedAttributes share_attributes(const Borders& borders, const Plan& plan);

}  // namespace cornice::stitch
