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

/// Decimates every patch; vertices keep their numbers, which are those of the input.
void decimate_pass(WorkMesh& mesh, const Reference& input, const PatchGrid& grid,
                   const DecimateLimits& limits, int threads, Progress& progress);

/// Relaxes every patch.
void relax_pass(WorkMesh& mesh, const Reference& input, const PatchGrid& grid,
                const RelaxLimits& limits, int threads, Progress& progress);

/// Puts a vertex through the place of every offence, as far as it can. `offences` by triangle;
/// places of the input in `places` that are near stay so.
/// mesh.changed tells which triangles are new or have offended.
void mend_pass(WorkMesh& mesh, const Reference& input, const PatchGrid& grid,
               const RelaxLimits& limits, const std::vector<Offence>& offences,
               const std::vector<Vec3f>& places, int threads);

/// Mends the shapes of thin triangles; the rest as for mend_pass().
void shape_pass(WorkMesh& mesh, const Reference& input, const PatchGrid& grid,
                const RelaxLimits& limits, const std::vector<Vec3f>& places, int threads);

/// Drops vertices that no triangle names.
void compact(WorkMesh& mesh);

}  // namespace cornice::remesh
