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
/// Triangles that a guess may be walked along; samples that follow each other lie near each other.
constexpr int kMostSteps = 16;

/// The place of a triangle nearest to p, relative to `a`, in double and without cross terms that
/// cancel: the float search loses millimetres on triangles a hundred times as long as wide, the
/// walls of DEMs. `weights` are those of a, b and c.
Vec3d foot_on_triangle(Vec3d p, Vec3d a, Vec3d b, Vec3d c, float (&weights)[3]) {
  const Vec3d corner[3]{a, b, c};
  const Vec3d normal = cross(b - a, c - a);
  const double area_sq = dot(normal, normal);
  const Vec3d on_plane = area_sq > 0.0 ? p - normal * (dot(p - a, normal) / area_sq) : p;
  double inside[3];
  bool is_inside = area_sq > 0.0;
  for (std::size_t k = 0; k < 3 && is_inside; ++k) {
    const Vec3d from = corner[(k + 1) % 3], to = corner[(k + 2) % 3];
    inside[k] = dot(cross(to - from, on_plane - from), normal) / area_sq;
    is_inside = inside[k] >= 0.0;
  }
  if (is_inside) {
    for (std::size_t k = 0; k < 3; ++k) weights[k] = static_cast<float>(inside[k]);
    return on_plane;
  }
  Vec3d nearest;
  double nearest_sq = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3d from = corner[k], edge = corner[(k + 1) % 3] - from;
    const double length_sq = dot(edge, edge);
    const double share =
        length_sq > 0.0 ? std::clamp(dot(p - from, edge) / length_sq, 0.0, 1.0) : 0.0;
    const Vec3d at = from + edge * share;
    const double distance_sq = dot(p - at, p - at);
    if (!(distance_sq < nearest_sq)) continue;
    nearest_sq = distance_sq, nearest = at;
    weights[k] = static_cast<float>(1.0 - share);
    weights[(k + 1) % 3] = static_cast<float>(share);
    weights[(k + 2) % 3] = 0.0f;
  }
  return nearest;
}

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

Vec3f DistanceField::pseudonormal(std::uint32_t triangle, const float (&weight)[3],
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

std::uint32_t DistanceField::nearer(Vec3f p, std::uint32_t triangle) const {
  if (is_cloud()) return triangle;
  const auto distance_sq = [&](std::uint32_t t) {
    const Triangle& c = tree_.triangles()[t];
    const std::vector<Vec3f>& positions = tree_.positions();
    return nearest_on_triangle(p, positions[c[0]], positions[c[1]], positions[c[2]]).distance_sq;
  };
  float nearest_sq = distance_sq(triangle);
  std::uint32_t from = kNoTwin;
  for (int step = 0; step < kMostSteps; ++step) {
    const std::uint32_t here = triangle;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t twin = twins_[3 * here + k];
      if (twin >= kNoTwin || twin / 3 == from) continue;
      const float other_sq = distance_sq(twin / 3);
      if (!(other_sq < nearest_sq)) continue;
      nearest_sq = other_sq, triangle = twin / 3;
    }
    if (triangle == here) break;
    from = here;
  }
  return triangle;
}

DistanceField::Exact DistanceField::exact_at(Vec3d p, std::uint32_t triangle) const {
  const Triangle& corners = tree_.triangles()[triangle];
  const auto position = [&](std::size_t k) { return tree_.positions()[corners[k]].cast<double>(); };
  Exact exact;
  exact.off = p - foot_on_triangle(p, position(0), position(1), position(2), exact.weights);
  return exact;
}

Foot DistanceField::at(Vec3f p, float max_distance_m, std::uint32_t guess) const {
  NearestQuery query;
  query.max_distance_sq = max_distance_m * max_distance_m;
  query.guess = guess < tree_.triangles().size() ? nearer(p, guess) : guess;
  const NearestPoint nearest = tree_.nearest(p, query);
  Foot foot;
  if (!nearest.found()) return foot;
  foot.triangle = nearest.triangle;
  foot.distance_m = std::sqrt(nearest.distance_sq);
  if (is_cloud()) return foot;
  const Vec3d place = p.cast<double>();
  Exact exact = exact_at(place, foot.triangle);
  // The float search may have taken a neighbour for the nearest by as much as it errs.
  for (bool walks = true; walks;) {
    walks = false;
    const std::uint32_t here = foot.triangle;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t twin = twins_[3 * here + k];
      if (twin >= kNoTwin) continue;
      const Exact other = exact_at(place, twin / 3);
      if (!(dot(other.off, other.off) < dot(exact.off, exact.off))) continue;
      exact = other, foot.triangle = twin / 3, walks = true;
    }
  }
  bool on_border = false;
  const Vec3d normal = pseudonormal(foot.triangle, exact.weights, on_border).cast<double>();
  const double along = dot(exact.off, normal), length_sq = dot(exact.off, exact.off);
  // Past the edge: more than 45 degrees off the normal.
  if (on_border) foot.beside = 2.0 * along * along < length_sq * dot(normal, normal);
  foot.distance_m = static_cast<float>(std::copysign(std::sqrt(length_sq), along));
  return foot;
}

}  // namespace cornice::compare
