// SPDX-License-Identifier: GPL-3.0-or-later
// The normal of a bent surface at a point, where a plane through its neighbours has that of their
// middle.
#pragma once

#include <array>

#include "core/base/vec.h"
#include "stages/normals/neighbours.h"
#include "stages/normals/plane_fit.h"

namespace cornice::normals {

/// The normals of the surface at each lane's own point: of z = a + b u + c v + d u²/2 + e u v +
/// f v²/2 over the plane that fit_planes() made of the same block, fitted to the neighbours, near
/// ones counting more. How far ground is expected to bend is what the neighbours' distances from
/// the plane say beyond range noise, so noise alone turns no normals. Where neighbours lie all
/// around the point the plane's normal is the same; at edges, on walls that few beams see and
/// beside gaps they lie to one side, and the plane is that of ground half a neighbourhood away.
/// Unit, less than a right angle from the plane's; the plane's own, bit for bit, of neighbourhoods
/// that are narrow and no rougher than range noise, of fewer than 12 points or that may mix faces
/// (faces.h); 0 where there is no plane. What a lane gives does not depend on the other lanes.
/// `block` must be finished. F. Cazals, M. Pouget, "Estimating differential quantities using
/// polynomial fitting of osculating jets", 2003, with a Gaussian prior of the coefficients.
std::array<Vec3f, kLanes> bent_normals(const NeighbourBlock& block, const PlaneBlock& planes);

}  // namespace cornice::normals
