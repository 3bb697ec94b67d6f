// SPDX-License-Identifier: GPL-3.0-or-later
// How well points support a mesh: for meshes that do not say it themselves.
#pragma once

#include "core/mesh/mesh.h"

namespace cornice::trim {

/// Sets the properties "support" (metres to the nearest point) and "density" (points/m² around that
/// point: its 8 nearest neighbours by the area of the disc that holds them) of every vertex. Throws
/// InputError where there are no points, or where both say a coordinate system and not the same.
void add_support(Mesh& mesh, const OrientedPoints& points, int threads);

}  // namespace cornice::trim
