// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/sizing.h"

#include <algorithm>
#include <cmath>

namespace cornice::remesh {
namespace {

/// Sweeps over all edges; one is enough but for the rare place where lengths fall against the order
/// of the triangles.
constexpr int kGradingSweeps = 12;
/// The error aimed at, as a share of the bound: leaves room for what the samples do not see and for
/// what later operations add.
constexpr float kAimedShare = 0.8f;

/// Of what its neighbours on the border want, a fixed vertex wants this at least. Edges that are
/// much shorter would be surrounded by rings of tiny triangles, and those at them are thin in any
/// case.
constexpr float kLeastOfNeighbours = 0.5f;

/// Longest that a wanted length may be at b, if it is `size` at a distance of d.
float graded(float size, float d, float grading) { return size + grading * d; }

}  // namespace

void start_sizes(WorkMesh& mesh, const SizeLimits& limits) {
  const std::size_t n = mesh.positions.size();
  const auto is_fixed = [&](std::uint32_t v, std::uint32_t w) {
    return mesh.fixed[v] != 0 && mesh.fixed[w] != 0;
  };
  std::vector<float> area(n, 0.0f), edge(n, 0.0f);
  std::vector<std::uint32_t> triangles(n, 0), edges(n, 0);
  for (const Triangle& t : mesh.triangles) {
    const Vec3f p = mesh.positions[t[0]];
    const float a = 0.5f * norm(cross(mesh.positions[t[1]] - p, mesh.positions[t[2]] - p));
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = t[k], w = t[(k + 1) % 3];
      area[v] += a;
      ++triangles[v];
      if (!is_fixed(v, w)) continue;
      const float length = norm(mesh.positions[w] - mesh.positions[v]);
      edge[v] += length, edge[w] += length;
      ++edges[v], ++edges[w];
    }
  }
  mesh.size.assign(n, limits.max_edge_m);
  for (std::size_t v = 0; v < n; ++v) {
    if (mesh.fixed[v] != 0 && edges[v] > 0) {
      mesh.size[v] = edge[v] / static_cast<float>(edges[v]);
    } else if (triangles[v] > 0) {
      // Area sqrt(3)/4 s^2.
      mesh.size[v] = std::sqrt(2.3094f * area[v] / static_cast<float>(triangles[v]));
    }
  }
  const std::vector<float> own = mesh.size;
  for (const Triangle& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = t[k], w = t[(k + 1) % 3];
      if (!is_fixed(v, w)) continue;
      mesh.size[v] = std::max(mesh.size[v], kLeastOfNeighbours * own[w]);
      mesh.size[w] = std::max(mesh.size[w], kLeastOfNeighbours * own[v]);
    }
  }
}

void grade_sizes(WorkMesh& mesh, const SizeLimits& limits) {
  for (std::size_t v = 0; v < mesh.size.size(); ++v) {
    if (mesh.fixed[v] != 0) continue;
    mesh.size[v] = std::clamp(mesh.size[v], limits.min_edge_m, limits.max_edge_m);
  }
  for (int sweep = 0; sweep < kGradingSweeps; ++sweep) {
    bool changed = false;
    for (const Triangle& t : mesh.triangles) {
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t a = t[k], b = t[(k + 1) % 3];
        float& sa = mesh.size[a];
        float& sb = mesh.size[b];
        if (sa == sb) continue;
        const float d = norm(mesh.positions[b] - mesh.positions[a]);
        float& longer = sa > sb ? sa : sb;
        const float most = graded(std::min(sa, sb), d, limits.grading);
        if (longer > most * 1.001f) {
          longer = most;
          changed = true;
        }
      }
    }
    if (!changed) break;
  }
}

void adapt_sizes(WorkMesh& mesh, const SizeLimits& limits, float smallest, float largest) {
  std::vector<float> worst(mesh.positions.size(), 0.0f);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) worst[v] = std::max(worst[v], mesh.error[t]);
  }
  const float aim = kAimedShare * limits.error_m;
  for (std::size_t v = 0; v < worst.size(); ++v) {
    if (mesh.fixed[v] != 0) continue;
    const float factor = std::sqrt(aim / std::max(worst[v], 1e-3f * aim));
    mesh.size[v] *= std::clamp(factor, smallest, largest);
  }
}

}  // namespace cornice::remesh
