// SPDX-License-Identifier: GPL-3.0-or-later
// One pass of isotropic remeshing over one patch: split, collapse, flip, smooth, project.
#pragma once

#include <vector>

#include "stages/remesh/guard.h"
#include "stages/remesh/measure.h"
#include "stages/remesh/patch_mesh.h"

namespace cornice::remesh {

struct RelaxLimits {
  float reach_m = 1.0f;  ///< how far a vertex may be from the input it is put onto
  int rounds = 2;        ///< of flipping and smoothing
  GuardLimits guard;
};

/// A patch with what its vertices want.
struct RelaxPatch {
  PatchMesh mesh;
  std::vector<float> size;          ///< wanted length of edges at each vertex
  std::vector<std::uint32_t> hint;  ///< input triangle near each vertex
  Guard guard;                      ///< with what the triangles carry
};

/// Splits edges longer than 4/3 of the wanted length, collapses those shorter than 4/5 (Botsch,
/// Kobbelt 2004), turns edges towards Delaunay, moves vertices along the surface towards the middle
/// of their neighbours and puts them onto `input`; all of it as far as the guard lets it.
void relax(RelaxPatch& patch, const Reference& input, const RelaxLimits& limits);

/// Cuts triangles that leave the bound, at the place of the input that they should go through where
/// the guard lets that. `offences` name triangles of the patch.
void mend(RelaxPatch& patch, const Reference& input, const RelaxLimits& limits,
          const std::vector<Offence>& offences);

}  // namespace cornice::remesh
