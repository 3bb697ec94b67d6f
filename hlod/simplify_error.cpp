// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/simplify_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/mesh/triangle_tree.h"

namespace cornice::hlod {
namespace {

/// Coarse triangles looked at on the way from a vertex's parent to its foot, or from foot to foot.
constexpr int kWalkLimit = 24;
/// Coarse triangles looked at for a way from foot to foot.
constexpr std::size_t kSearchLimit = 64;
/// A foot that is farther off than this part of the way to the parent may not be the nearest.
constexpr float kFarFoot = 0.25f;

constexpr std::array<std::size_t, 3> kNext{1, 2, 0};

float segment_distance(Vec3f p, Vec3f a, Vec3f b) {
  const Vec3f d = b - a;
  const float square = dot(d, d);
  const float s = square > 0 ? std::clamp(dot(p - a, d) / square, 0.0f, 1.0f) : 0.0f;
  return norm(p - (a + s * d));
}

bool has(const Triangle& t, std::uint32_t v) { return t[0] == v || t[1] == v || t[2] == v; }

/// Where the rest [at, end] of a fine edge comes nearest to the coarse edge p-q. Moves `at` there
/// and returns the distance. Ericson 2005, "Real-Time Collision Detection", 5.1.9.
float pass_over(Vec3f p, Vec3f q, Vec3f end, Vec3f& at) {
  const Vec3f u = end - at, v = q - p, w = at - p;
  const float uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), uw = dot(u, w), vw = dot(v, w);
  const float square = uu * vv - uv * uv;
  float s = square > 0 ? std::clamp((uv * vw - uw * vv) / square, 0.0f, 1.0f) : 0.0f;
  float t = vv > 0 ? (uv * s + vw) / vv : 0.0f;
  if (!(t >= 0 && t <= 1)) {
    t = t > 1 ? 1.0f : 0.0f;
    s = uu > 0 ? std::clamp((t * uv - uw) / uu, 0.0f, 1.0f) : 0.0f;
  }
  at = at + s * u;
  return norm(at - (p + t * v));
}

}  // namespace

void StepError::prepare(const SimplifyMesh& mesh, const Simplifier& simplifier,
                        std::span<const Vec3f> fine, std::span<const Triangle> original,
                        std::span<const std::uint8_t> shared) {
  mesh_ = &mesh;
  simplifier_ = &simplifier;
  fine_ = fine;
  original_ = original;
  shared_ = shared;
  feet_.assign(mesh.positions.size(), kNone);
  own_.assign(mesh.positions.size(), 0);
  find_neighbours();
  // A triangle that stayed and had the vertex lies on the way from the parent to it.
  for (std::uint32_t t = 0; t < original.size(); ++t) {
    const Triangle& now = mesh.triangles[t];
    if (now[0] == kNone) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      if (now[c] != original[t][c]) feet_[original[t][c]] = t;
    }
  }
  for (std::uint32_t v = 0; v < feet_.size(); ++v) {
    if (simplifier.parents()[v] != v) find_foot(v);
  }
}

/// Which triangle lies on the other side of each edge (e, e + 1) of each triangle, or kNone.
void StepError::find_neighbours() {
  const std::vector<Triangle>& triangles = mesh_->triangles;
  neighbours_.assign(triangles.size(), {kNone, kNone, kNone});
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (triangles[t][0] == kNone) continue;
    for (std::size_t e = 0; e < 3; ++e) {
      if (neighbours_[t][e] != kNone) continue;
      const std::uint32_t from = triangles[t][e], to = triangles[t][kNext[e]];
      for (const std::uint32_t other : simplifier_->fans().of(from)) {
        const Triangle& o = triangles[other];
        if (other == t || !has(o, to)) continue;
        neighbours_[t][e] = other;
        for (std::size_t f = 0; f < 3; ++f) {
          if (o[f] == to && o[kNext[f]] == from) neighbours_[other][f] = t;
        }
        break;
      }
    }
  }
}

/// Walks over the coarse triangles towards the vertex, each time across the edge that it lies
/// farthest beyond.
void StepError::find_foot(std::uint32_t vertex) {
  const Vec3f w = fine_[vertex];
  std::uint32_t at = feet_[vertex], before = kNone;
  feet_[vertex] = kNone;
  if (at == kNone) {
    const auto fan = simplifier_->fans().of(simplifier_->parents()[vertex]);
    if (fan.empty()) {
      own_[vertex] = norm(w - mesh_->positions[simplifier_->parents()[vertex]]);
      return;
    }
    at = fan.front();
  }
  for (int steps = 0; steps < kWalkLimit; ++steps) {
    const Triangle& t = mesh_->triangles[at];
    const std::array<Vec3f, 3> p{mesh_->positions[t[0]], mesh_->positions[t[1]],
                                 mesh_->positions[t[2]]};
    const std::array<Vec3f, 3> edges{p[1] - p[0], p[2] - p[1], p[0] - p[2]};
    const Vec3f n = cross(edges[0], edges[1]);
    std::size_t worst = 3;
    float beyond = 0;
    for (std::size_t e = 0; e < 3; ++e) {
      const float side = dot(n, cross(edges[e], w - p[e]));
      if (side < beyond) beyond = side, worst = e;
    }
    if (worst == 3) {
      const float length = norm(n);
      if (length == 0) break;
      feet_[vertex] = at;
      own_[vertex] = std::abs(dot(n, w - p[0])) / length;
      break;
    }
    const std::uint32_t next = neighbours_[at][worst];
    if (next == kNone || next == before) break;
    before = at;
    at = next;
  }
  // Beyond a border, at a crease or a corner that lies between the triangles, or above a triangle
  // that is not the nearest.
  const float way = norm(w - mesh_->positions[simplifier_->parents()[vertex]]);
  if (feet_[vertex] == kNone || own_[vertex] > kFarFoot * way) find_nearest(vertex, at);
  if (simplifier_->is_border(vertex)) {
    own_[vertex] = std::max(own_[vertex], border_distance(vertex));
  }
}

/// The nearest point of the triangles round the parent and round the triangle `at`, and round those
/// again as long as they come nearer.
void StepError::find_nearest(std::uint32_t vertex, std::uint32_t at) {
  float nearest = std::numeric_limits<float>::infinity();
  const auto look_round = [&](std::uint32_t corner) {
    for (const std::uint32_t triangle : simplifier_->fans().of(corner)) {
      const Triangle& t = mesh_->triangles[triangle];
      const float square = nearest_on_triangle(fine_[vertex], mesh_->positions[t[0]],
                                               mesh_->positions[t[1]], mesh_->positions[t[2]])
                               .distance_sq;
      if (square < nearest) nearest = square, feet_[vertex] = triangle;
    }
  };
  look_round(simplifier_->parents()[vertex]);
  for (int steps = 0; steps < kWalkLimit; ++steps) {
    const Triangle corners = mesh_->triangles[at];
    for (const std::uint32_t corner : corners) look_round(corner);
    if (feet_[vertex] == at) break;
    at = feet_[vertex];
  }
  own_[vertex] = std::sqrt(nearest);
}

/// From a vertex that was on the border to the border next to its parent: a concave border that is
/// cut short lies inside the coarse surface, but the coarse surface then lies outside of the fine.
float StepError::border_distance(std::uint32_t vertex) const {
  const std::uint32_t parent = simplifier_->parents()[vertex];
  float nearest = norm(fine_[vertex] - mesh_->positions[parent]);
  for (const std::uint32_t t : simplifier_->fans().of(parent)) {
    for (std::size_t e = 0; e < 3; ++e) {
      const Triangle& triangle = mesh_->triangles[t];
      if (neighbours_[t][e] != kNone) continue;
      nearest = std::min(nearest, segment_distance(fine_[vertex], mesh_->positions[triangle[e]],
                                                   mesh_->positions[triangle[kNext[e]]]));
    }
  }
  return nearest;
}

/// Over the edge e of a triangle alone.
float StepError::over(std::uint32_t a, std::uint32_t b, std::uint32_t triangle,
                      std::size_t e) const {
  const Triangle& t = mesh_->triangles[triangle];
  Vec3f at = fine_[a];
  return pass_over(mesh_->positions[t[e]], mesh_->positions[t[kNext[e]]], fine_[b], at);
}

/// Distance along the fine edge from a to b, its ends left out; what is not above `enough` need not
/// be the least that can be shown.
float StepError::edge_error(std::uint32_t a, std::uint32_t b, float enough) const {
  const std::vector<Triangle>& triangles = mesh_->triangles;
  const std::uint32_t from = feet_[a], to = feet_[b];
  float least = std::numeric_limits<float>::infinity();
  if (from == kNone && to == kNone) {
    for (const std::uint32_t t : simplifier_->fans().of(a)) {
      if (has(triangles[t], b)) return 0;
    }
  } else if (from == kNone || to == kNone) {
    const std::uint32_t stays = from == kNone ? a : b, foot = from == kNone ? to : from;
    if (has(triangles[foot], stays)) return 0;
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t other = neighbours_[foot][e];
      if (other != kNone && has(triangles[other], stays)) {
        least = std::min(least, over(a, b, foot, e));
      }
    }
  } else {
    if (from == to) return 0;
    for (std::size_t e = 0; e < 3; ++e) {
      if (neighbours_[from][e] == to) least = std::min(least, over(a, b, from, e));
    }
  }
  return least <= enough ? least : std::min(least, search(a, b));
}

/// Triangles that a fine edge may pass on its way.
struct StepError::Ways {
  struct Passed {
    std::uint32_t triangle, before;
    bool is_left;   ///< its neighbours are here, too
    float largest;  ///< distance at the edges on the way so far
    Vec3f at;       ///< how far the fine edge has come
  };
  std::array<Passed, kSearchLimit> passed;
  std::size_t count = 0;

  void add(const Passed& way) {
    for (std::size_t i = 0; i < count; ++i) {
      if (passed[i].triangle != way.triangle) continue;
      if (way.largest < passed[i].largest) passed[i] = way;
      return;
    }
    if (count < kSearchLimit) passed[count++] = way;
  }
  /// The way that went least far off, or null.
  Passed* next() {
    Passed* least = nullptr;
    for (std::size_t i = 0; i < count; ++i) {
      if (passed[i].is_left) continue;
      if (least == nullptr || passed[i].largest < least->largest) least = &passed[i];
    }
    return least;
  }
};

/// From the foot of a to the foot of b over the coarse edges that are nearest to the fine one.
float StepError::search(std::uint32_t a, std::uint32_t b) const {
  // From a foot there is one triangle to begin with.
  if (feet_[a] == kNone && feet_[b] != kNone) std::swap(a, b);
  const std::vector<Triangle>& triangles = mesh_->triangles;
  Ways ways;
  const auto cross_edge = [&](std::uint32_t triangle, std::size_t e, Vec3f at, float largest) {
    const Triangle& t = triangles[triangle];
    const std::uint32_t other = neighbours_[triangle][e];
    if (other == kNone) return;
    const float distance =
        pass_over(mesh_->positions[t[e]], mesh_->positions[t[kNext[e]]], fine_[b], at);
    ways.add({other, triangle, false, std::max(distance, largest), at});
  };
  if (feet_[a] != kNone) {
    ways.add({feet_[a], kNone, false, 0, fine_[a]});
  } else {
    // A vertex that stays is a corner of its triangles; the way leads over the third edge.
    for (const std::uint32_t t : simplifier_->fans().of(a)) {
      const std::size_t corner = (triangles[t][1] == a) + 2u * (triangles[t][2] == a);
      cross_edge(t, kNext[corner], fine_[a], 0);
    }
  }
  while (Ways::Passed* const way = ways.next()) {
    way->is_left = true;
    const Ways::Passed from = *way;
    const std::uint32_t t = from.triangle;
    if (feet_[b] != kNone ? t == feet_[b] : has(triangles[t], b)) return from.largest;
    for (std::size_t e = 0; e < 3; ++e) {
      if (neighbours_[t][e] != from.before) cross_edge(t, e, from.at, from.largest);
    }
  }
  // No way there: what is certain is that distances grow no faster than the way along the edge.
  return std::max(own_[a], own_[b]) + norm(fine_[b] - fine_[a]);
}

/// Whether the edge is met again from its other side, by the same range of triangles.
bool StepError::is_met_twice(std::uint32_t a, std::uint32_t b) const {
  const auto is_within = [&](std::uint32_t v) {
    return simplifier_->is_inside(v) && (shared_.empty() || shared_[v] == 0);
  };
  return is_within(a) || is_within(b);
}

float StepError::of(std::size_t begin, std::size_t end) const {
  float error = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const Triangle& t = original_[i];
    error = std::max({error, own_[t[0]], own_[t[1]], own_[t[2]]});
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t a = t[e], b = t[kNext[e]];
      if (a > b && is_met_twice(a, b)) continue;
      error = std::max(error, edge_error(std::min(a, b), std::max(a, b), error));
    }
  }
  return error;
}

}  // namespace cornice::hlod
