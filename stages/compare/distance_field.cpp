// SPDX-License-Identifier: GPL-3.0-or-later
// After Baerentzen, Aanaes 2005, "Signed distance computation using the angle weighted
// pseudonormal", IEEE Transactions on Visualization and Computer Graphics 11(3).
#include "stages/compare/distance_field.h"

#include <cmath>

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

Vec3f DistanceField::pseudonormal(const NearestPoint& nearest, bool& on_border) const {
  const Triangle& corners = tree_.triangles()[nearest.triangle];
  const float weight[3] = {1.0f - nearest.u - nearest.v, nearest.u, nearest.v};
  for (std::size_t k = 0; k < 3; ++k) {
    if (weight[k] < 1.0f - kOnEdge) continue;
    on_border = border_[corners[k]] != 0;
    return normals_[corners[k]];
  }
  Vec3f normal = tree_.normal(nearest.triangle);
  for (std::uint32_t k = 0; k < 3; ++k) {
    // Opposite corner k lies the edge from k + 1 to k + 2.
    if (weight[k] > kOnEdge) continue;
    const std::uint32_t twin = twins_[3 * nearest.triangle + (k + 1) % 3];
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
  if (!points_.empty()) return foot;
  bool on_border = false;
  const Vec3f normal = pseudonormal(nearest, on_border);
  const Vec3f off = p - tree_.point(nearest);
  const float along = dot(off, normal);
  // Past the edge: more than 45 degrees off the normal.
  if (on_border) foot.beside = 2.0f * along * along < dot(off, off) * dot(normal, normal);
  foot.distance_m = std::copysign(foot.distance_m, along);
  return foot;
}

}  // namespace cornice::compare
