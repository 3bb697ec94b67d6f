// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/simplify_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/mesh/triangle_tree.h"

namespace cornice::hlod {
namespace {

/// Coarse triangles looked at on the way from a vertex's parent to its foot.
constexpr int kWalkLimit = 24;

float segment_distance(Vec3f p, Vec3f a, Vec3f b) {
  const Vec3f d = b - a;
  const float square = dot(d, d);
  const float s = square > 0 ? std::clamp(dot(p - a, d) / square, 0.0f, 1.0f) : 0.0f;
  return norm(p - (a + s * d));
}

}  // namespace

void StepError::prepare(const SimplifyMesh& mesh, const Simplifier& simplifier,
                        std::span<const Vec3f> fine, std::span<const Triangle> original) {
  mesh_ = &mesh;
  simplifier_ = &simplifier;
  fine_ = fine;
  original_ = original;
  planes_.resize(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& triangle = mesh.triangles[t];
    if (triangle[0] == kNone) continue;
    const Vec3f a = mesh.positions[triangle[0]];
    const Vec3f n =
        normalized(cross(mesh.positions[triangle[1]] - a, mesh.positions[triangle[2]] - a));
    planes_[t] = {n.x, n.y, n.z, -dot(n, a)};
  }
  feet_.assign(mesh.positions.size(), kNone);
  own_.assign(mesh.positions.size(), 0);
  for (std::uint32_t v = 0; v < feet_.size(); ++v) {
    if (simplifier.parents()[v] != v) find_foot(v);
  }
}

/// The triangle on the other side of edge (edge, edge + 1), or kNone.
std::uint32_t StepError::across(std::uint32_t triangle, std::size_t edge) const {
  const std::uint32_t from = mesh_->triangles[triangle][edge];
  const std::uint32_t to = mesh_->triangles[triangle][(edge + 1) % 3];
  for (const std::uint32_t t : simplifier_->fans().of(from)) {
    const Triangle& other = mesh_->triangles[t];
    if (t != triangle && (other[0] == to || other[1] == to || other[2] == to)) return t;
  }
  return kNone;
}

/// Walks over the coarse triangles towards the vertex, each time across the edge that it lies
/// farthest beyond.
void StepError::find_foot(std::uint32_t vertex) {
  const Vec3f w = fine_[vertex];
  const std::span<const std::uint32_t> fan = simplifier_->fans().of(simplifier_->parents()[vertex]);
  if (fan.empty()) {
    own_[vertex] = norm(w - mesh_->positions[simplifier_->parents()[vertex]]);
    return;
  }
  std::uint32_t at = fan.front(), before = kNone;
  for (int steps = 0; steps < kWalkLimit; ++steps) {
    const Triangle& t = mesh_->triangles[at];
    const Vec3f n{planes_[at].x, planes_[at].y, planes_[at].z};
    std::size_t worst = 3;
    float beyond = 0;
    for (std::size_t e = 0; e < 3; ++e) {
      const Vec3f a = mesh_->positions[t[e]], b = mesh_->positions[t[(e + 1) % 3]];
      const float side = dot(n, cross(b - a, w - a));
      if (side < beyond) beyond = side, worst = e;
    }
    if (worst == 3) {
      feet_[vertex] = at;
      own_[vertex] = std::abs(planes_[at].at(w));
      break;
    }
    const std::uint32_t next = across(at, worst);
    if (next == kNone || next == before) break;
    before = at;
    at = next;
  }
  if (feet_[vertex] == kNone) {
    // Beyond a border, or at a crease or a corner that lies between the triangles.
    float nearest = std::numeric_limits<float>::infinity();
    const auto look_at = [&](std::uint32_t triangle) {
      const Triangle& t = mesh_->triangles[triangle];
      const float square = nearest_on_triangle(w, mesh_->positions[t[0]], mesh_->positions[t[1]],
                                               mesh_->positions[t[2]])
                               .distance_sq;
      if (square < nearest) nearest = square, feet_[vertex] = triangle;
    };
    for (const std::uint32_t triangle : fan) look_at(triangle);
    for (const std::uint32_t corner : mesh_->triangles[at]) {
      for (const std::uint32_t triangle : simplifier_->fans().of(corner)) look_at(triangle);
    }
    own_[vertex] = std::sqrt(nearest);
  }
  if (simplifier_->is_border(vertex)) {
    own_[vertex] = std::max(own_[vertex], border_distance(vertex));
  }
}

/// From a vertex that was on the border to the border next to its parent: a concave border that is
/// cut short lies inside the coarse surface, but the coarse surface then lies outside of the fine.
float StepError::border_distance(std::uint32_t vertex) const {
  const std::uint32_t parent = simplifier_->parents()[vertex];
  float nearest = norm(fine_[vertex] - mesh_->positions[parent]);
  for (const std::uint32_t t : simplifier_->fans().of(parent)) {
    for (std::size_t e = 0; e < 3; ++e) {
      const Triangle& triangle = mesh_->triangles[t];
      if (across(t, e) != kNone) continue;
      nearest = std::min(nearest, segment_distance(fine_[vertex], mesh_->positions[triangle[e]],
                                                   mesh_->positions[triangle[(e + 1) % 3]]));
    }
  }
  return nearest;
}

/// Largest distance along a fine edge, its ends left out.
float StepError::edge_error(std::uint32_t a, std::uint32_t b) const {
  const std::uint32_t at_a = feet_[a], at_b = feet_[b];
  if (at_a == at_b) return 0;
  const float aa = at_a == kNone ? 0 : planes_[at_a].at(fine_[a]);
  const float ab = at_a == kNone ? 0 : planes_[at_a].at(fine_[b]);
  const float ba = at_b == kNone ? 0 : planes_[at_b].at(fine_[a]);
  const float bb = at_b == kNone ? 0 : planes_[at_b].at(fine_[b]);
  if (at_a != kNone && at_b != kNone) {
    // Over a single crease the edge is as far from both planes.
    int common = 0;
    for (const std::uint32_t u : mesh_->triangles[at_a]) {
      for (const std::uint32_t v : mesh_->triangles[at_b]) common += u == v;
    }
    const float difference = (aa - ba) + (bb - ab);
    const float s = (aa - ba) / difference;
    if (common >= 2 && s >= 0 && s <= 1) return std::abs(aa + s * (ab - aa));
  }
  return std::max(std::max(std::abs(aa), std::abs(ab)), std::max(std::abs(ba), std::abs(bb)));
}

float StepError::of(std::size_t begin, std::size_t end) const {
  float error = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const Triangle& t = original_[i];
    for (const std::uint32_t v : t) error = std::max(error, own_[v]);
    for (std::size_t e = 0; e < 3; ++e) {
      error = std::max(error, edge_error(t[e], t[(e + 1) % 3]));
    }
  }
  return error;
}

}  // namespace cornice::hlod
