// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/reference.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace cornice::remesh {
namespace {

/// Steps after which a walk has lost its way.
constexpr int kMostSteps = 24;
constexpr int kMostStrides = 16;

}  // namespace

Reference::Reference(const std::vector<Vec3f>& positions, const std::vector<Triangle>& triangles,
                     std::vector<std::uint32_t> twins, int threads)
    : tree_(positions, triangles, threads),
      twins_(std::move(twins)),
      at_(positions.size(), kNoTriangle) {
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (const std::uint32_t v : triangles[t]) at_[v] = t;
  }
}

NearestPoint Reference::measure(Vec3f p, std::uint32_t triangle) const {
  const Triangle& c = triangles()[triangle];
  NearestPoint near =
      nearest_on_triangle(p, positions()[c[0]], positions()[c[1]], positions()[c[2]]);
  near.triangle = triangle;
  return near;
}

float Reference::distance_sq(Vec3f p, std::uint32_t triangle, float most_sq) const {
  const Triangle& c = triangles()[triangle];
  const Vec3f a = positions()[c[0]];
  const Vec3f ab = positions()[c[1]] - a, ac = positions()[c[2]] - a, ap = p - a;
  const Vec3f n = cross(ab, ac);
  const float nn = dot(n, n), h = dot(ap, n);
  // Not even the plane is near enough.
  if (h * h >= most_sq * nn) return most_sq;
  const float u = dot(cross(ap, ac), n), v = dot(cross(ab, ap), n);
  if (u >= 0.0f && v >= 0.0f && u + v <= nn) return h * h / nn;
  const auto side = [](Vec3f d, Vec3f along) {
    const float ll = dot(along, along);
    const float t = ll > 0.0f ? std::clamp(dot(d, along) / ll, 0.0f, 1.0f) : 0.0f;
    const Vec3f rest = d - along * t;
    return dot(rest, rest);
  };
  float best = most_sq;
  if (u < 0.0f) best = std::min(best, side(ap, ac));
  if (v < 0.0f) best = std::min(best, side(ap, ab));
  if (u + v > nn) best = std::min(best, side(ap - ab, ac - ab));
  return best;
}

std::uint32_t Reference::stride(Vec3f p, std::uint32_t from, float& found_sq) const {
  std::uint32_t here = from;
  for (int step = 0; step < kMostStrides; ++step) {
    const Triangle& c = triangles()[here];
    const Vec3f a = positions()[c[0]];
    const Vec3f ab = positions()[c[1]] - a, ac = positions()[c[2]] - a, ap = p - a;
    const Vec3f n = cross(ab, ac);
    const float nn = dot(n, n);
    const float u = dot(cross(ap, ac), n), v = dot(cross(ab, ap), n), w = nn - u - v;
    const float least = std::min({u, v, w});
    if (least >= 0.0f && nn > 0.0f) {
      const float h = dot(ap, n);
      found_sq = h * h / nn;
      return here;
    }
    const std::uint32_t twin = twins_[3 * here + (v == least ? 0u : w == least ? 1u : 2u)];
    if (twin >= kNoTwin) break;
    here = twin / 3;
  }
  found_sq = distance_sq(p, here, std::numeric_limits<float>::max());
  return here;
}

std::uint32_t Reference::step_down(Vec3f p, std::uint32_t from, float enough_sq,
                                   float& found_sq) const {
  std::uint32_t here = stride(p, from, found_sq), came_from = kNoTriangle;
  for (int step = 0; step < kMostSteps && found_sq > enough_sq; ++step) {
    const std::uint32_t at = here;
    for (std::uint32_t h = 3 * at; h < 3 * at + 3; ++h) {
      if (twins_[h] >= kNoTwin || twins_[h] / 3 == came_from) continue;
      const float next_sq = distance_sq(p, twins_[h] / 3, found_sq);
      if (next_sq < found_sq) found_sq = next_sq, here = twins_[h] / 3;
    }
    if (here == at) break;
    came_from = at;
  }
  return here;
}

NearestPoint Reference::walk(Vec3f p, std::uint32_t from, float enough_sq) const {
  float found_sq = 0.0f;
  return measure(p, step_down(p, from, enough_sq, found_sq));
}

NearestPoint Reference::near(Vec3f p, std::uint32_t from, float enough_sq, float search_sq) const {
  NearestQuery query;
  if (from != kNoTriangle) {
    float found_sq = 0.0f;
    query.guess = step_down(p, from, enough_sq, found_sq);
    if (found_sq <= search_sq) {
      NearestPoint found;
      found.triangle = query.guess;
      found.distance_sq = found_sq;
      return found;
    }
  }
  return tree_.nearest(p, query);
}

bool Reference::is_near(Vec3f p, std::uint32_t& from, float enough_sq) const {
  if (from != kNoTriangle) {
    float found_sq = 0.0f;
    const std::uint32_t near = step_down(p, from, enough_sq, found_sq);
    if (found_sq <= enough_sq) return from = near, true;
  }
  NearestQuery query;
  query.enough_sq = enough_sq;
  query.max_distance_sq = enough_sq;
  const NearestPoint found = tree_.nearest(p, query);
  if (found.found()) from = found.triangle;
  return found.found();
}

}  // namespace cornice::remesh
