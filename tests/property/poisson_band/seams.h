// SPDX-License-Identifier: GPL-3.0-or-later
// How well the meshes of neighbouring tiles meet.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "stages/poisson/band.h"
#include "stages/poisson/extract.h"

namespace cornice::test {

/// All tiles of a survey as one mesh, vertices at one place made one.
struct JoinedTiles {
  Mesh mesh;                       ///< without normals
  std::uint64_t open_edges = 0;    ///< away from the outline of the survey
  std::uint64_t non_manifold = 0;  ///< edges and vertices
  std::uint64_t mismatched = 0;    ///< vertices on an inner border plane that one side alone has
  std::uint64_t turned = 0;        ///< of them, normals that differ between the sides by any bit
};
JoinedTiles join_tiles(std::span<const Surface> surfaces, std::span<const LatticeBox> tiles,
                       const Lattice& lattice);

/// Each tile's surface, extracted from its own field and the bands of all others.
std::vector<Surface> extract_all(std::span<const TileField> fields, int threads = 2);

}  // namespace cornice::test
