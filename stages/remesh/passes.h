// SPDX-License-Identifier: GPL-3.0-or-later
// Passes over the whole mesh, patch by patch in parallel.
#pragma once

#include "stages/remesh/decimate.h"
#include "stages/remesh/patches.h"
#include "stages/remesh/relax.h"

namespace cornice::remesh {

/// Where the grid of patches lies and how large it is.
struct PatchGrid {
  double side_m = 128.0;
  double shift_x = 0.0;  ///< as shares of the side
  double shift_y = 0.0;
};

/// Decimates every patch; vertices keep their numbers.
void decimate_pass(WorkMesh& mesh, const PatchGrid& grid, const DecimateLimits& limits, int threads,
                   Progress& progress);

/// Relaxes every patch, or those alone that hold one of the `chosen` vertices (empty: all).
void relax_pass(WorkMesh& mesh, const TriangleTree& input, const PatchGrid& grid,
                const RelaxLimits& limits, const std::vector<std::uint8_t>& chosen, int threads,
                Progress& progress);

/// Drops vertices that no triangle names.
void compact(WorkMesh& mesh);

}  // namespace cornice::remesh
