// SPDX-License-Identifier: GPL-3.0-or-later
// Attributes of the result, taken from the input.
#pragma once

#include "stages/remesh/patches.h"
#include "stages/remesh/reference.h"

namespace cornice::remesh {

/// `result` has positions and triangles; gets normals and properties as `input` has them. A vertex
/// whose source is known takes over that vertex's, all others those of the nearest place.
void transfer_attributes(const Mesh& input, const Reference& reference, const WorkMesh& work,
                         Mesh& result, int threads);

}  // namespace cornice::remesh
