// SPDX-License-Identifier: GPL-3.0-or-later
// How long edges may be where: learnt from the error that the present triangles make.
#pragma once

#include <vector>

#include "stages/remesh/patches.h"

namespace cornice::remesh {

struct SizeLimits {
  float error_m = 0.05f;
  float min_edge_m = 0.1f;
  float max_edge_m = 20.0f;
  float grading = 0.35f;  ///< growth of the length per metre
};

/// Sets the wanted length at every vertex to the edge of a triangle with equal sides and the mean
/// area of those around it; at fixed vertices to the mean length of the edges between fixed ones.
void start_sizes(WorkMesh& mesh, const SizeLimits& limits);

/// Bounds each length by those of its neighbours and the way to them, and by the limits (fixed
/// vertices by the neighbours alone). Mesh gradation after Borouchaki, Hecht, Frey 1998.
void grade_sizes(WorkMesh& mesh, const SizeLimits& limits);

/// Changes lengths by mesh.error of the triangles around: a chord's error grows with the
/// square of its length. `smallest` and `largest` bound the factor.
void adapt_sizes(WorkMesh& mesh, const SizeLimits& limits, float smallest, float largest);

}  // namespace cornice::remesh
