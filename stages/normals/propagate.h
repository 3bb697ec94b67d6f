// SPDX-License-Identifier: GPL-3.0-or-later
// Passes the side of settled normals on to neighbours that beams alone could not settle.
#pragma once

#include <span>

#include "stages/normals/orient.h"

namespace cornice::normals {

/// How two oriented normals agree across the chord d (from one point to the other) of a smooth
/// surface, -1..1: the second normal mirrored in the plane that halves d, times the first. 1 on a
/// plane and on any circular arc; 1, too, for the opposite faces of a thin wall whose normals are
/// opposite, where the plain product of the normals says the reverse.
/// S. Koenig, S. Gumhold, "Consistent propagation of normal orientations in point clouds", VMV
/// 2009.
float agreement(Vec3f n_a, Vec3f n_b, Vec3f d);

/// Settles what is SettledBy::kNothing in `normals` (N, in the tree's order, turned to the side
/// that weak evidence prefers): support = evidence for that side + quality-weighted mean agreement
/// with the settled neighbours. In each round all points of the highest level of support are
/// settled together; the round after sees them as settled. Ends when nothing changes; what then
/// has less support than options.least_support stays as it is. `evidence` holds mean |n . b|, N.
/// Returns the number of rounds. Same result for any number of threads.
int propagate(const PointTree& tree, std::span<const float> evidence, const OrientOptions& options,
              OrientedNormals& normals);

}  // namespace cornice::normals
