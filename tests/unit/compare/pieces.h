// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces for the tests of comparisons.
#pragma once

#include "core/mesh/mesh.h"
#include "stages/compare/surface.h"

namespace cornice::test {

/// A mesh as a surface with normals and curvature, its origin moved by `by`.
compare::Surface surface_of(const Mesh& mesh, Vec3d by = {});

/// Points alone.
compare::Surface cloud_of(std::vector<Vec3f> positions, Vec3d origin = {});

}  // namespace cornice::test
