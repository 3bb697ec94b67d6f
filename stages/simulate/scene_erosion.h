// SPDX-License-Identifier: GPL-3.0-or-later
// Gullies, ridges and debris slopes worn into a height field by running water and rock fall.
#pragma once

#include <cstdint>

#include "stages/simulate/scene_file.h"
#include "stages/simulate/scene_spline.h"

namespace cornice::simulate {

/// Wears `ground` down in place: stream power incision, slope limits by rock hardness, slight
/// creep. Water leaves at the lattice's border, whose heights stay. Coarse to fine, from 4 x the
/// lattice's step. One thread, so always the same result.
void erode(PlanField& ground, const ErosionShape& erosion, std::uint64_t seed);

}  // namespace cornice::simulate
