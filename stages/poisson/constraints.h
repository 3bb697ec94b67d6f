// SPDX-License-Identifier: GPL-3.0-or-later
// The right-hand side: the divergence of the vector field that the normals are splatted into.
#pragma once

#include <span>
#include <vector>

#include "stages/poisson/grid.h"
#include "stages/poisson/samples.h"

namespace cornice::poisson {

/// Sets the constraints of all grids. Both spans have one entry per level, finest first, samples
/// with density set. Each sample's normal is splatted on the two levels around its depth; every
/// level sees all of them, finer ones restricted, coarser ones interpolated.
/// Kazhdan & Hoppe 2013, section 3 and equation (5), with trilinear functions.
void set_constraints(std::span<Grid> grids, std::span<const SampleLevel> samples, int threads);

}  // namespace cornice::poisson
