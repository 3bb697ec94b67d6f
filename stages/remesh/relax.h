// SPDX-License-Identifier: GPL-3.0-or-later
// One pass of isotropic remeshing over one patch: split, collapse, flip, smooth, project.
#pragma once

#include <vector>

#include "core/mesh/triangle_tree.h"
#include "stages/remesh/patch_mesh.h"

namespace cornice::remesh {

struct RelaxLimits {
  float error_m = 0.05f;  ///< no operation may leave a place of the old surface farther away
  float reach_m = 1.0f;   ///< how far a vertex may be from the input it is put onto
  int rounds = 2;         ///< of flipping and smoothing
};

/// A patch with what its vertices want.
struct RelaxPatch {
  PatchMesh mesh;
  std::vector<float> size;          ///< wanted length of edges at each vertex
  std::vector<std::uint32_t> hint;  ///< input triangle near each vertex
};

/// Splits edges longer than 4/3 of the wanted length, collapses those shorter than 4/5 (Botsch,
/// Kobbelt 2004), turns edges towards Delaunay, moves vertices along the surface towards the middle
/// of their neighbours and puts them onto `input`.
void relax(RelaxPatch& patch, const TriangleTree& input, const RelaxLimits& limits);

}  // namespace cornice::remesh
