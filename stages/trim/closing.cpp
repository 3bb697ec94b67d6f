// SPDX-License-Identifier: GPL-3.0-or-later
// Morphological closing (Serra 1982, "Image analysis and mathematical morphology") of the measured
// part of a surface, with distances along edges (Dijkstra 1959).
#include "stages/trim/closing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

namespace cornice::trim {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
/// Vertices so near to a side of the bounding box lie on it.
constexpr float kOnSide_m = 1e-3f;
/// Lengths of runs are summed in whole parts of a metre: two tiles go along a border in opposite
/// directions and must get the same sum.
constexpr double kRunUnits = 1 << 20;

double length(const std::vector<Vec3f>& positions, std::uint32_t a, std::uint32_t b) {
  return norm(positions[a].cast<double>() - positions[b].cast<double>());
}

/// The edges that have an unmeasured end, as neighbours of each vertex.
class GapGraph {
 public:
  GapGraph(const std::vector<Vec3f>& positions, const std::vector<Triangle>& triangles,
           const std::vector<std::uint8_t>& measured)
      : positions_(positions), first_(positions.size() + 1, 0) {
    const auto each_edge = [&](auto&& visit) {
      for (const Triangle& t : triangles) {
        for (int k = 0; k < 3; ++k) {
          const std::uint32_t a = t[k], b = t[(k + 1) % 3];
          if (measured[a] != 0 && measured[b] != 0) continue;
          visit(a, b);
          visit(b, a);
        }
      }
    };
    each_edge([&](std::uint32_t a, std::uint32_t) { ++first_[a + 1]; });
    for (std::size_t v = 0; v < positions.size(); ++v) first_[v + 1] += first_[v];
    ends_.resize(first_.back());
    std::vector<std::uint32_t> at(first_.begin(), first_.end() - 1);
    each_edge([&](std::uint32_t a, std::uint32_t b) { ends_[at[a]++] = b; });
  }

  /// Distances up to `limit` from the sources along edges, through vertices with `open` alone.
  std::vector<double> distances(const std::vector<std::uint32_t>& sources,
                                const std::vector<std::uint8_t>& open, double limit) const {
    using Entry = std::pair<double, std::uint32_t>;
    std::vector<double> distance(positions_.size(), kFar);
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> front;
    for (const std::uint32_t v : sources) {
      distance[v] = 0.0;
      front.emplace(0.0, v);
    }
    while (!front.empty()) {
      const auto [d, v] = front.top();
      front.pop();
      if (d > distance[v]) continue;
      for (std::uint32_t i = first_[v]; i < first_[v + 1]; ++i) {
        const std::uint32_t w = ends_[i];
        if (open[w] == 0) continue;
        const double to = d + length(positions_, v, w);
        if (to > limit || to >= distance[w]) continue;
        distance[w] = to;
        front.emplace(to, w);
      }
    }
    return distance;
  }

 private:
  const std::vector<Vec3f>& positions_;
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> ends_;
};

/// Vertices on two sides of the bounding box in plan: where more than two tiles meet.
std::vector<std::uint8_t> tile_corners(const std::vector<Vec3f>& positions) {
  float low_x = std::numeric_limits<float>::infinity(), low_y = low_x;
  float high_x = -low_x, high_y = -low_x;
  for (const Vec3f& p : positions) {
    low_x = std::min(low_x, p.x), high_x = std::max(high_x, p.x);
    low_y = std::min(low_y, p.y), high_y = std::max(high_y, p.y);
  }
  const auto near = [](float a, float b) { return std::abs(a - b) <= kOnSide_m; };
  std::vector<std::uint8_t> corner(positions.size(), 0);
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const Vec3f& p = positions[v];
    corner[v] = (near(p.x, low_x) || near(p.x, high_x)) && (near(p.y, low_y) || near(p.y, high_y));
  }
  return corner;
}

/// Judges the vertices of one open border by the border alone: an unmeasured run is bridged where
/// it lies between measured vertices that are at most bridge_m apart along it.
void judge_border(const std::vector<Vec3f>& positions, const std::vector<std::uint32_t>& loop,
                  const std::vector<std::uint8_t>& measured,
                  const std::vector<std::uint8_t>& corner, double bridge_m,
                  std::vector<Fate>& fates) {
  const std::size_t n = loop.size();
  std::size_t start = 0;
  while (start < n && measured[loop[start]] == 0) ++start;
  if (start == n) return;  // nothing measured: all dropped
  for (std::size_t i = 0; i < n;) {
    const std::size_t before = (start + i) % n;
    // From one measured vertex to the next.
    std::int64_t run = 0;
    bool enclosed = true;
    std::size_t steps = 0;
    std::uint32_t at = loop[before];
    do {
      const std::uint32_t next = loop[(before + ++steps) % n];
      run += std::llround(length(positions, at, next) * kRunUnits);
      at = next;
      enclosed = enclosed && (measured[at] != 0 || corner[at] == 0);
    } while (measured[at] == 0 && steps < n);
    if (enclosed && run <= std::llround(bridge_m * kRunUnits)) {
      for (std::size_t s = 1; s < steps; ++s) fates[loop[(before + s) % n]] = Fate::kBridged;
    }
    i += steps;
  }
}

}  // namespace

std::vector<Fate> judge_vertices(const std::vector<Vec3f>& positions,
                                 const std::vector<Triangle>& triangles,
                                 const std::vector<std::uint32_t>& twins,
                                 const std::vector<std::uint8_t>& measured, double bridge_m) {
  std::vector<Fate> fates(positions.size(), Fate::kDropped);
  std::vector<std::uint8_t> gap(positions.size(), 0), border(positions.size(), 0);
  bool any_gap = false;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (measured[v] != 0) fates[v] = Fate::kMeasured;
    gap[v] = measured[v] == 0;
    any_gap = any_gap || gap[v] != 0;
  }
  if (!any_gap || bridge_m <= 0.0) return fates;

  const std::vector<std::uint8_t> corner = tile_corners(positions);
  for (const auto& loop : border_loops(triangles, twins, positions.size())) {
    for (const std::uint32_t v : loop) border[v] = 1;
    judge_border(positions, loop, measured, corner, bridge_m, fates);
  }
  // Dilation from what is measured, and from what the border has decided.
  const GapGraph graph(positions, triangles, measured);
  std::vector<std::uint32_t> sources;
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    if (fates[v] != Fate::kDropped) sources.push_back(v);
  }
  const std::vector<double> reach = graph.distances(sources, gap, 0.5 * bridge_m);
  // Erosion from what that has not reached.
  sources.clear();
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    const bool given_up = border[v] != 0 && fates[v] == Fate::kDropped;
    if (gap[v] != 0 && (given_up || reach[v] == kFar)) sources.push_back(v);
  }
  const std::vector<double> open = graph.distances(sources, gap, 0.5 * bridge_m);
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    if (gap[v] != 0 && border[v] == 0 && open[v] == kFar) fates[v] = Fate::kBridged;
  }
  return fates;
}

}  // namespace cornice::trim
