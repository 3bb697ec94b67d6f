// SPDX-License-Identifier: GPL-3.0-or-later
// After Cignoni, Rocchini, Scopigno 1998, "Metro: measuring error on simplified surfaces": sampled
// two-sided distance.
#include "core/mesh/surface_distance.h"

#include <cmath>

#include "core/base/parallel.h"

namespace cornice {
namespace {

constexpr std::size_t kGrain = 8192;

}  // namespace

void sample_triangle(Vec3f a, Vec3f b, Vec3f c, float spacing_m, std::vector<Vec3f>& samples) {
  const float longest = std::max({norm(b - a), norm(c - b), norm(a - c)});
  if (!(longest > spacing_m)) return;
  const int n = static_cast<int>(std::ceil(longest / spacing_m));
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; i + j <= n; ++j) {
      if (i == n || j == n || i + j == 0) continue;
      const float u = static_cast<float>(i) / static_cast<float>(n);
      const float v = static_cast<float>(j) / static_cast<float>(n);
      samples.push_back(a + (b - a) * u + (c - a) * v);
    }
  }
}

std::vector<Vec3f> sample_surface(const std::vector<Vec3f>& positions,
                                  const std::vector<Triangle>& triangles, float spacing_m,
                                  const std::vector<std::uint32_t>& tree_order) {
  std::vector<Vec3f> samples;
  samples.reserve(positions.size());
  std::vector<std::uint8_t> seen(positions.size(), 0);
  for (const std::uint32_t t : tree_order) {
    const Triangle& corners = triangles[t];
    for (const std::uint32_t v : corners) {
      if (seen[v] == 0) samples.push_back(positions[v]);
      seen[v] = 1;
    }
    sample_triangle(positions[corners[0]], positions[corners[1]], positions[corners[2]], spacing_m,
                    samples);
  }
  return samples;
}

float largest_distance(const std::vector<Vec3f>& samples, const TriangleTree& surface,
                       int threads) {
  if (samples.empty()) return 0.0f;
  if (surface.triangles().empty()) return std::numeric_limits<float>::infinity();
  const float largest_sq = parallel_reduce(
      samples.size(), kGrain, threads, 0.0f,
      [&](std::size_t begin, std::size_t end) {
        NearestQuery query;
        for (std::size_t i = begin; i < end; ++i) {
          const NearestPoint found = surface.nearest(samples[i], query);
          query.guess = found.triangle;
          query.enough_sq = std::max(query.enough_sq, found.distance_sq);
        }
        return query.enough_sq;
      },
      [](float& total, float part) { total = std::max(total, part); });
  return std::sqrt(largest_sq);
}

SurfaceDistance measure_distance(const TriangleTree& first, const TriangleTree& second,
                                 float spacing_m, int threads) {
  const auto one_way = [&](const TriangleTree& from, const TriangleTree& to) {
    return largest_distance(
        sample_surface(from.positions(), from.triangles(), spacing_m, from.order()), to, threads);
  };
  return {one_way(first, second), one_way(second, first)};
}

}  // namespace cornice
