// SPDX-License-Identifier: GPL-3.0-or-later
// Half-edges of one patch, on compact arrays: half-edge 3t + k of triangle t starts at its corner
// k.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/mesh/topology.h"

namespace cornice::remesh {

inline constexpr std::uint32_t kNone = kOpenEdge;
/// Bit of a vertex's `fixed`: edges between two such vertices stay, too.
inline constexpr std::uint8_t kFrozen = 2;

/// Vertices and their connections. Vertices on the rim (an edge without twin) must be fixed; no
/// operation joins two fixed vertices by a new edge, since outside the patch there may be one.
class PatchMesh {
 public:
  /// Edges that are no manifold within the patch count as rim.
  PatchMesh(std::vector<Vec3f> positions, std::vector<Triangle> triangles,
            std::vector<std::uint8_t> fixed);

  std::size_t vertex_count() const { return positions_.size(); }
  std::size_t triangle_count() const { return corners_.size() / 3; }
  std::uint32_t half_edge_count() const { return static_cast<std::uint32_t>(corners_.size()); }
  bool vertex_alive(std::uint32_t v) const { return out_[v] != kNone; }
  bool triangle_alive(std::uint32_t t) const { return corners_[3 * t] != kNone; }
  bool alive(std::uint32_t h) const { return corners_[h] != kNone; }
  bool fixed(std::uint32_t v) const { return fixed_[v] != 0; }
  /// Whether an edge must stay as it is.
  bool frozen(std::uint32_t h) const {
    return ((fixed_[start(h)] & fixed_[end(h)]) & kFrozen) != 0;
  }
  Vec3f position(std::uint32_t v) const { return positions_[v]; }
  float length(std::uint32_t h) const { return norm(positions_[end(h)] - positions_[start(h)]); }
  void move(std::uint32_t v, Vec3f to) { positions_[v] = to; }

  static std::uint32_t next(std::uint32_t h) { return next_half_edge(h); }
  static std::uint32_t previous(std::uint32_t h) { return previous_half_edge(h); }
  std::uint32_t twin(std::uint32_t h) const { return twins_[h]; }
  std::uint32_t start(std::uint32_t h) const { return corners_[h]; }
  std::uint32_t end(std::uint32_t h) const { return corners_[next(h)]; }
  std::uint32_t opposite(std::uint32_t h) const { return corners_[previous(h)]; }

  /// Calls visit(h) for every half-edge that leaves v, one a triangle; with v on the rim from the
  /// rim's own on. Stops where visit returns false and returns false then.
  template <class Visit>
  bool each_out(std::uint32_t v, Visit&& visit) const {
    const std::uint32_t first = out_[v];
    std::uint32_t h = first;
    do {
      if (!visit(h)) return false;
      h = twins_[previous(h)];
    } while (h != first && h != kNone);
    return true;
  }
  /// Neighbours of v; on the rim that is one more than its triangles.
  template <class Visit>
  bool each_neighbour(std::uint32_t v, Visit&& visit) const {
    const std::uint32_t first = out_[v];
    std::uint32_t h = first;
    do {
      if (!visit(end(h))) return false;
      const std::uint32_t back = previous(h);
      h = twins_[back];
      if (h == kNone) return visit(start(back));
    } while (h != first);
    return true;
  }
  std::uint32_t valence(std::uint32_t v) const {
    std::uint32_t n = 0;
    each_neighbour(v, [&](std::uint32_t) { return ++n, true; });
    return n;
  }
  /// Not for two fixed vertices: the triangles of such a one may lie in several fans, of which only
  /// one is walked.
  bool adjacent(std::uint32_t v, std::uint32_t w) const {
    if (fixed_[v] != 0) std::swap(v, w);
    return !each_neighbour(v, [&](std::uint32_t n) { return n != w; });
  }

  Vec3f normal2(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const Vec3f p = positions_[a];
    return cross(positions_[b] - p, positions_[c] - p);
  }
  Vec3f middle_of_neighbours(std::uint32_t v) const;

  /// Puts a new vertex on an edge with twin. Returns it.
  std::uint32_t split(std::uint32_t h, Vec3f position);
  /// Puts a new vertex into a triangle, which keeps its first side. Returns it.
  std::uint32_t insert(std::uint32_t t, Vec3f position);
  /// True where the edge has a twin and its turning keeps a manifold.
  bool may_flip(std::uint32_t h) const;
  void flip(std::uint32_t h);
  /// True where start(h) can move onto end(h) and vanish, a manifold staying a manifold.
  bool may_collapse(std::uint32_t h) const;
  void collapse(std::uint32_t h);

 private:
  std::uint32_t add_vertex(Vec3f position);
  /// Room for two triangles; returns the first.
  std::uint32_t add_two_triangles();
  void set_triangle(std::uint32_t t, std::uint32_t a, std::uint32_t b, std::uint32_t c);
  void join(std::uint32_t h, std::uint32_t g);
  /// Makes the half-edges of a changed triangle known to their vertices.
  void announce(std::uint32_t t);

  std::vector<Vec3f> positions_;
  std::vector<std::uint8_t> fixed_;
  std::vector<std::uint32_t> out_;  ///< a half-edge that leaves the vertex; on the rim: the rim's
  std::vector<std::uint32_t> corners_;
  std::vector<std::uint32_t> twins_;
};

}  // namespace cornice::remesh
