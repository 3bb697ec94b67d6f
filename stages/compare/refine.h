// SPDX-License-Identifier: GPL-3.0-or-later
// Large triangles cut up, so that colours of vertices show what lies between them.
#pragma once

#include <vector>

#include "stages/compare/surface.h"

namespace cornice::compare {

/// Halves every edge longer than `longest_m` until none is left: a wall of a DEM is one triangle
/// from top to bottom, and what lies before its middle would not be seen. Edges are halved by their
/// length alone, so neighbours stay neighbours. The surface stays where it is; `marks`, where not
/// empty, has a byte a triangle and goes along.
void refine_long_edges(Surface& surface, std::vector<std::uint8_t>& marks, float longest_m);

}  // namespace cornice::compare
