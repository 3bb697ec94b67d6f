// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes as they look from afar: every triangle filled, lit by its normals.
#pragma once

#include <vector>

#include "core/mesh/mesh.h"
#include "pipeline/pictures/view.h"

namespace cornice::pictures {

enum class MeshColour {
  kRelief,   ///< one colour, light and shade only
  kSupport,  ///< distance of the surface from the nearest measured point
};

/// Tiles of one survey in one picture, as high as the meshes need. Light comes from the north-west
/// at 45 degrees, whatever the view. Sides that look away from the viewer's side of the ground are
/// tinted red, so that a triangle turned over is seen. Vertices without `support` are grey.
/// Throws UsageError where no mesh has a triangle.
Picture mesh_picture(const std::vector<Mesh>& meshes, const View& view, MeshColour colour);

/// The colour of a support in metres: grey up to 0.5, then by its logarithm over yellow to red
/// at 10.
std::array<std::uint8_t, 3> support_colour(float support_m);

}  // namespace cornice::pictures
