// SPDX-License-Identifier: GPL-3.0-or-later
// How the triangles of a cell hang together, in about two bits a triangle: the mesh is walked over
// edges, and each step says what lies across the edge. Gumhold and Strasser 1998, "Real Time
// Compression of Triangle Mesh Connectivity"; docs/formats/hlod.md has the rules.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace cornice::hlod {

using SmallTriangle = std::array<std::uint16_t, 3>;

/// What lies across an edge.
enum class Step : std::uint8_t {
  kNothing,   ///< a border, or a triangle that was reached another way
  kNew,       ///< a triangle whose third corner is the next new vertex
  kNext,      ///< its third corner ends the next edge of the front; that edge is done too
  kPrevious,  ///< its third corner begins the previous edge of the front; that edge is done too
  kBoth,      ///< both
  kFar,       ///< its third corner is another known vertex, named in the list of far vertices
};
inline constexpr int kStepCount = 6;

/// A walk as stored. far: for each kFar, and each corner of a triangle that begins a part, how many
/// vertices back from the next new one; 0: the next new vertex itself.
struct Walk {
  std::vector<Step> steps;
  std::vector<std::uint16_t> far;
};

/// What a walk rebuilds. References of vertex v: three earlier vertices (a, b, o) such that v lies
/// across edge a-b of triangle (a, b, o); where there is no such triangle, three times the vertex
/// before v. Of vertex 0: 0.
struct Walked {
  std::vector<SmallTriangle> triangles;
  std::vector<SmallTriangle> references;  ///< one per vertex
};

/// Walks triangles over `vertex_count` vertices, at most 65535. order[new number] = old number; old
/// vertices without triangle come last. Triangles keep their sense of rotation, not their first
/// corner.
struct WalkResult {
  Walk walk;
  std::vector<SmallTriangle> references;  ///< as in Walked
  std::vector<std::uint16_t> order;
};
WalkResult walk_triangles(std::span<const SmallTriangle> triangles, std::size_t vertex_count);

/// The inverse. Trusts nothing: false where the walk leads out of itself or has parts left over.
bool follow_walk(const Walk& walk, std::size_t triangle_count, std::size_t vertex_count,
                 Walked& walked);

}  // namespace cornice::hlod
