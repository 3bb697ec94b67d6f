// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/sizing.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include "core/base/parallel.h"

namespace cornice::remesh {
namespace {

constexpr std::size_t kGrain = 8192;
/// Of a walk over the surface before a search takes over.
constexpr int kMostSteps = 4;
/// Sweeps over all edges; one is enough but for the rare place where lengths fall against the order
/// of the triangles.
constexpr int kGradingSweeps = 12;
/// The error aimed at, as a share of the bound: leaves room for what the samples do not see and for
/// what later operations add.
constexpr float kAimedShare = 0.5f;

/// Longest that a wanted length may be at b, if it is `size` at a distance of d.
float graded(float size, float d, float grading) { return size + grading * d; }

}  // namespace

void start_sizes(WorkMesh& mesh, const SizeLimits& limits) {
  const std::size_t n = mesh.positions.size();
  std::vector<float> area(n, 0.0f), edge(n, 0.0f);
  std::vector<std::uint32_t> triangles(n, 0), edges(n, 0);
  for (const Triangle& t : mesh.triangles) {
    const Vec3f p = mesh.positions[t[0]];
    const float a = 0.5f * norm(cross(mesh.positions[t[1]] - p, mesh.positions[t[2]] - p));
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t v = t[k], w = t[(k + 1) % 3];
      area[v] += a;
      ++triangles[v];
      if (mesh.fixed[v] == 0 || mesh.fixed[w] == 0) continue;
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

namespace {

/// Steps from a triangle to its neighbours while they are nearer to p: most samples end where they
/// belong after one or two, for a fraction of what a search costs.
NearestPoint walk(Vec3f p, const TriangleTree& surface, const std::vector<std::uint32_t>& twins,
                  std::uint32_t from, float enough_sq) {
  const auto measure = [&](std::uint32_t t) {
    const Triangle& c = surface.triangles()[t];
    NearestPoint near = nearest_on_triangle(p, surface.positions()[c[0]], surface.positions()[c[1]],
                                            surface.positions()[c[2]]);
    near.triangle = t;
    return near;
  };
  NearestPoint best = measure(from);
  for (int step = 0; step < kMostSteps && best.distance_sq > enough_sq; ++step) {
    const std::uint32_t here = best.triangle;
    for (std::uint32_t h = 3 * here; h < 3 * here + 3; ++h) {
      if (twins[h] >= kNoTwin) continue;
      const NearestPoint next = measure(twins[h] / 3);
      if (next.distance_sq < best.distance_sq) best = next;
    }
    if (best.triangle == here) break;
  }
  return best;
}

}  // namespace

std::vector<float> triangle_errors(const std::vector<Vec3f>& samples, const TriangleTree& surface,
                                   float enough_m, int threads) {
  const std::vector<std::uint32_t> twins =
      match_half_edges(surface.triangles(), surface.positions().size(), threads);
  // Distances are not negative, so their bits are ordered as they are and the largest can be kept
  // by integers; the largest of several does not depend on who comes first.
  std::vector<std::uint32_t> bits(surface.triangles().size(), 0);
  parallel_for(samples.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    NearestQuery query;
    query.enough_sq = enough_m * enough_m;
    for (std::size_t i = begin; i < end; ++i) {
      NearestPoint found;
      if (query.guess != kOpenEdge) {
        found = walk(samples[i], surface, twins, query.guess, query.enough_sq);
        query.guess = found.triangle;
      }
      if (!found.found() || found.distance_sq > query.enough_sq) {
        found = surface.nearest(samples[i], query);
      }
      if (!found.found()) continue;
      query.guess = found.triangle;
      const auto mine = std::bit_cast<std::uint32_t>(std::sqrt(found.distance_sq));
      std::atomic_ref<std::uint32_t> most(bits[found.triangle]);
      std::uint32_t present = most.load(std::memory_order_relaxed);
      while (present < mine &&
             !most.compare_exchange_weak(present, mine, std::memory_order_relaxed)) {
      }
    }
  });
  std::vector<float> errors(bits.size());
  for (std::size_t t = 0; t < bits.size(); ++t) errors[t] = std::bit_cast<float>(bits[t]);
  return errors;
}

void adapt_sizes(WorkMesh& mesh, const std::vector<float>& errors, const SizeLimits& limits,
                 float smallest, float largest) {
  std::vector<float> worst(mesh.positions.size(), 0.0f);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) worst[v] = std::max(worst[v], errors[t]);
  }
  const float aim = kAimedShare * limits.error_m;
  for (std::size_t v = 0; v < worst.size(); ++v) {
    if (mesh.fixed[v] != 0) continue;
    const float factor = std::sqrt(aim / std::max(worst[v], 1e-3f * aim));
    mesh.size[v] *= std::clamp(factor, smallest, largest);
  }
}

}  // namespace cornice::remesh
