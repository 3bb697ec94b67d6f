// SPDX-License-Identifier: GPL-3.0-or-later
// Which edges of a lattice cube belong to which patch of the surface through it.
#pragma once

#include <array>
#include <cstdint>

namespace cornice::simulate {

/// Corner c of a cube lies at (c & 1, c >> 1 & 1, c >> 2). Edge e = 4 axis + (u + 2 v) runs along
/// `axis` from the corner whose other two coordinates, in ascending order of axis, are u and v.
struct CubeEdge {
  int from, to;
};
CubeEdge cube_edge(int edge);

/// Faces: 2 axis + side. A face is ambiguous where its corners' signs alternate around it.
struct CubePatches {
  std::uint8_t count = 0;
  std::array<std::uint8_t, 12> of_edge{};  ///< 255 where the edge is not crossed
  /// Set bit f: face f is ambiguous and both its segments belong to one patch.
  std::uint8_t doubled_faces = 0;
  std::uint8_t ambiguous_faces = 0;
};

/// Patches of the cube whose corner c is in the rock where bit c of `solid` is set. On an ambiguous
/// face the two corners in the rock are kept apart, or the two in the air where the face's bit in
/// `flipped` is set.
CubePatches cube_patches(std::uint8_t solid, std::uint8_t flipped = 0);

/// The same from a table, for flipped = 0.
const CubePatches& usual_patches(std::uint8_t solid);

}  // namespace cornice::simulate
