// SPDX-License-Identifier: GPL-3.0-or-later
// After Baerentzen, Aanaes 2005, "Signed distance computation using the angle weighted
// pseudonormal", IEEE Transactions on Visualization and Computer Graphics 11(3).
#include "stages/compare/distance_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cornice::compare {
namespace {

/// Barycentric coordinates below this are zero: the foot lies on an edge or in a corner.
constexpr float kOnEdge = 1e-6f;
std::vector<Triangle> triangles_of_points(const Surface& surface) {
  std::vector<Triangle> triangles;
  if (!surface.triangles.empty()) return triangles;
  triangles.reserve(surface.positions.size());
  for (std::uint32_t v = 0; v < surface.positions.size(); ++v) triangles.push_back({v, v, v});
  return triangles;
}

}  // namespace

DistanceField::DistanceField(const Surface& surface, int threads)
    : points_(triangles_of_points(surface)),
      tree_(surface.positions, surface.triangles.empty() ? points_ : surface.triangles, threads) {
  if (surface.triangles.empty()) return;
  normals_ = vertex_normals(surface.positions, surface.triangles);
  twins_ = match_half_edges(surface.triangles, surface.positions.size(), threads);
  border_.assign(surface.positions.size(), 0);
  for (std::uint32_t h = 0; h < twins_.size(); ++h) {
    if (twins_[h] != kOpenEdge) continue;
    border_[surface.triangles[h / 3][h % 3]] = 1;
    border_[surface.triangles[h / 3][(h + 1) % 3]] = 1;
  }
}

Vec3f DistanceField::pseudonormal(std::uint32_t triangle, const std::array<float, 3>& weight,
                                  bool& on_border) const {
  const Triangle& corners = tree_.triangles()[triangle];
  for (std::size_t k = 0; k < 3; ++k) {
    if (weight[k] < 1.0f - kOnEdge) continue;
    on_border = border_[corners[k]] != 0;
    return normals_[corners[k]];
  }
  Vec3f normal = tree_.normal(triangle);
  for (std::uint32_t k = 0; k < 3; ++k) {
    // Opposite corner k lies the edge from k + 1 to k + 2.
    if (weight[k] > kOnEdge) continue;
    const std::uint32_t twin = twins_[3 * triangle + (k + 1) % 3];
    on_border = twin == kOpenEdge;
    if (twin < kNoTwin) normal += tree_.normal(twin / 3);
    return normal;
  }
  return normal;
}

Vec3f DistanceField::normal(std::uint32_t triangle) const {
  return is_cloud() ? Vec3f{0.0f, 0.0f, 1.0f} : tree_.normal(triangle);
}

Foot DistanceField::at(Vec3f p, float max_distance_m, std::uint32_t guess) const {
  NearestQuery query;
  query.max_distance_sq = max_distance_m * max_distance_m;
  query.guess = guess;
  const NearestPoint nearest = tree_.nearest(p, query);
  Foot foot;
  if (!nearest.found()) return foot;
  foot.triangle = nearest.triangle;
  foot.distance_m = std::sqrt(nearest.distance_sq);
  if (is_cloud()) return foot;
  const Triangle& corners = tree_.triangles()[foot.triangle];
  const auto position = [&](std::size_t k) { return tree_.positions()[corners[k]].cast<double>(); };
  const Vec3d a = position(0), ab = position(1) - a, ac = position(2) - a;
  const auto u = static_cast<double>(nearest.u), v = static_cast<double>(nearest.v);
  const Vec3d off = p.cast<double>() - a - ab * u - ac * v;
  bool on_border = false;
  const Vec3d normal =
      pseudonormal(foot.triangle, {1.0f - nearest.u - nearest.v, nearest.u, nearest.v}, on_border)
          .cast<double>();
  const double along = dot(off, normal);
  // Past the edge: more than 45 degrees off the normal.
  if (on_border) foot.beside = 2.0 * along * along < dot(off, off) * dot(normal, normal);
  foot.distance_m = static_cast<float>(std::copysign(static_cast<double>(foot.distance_m), along));
  return foot;
}

}  // namespace cornice::compare
