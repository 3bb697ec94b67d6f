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
  /// Cosine between a triangle that mending makes and the input next to it, at least: no folds.
  float least_facing = 0.1f;
  /// Mending halves what is beyond the bound, onto the input, before it tries anything else.
  bool insists = false;
};

/// A patch with what its vertices want.
struct RelaxPatch {
  PatchMesh mesh;
  std::vector<float> size;          ///< wanted length of edges at each vertex
  std::vector<std::uint32_t> hint;  ///< input triangle near each vertex
  Guard guard;                      ///< with what the triangles carry
  /// Per triangle: new, or to be measured again anyway. Empty: all are.
  std::vector<std::uint8_t> changed;

  /// Whether a cut of edge h at `at` stays clear of the opposite corners. Over a cap, whose third
  /// corner lies on the edge already, a cut would only double that corner.
  bool may_cut_at(std::uint32_t h, Vec3f at) const;
  /// PatchMesh::split() with what the new vertex wants; `triangle` of the input is near it. Returns
  /// the four triangles in the order of that function. The guard is left to the caller.
  std::vector<std::uint32_t> cut(std::uint32_t h, Vec3f at, std::uint32_t triangle);
};

/// Splits edges longer than 4/3 of the wanted length, collapses those shorter than 4/5 (Botsch,
/// Kobbelt 2004), turns edges towards Delaunay, moves vertices along the surface towards the middle
/// of their neighbours and puts them onto `input`; all of it as far as the guard lets it.
void relax(RelaxPatch& patch, const Reference& input, const RelaxLimits& limits);

/// At every triangle that leaves the bound: a cut through the place of the input that it should go
/// through, a turned edge, a collapse or a move, the first that the guard lets pass; where none
/// does a cut that leaves the surface as it is. `offences` name triangles of the patch; places of
/// the input in `places` that are near it stay so.
void mend(RelaxPatch& patch, const Reference& input, const RelaxLimits& limits,
          const std::vector<Offence>& offences, const std::vector<Vec3f>& places);

/// At every thin triangle, worst first: the change that leaves the fewest thin ones round it, if
/// the guard lets it pass. `places` as for mend().
void mend_shapes(RelaxPatch& patch, const Reference& input, const RelaxLimits& limits,
                 const std::vector<Vec3f>& places);
bool is_thin(Vec3f a, Vec3f b, Vec3f c);

}  // namespace cornice::remesh
