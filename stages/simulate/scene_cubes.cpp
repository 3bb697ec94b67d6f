// SPDX-License-Identifier: GPL-3.0-or-later
// Nielson, "Dual Marching Cubes", 2004: each closed loop of segments on a cube's faces bounds one
// patch, and each patch gets one vertex. The loops are traced rather than listed, so the rule for
// ambiguous faces stands in one place.
//
//      c01 ----- c11      u and v are the face's axes in ascending order;
//       |         |       an edge of the face is crossed where its ends' signs differ.
//      c00 ----- c10
#include "stages/simulate/scene_cubes.h"

namespace cornice::simulate {
namespace {

constexpr int kAxisU[3] = {1, 0, 0};
constexpr int kAxisV[3] = {2, 2, 1};

int corner(int axis, int side, int u, int v) {
  return (side << axis) | (u << kAxisU[axis]) | (v << kAxisV[axis]);
}

int edge_between(int a, int b) {
  const int bit = a ^ b;
  const int axis = bit == 1 ? 0 : bit == 2 ? 1 : 2;
  const int u = a >> kAxisU[axis] & 1;
  const int v = a >> kAxisV[axis] & 1;
  return 4 * axis + u + 2 * v;
}

/// Joins of the crossed edges by segments: each crossed edge lies on two faces and has two ends.
struct Segments {
  std::array<std::array<std::int8_t, 2>, 12> next;
  std::array<std::int8_t, 12> count{};

  void join(int a, int b) {
    next[a][count[a]++] = static_cast<std::int8_t>(b);
    next[b][count[b]++] = static_cast<std::int8_t>(a);
  }
};

struct Face {
  std::array<int, 4> corners;  // around the face
  std::array<int, 4> edges;    // edge i joins corners i and i + 1
};

Face face_of(int face) {
  const int axis = face / 2, side = face % 2;
  Face f{};
  f.corners = {corner(axis, side, 0, 0), corner(axis, side, 1, 0), corner(axis, side, 1, 1),
               corner(axis, side, 0, 1)};
  for (int i = 0; i < 4; ++i) f.edges[i] = edge_between(f.corners[i], f.corners[(i + 1) % 4]);
  return f;
}

}  // namespace

CubeEdge cube_edge(int edge) {
  const int axis = edge / 4;
  const int from = (edge & 1) << kAxisU[axis] | (edge >> 1 & 1) << kAxisV[axis];
  return {from, from | 1 << axis};
}

CubePatches cube_patches(std::uint8_t solid, std::uint8_t flipped) {
  Segments segments;
  CubePatches patches;
  for (int face = 0; face < 6; ++face) {
    const Face f = face_of(face);
    std::array<int, 4> crossed{};
    int count = 0;
    for (int i = 0; i < 4; ++i) {
      const bool differs = ((solid >> f.corners[i]) & 1) != ((solid >> f.corners[(i + 1) % 4]) & 1);
      if (differs) crossed[count++] = f.edges[i];
    }
    if (count == 2) segments.join(crossed[0], crossed[1]);
    if (count != 4) continue;
    patches.ambiguous_faces |= static_cast<std::uint8_t>(1 << face);
    // Edges i-1 and i meet at corner i: cutting corners 0 and 2 joins (3, 0) and (1, 2).
    const bool solid_even = (solid >> f.corners[0]) & 1;
    const bool cut_even = solid_even != (((flipped >> face) & 1) != 0);
    segments.join(f.edges[cut_even ? 3 : 0], f.edges[cut_even ? 0 : 1]);
    segments.join(f.edges[cut_even ? 1 : 2], f.edges[cut_even ? 2 : 3]);
  }
  patches.of_edge.fill(255);
  for (int start = 0; start < 12; ++start) {
    if (segments.count[start] == 0 || patches.of_edge[start] != 255) continue;
    int at = start, before = -1;
    while (patches.of_edge[at] == 255) {
      patches.of_edge[at] = patches.count;
      const auto& ends = segments.next[at];
      const int after = ends[0] == before ? ends[1] : ends[0];
      before = at;
      at = after;
    }
    ++patches.count;
  }
  for (int face = 0; face < 6; ++face) {
    if (((patches.ambiguous_faces >> face) & 1) == 0) continue;
    const Face f = face_of(face);
    if (patches.of_edge[f.edges[0]] == patches.of_edge[f.edges[2]]) {
      patches.doubled_faces |= static_cast<std::uint8_t>(1 << face);
    }
  }
  return patches;
}

const CubePatches& usual_patches(std::uint8_t solid) {
  static const std::array<CubePatches, 256> table = [] {
    std::array<CubePatches, 256> all;
    for (int c = 0; c < 256; ++c) all[c] = cube_patches(static_cast<std::uint8_t>(c));
    return all;
  }();
  return table[solid];
}

}  // namespace cornice::simulate
