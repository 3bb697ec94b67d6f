// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/compare/surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "core/base/random.h"

namespace cornice::compare {
namespace {

float angle_between(Vec3f a, Vec3f b) {
  const float length = std::sqrt(dot(a, a) * dot(b, b));
  return length > 0.0f ? std::acos(std::clamp(dot(a, b) / length, -1.0f, 1.0f)) : 0.0f;
}

/// The cube of side `side` that a position lies in, as one number.
std::uint64_t cell_key(Vec3f p, float side, int dx, int dy, int dz) {
  const auto part = [&](float value, int shift) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(value / side)) + shift);
  };
  return mix64(mix64(mix64(part(p.x, dx)) + part(p.y, dy)) + part(p.z, dz));
}

}  // namespace

std::vector<Vec3f> vertex_normals(const std::vector<Vec3f>& positions,
                                  const std::vector<Triangle>& triangles) {
  std::vector<Vec3f> normals(positions.size());
  for (const Triangle& t : triangles) {
    const Vec3f a = positions[t[0]], b = positions[t[1]], c = positions[t[2]];
    const Vec3f face = normalized(cross(b - a, c - a));
    normals[t[0]] += face * angle_between(b - a, c - a);
    normals[t[1]] += face * angle_between(c - b, a - b);
    normals[t[2]] += face * angle_between(a - c, b - c);
  }
  for (Vec3f& n : normals) n = normalized(n);
  return normals;
}

std::vector<float> vertex_curvature(const Surface& surface) {
  std::vector<float> sum(surface.positions.size(), 0.0f);
  std::vector<float> count(surface.positions.size(), 0.0f);
  for (const Triangle& t : surface.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t i = t[k], j = t[(k + 1) % 3];
      const Vec3f edge = surface.positions[j] - surface.positions[i];
      const float length_sq = dot(edge, edge);
      if (!(length_sq > 0.0f)) continue;
      const float bend = dot(surface.normals[j] - surface.normals[i], edge) / length_sq;
      for (const std::uint32_t v : {i, j}) sum[v] += bend, count[v] += 1.0f;
    }
  }
  for (std::size_t v = 0; v < sum.size(); ++v) {
    if (count[v] > 0.0f) sum[v] /= count[v];
  }
  return sum;
}

void weld_borders(Surface& surface, const std::vector<std::uint32_t>& piece, float tolerance_m,
                  int threads) {
  const std::vector<std::uint32_t> twins =
      match_half_edges(surface.triangles, surface.positions.size(), threads);
  std::vector<std::uint32_t> target(surface.positions.size());
  for (std::size_t v = 0; v < target.size(); ++v) target[v] = static_cast<std::uint32_t>(v);
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> seen;
  std::vector<std::uint8_t> done(surface.positions.size(), 0);
  // Cells are wider than the tolerance, so that the equal of a vertex is in a neighbouring one.
  const float side = 4.0f * tolerance_m;
  const auto place = [&](std::uint32_t v) {
    if (done[v] != 0) return;
    done[v] = 1;
    const Vec3f p = surface.positions[v];
    for (int k = 0; k < 27; ++k) {
      const auto found = seen.find(cell_key(p, side, k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
      if (found == seen.end()) continue;
      for (const std::uint32_t other : found->second) {
        if (piece[other] == piece[v] || norm(surface.positions[other] - p) > tolerance_m) continue;
        target[v] = other;
        return;
      }
    }
    seen[cell_key(p, side, 0, 0, 0)].push_back(v);
  };
  for (std::uint32_t h = 0; h < twins.size(); ++h) {
    if (twins[h] != kOpenEdge) continue;
    place(surface.triangles[h / 3][h % 3]);
    place(surface.triangles[h / 3][(h + 1) % 3]);
  }
  for (Triangle& t : surface.triangles) {
    for (std::uint32_t& v : t) v = target[v];
  }
}

}  // namespace cornice::compare
