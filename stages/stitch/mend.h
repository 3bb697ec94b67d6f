// SPDX-License-Identifier: GPL-3.0-or-later
// Mends what moving and splitting a border does to the triangles beside it.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/mesh.h"

namespace cornice::stitch {

/// Flips edges of thin or folded triangles that have a vertex of `rows`, or share an edge with one
/// that has, where both new triangles are better than the worse of the old and the surface stays
/// what it was. Open edges and all vertices stay. Returns how many edges were flipped.
std::uint64_t mend_triangles(Mesh& mesh, const std::vector<std::uint32_t>& rows);

}  // namespace cornice::stitch
