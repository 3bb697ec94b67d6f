// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh of the ground, overhangs included, from its implicit function.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/vec.h"
#include "stages/simulate/scene_field.h"

namespace cornice::simulate {

struct SurfaceOptions {
  Box2d window;         ///< local; the mesh ends exactly on its sides
  double step_m = 0.5;  ///< of the lattice in plan and height; plan steps are fitted to the window
  /// Vertices stand this far off the ground, outwards; up to 2.8 times as far where it curves.
  double offset_m = 0.0;
  double tolerance_m =
      1e-5;  ///< distance of a vertex from F = offset; 0: two Newton steps, unchecked
  int threads = 0;
};

/// Quads, counter-clockwise seen from the air, over vertices relative to `origin`.
struct Surface {
  Vec3d origin;
  std::vector<Vec3f> positions;
  std::vector<std::array<std::uint32_t, 4>> quads;
  std::uint64_t unsettled = 0;  ///< vertices that stayed farther than the tolerance
  std::uint64_t unsampled = 0;  ///< patches found where the search for the ground was too coarse
};

/// Dual marching cubes: one vertex for each patch of surface in a lattice cell (Nielson 2004), with
/// the faces that would make an edge of four quads cut the other way (after Wenger 2013, section
/// 3.3), so the mesh is a manifold whose border lies on the window's sides. Vertices are moved onto
/// the ground along the gradient. The same bytes with any number of threads.
Surface extract_surface(const GroundField& field, const SurfaceOptions& options);

}  // namespace cornice::simulate
