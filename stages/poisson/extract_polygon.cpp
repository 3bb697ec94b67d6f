// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/extract_polygon.h"

#include <cassert>
#include <limits>

namespace cornice {
namespace {

constexpr std::int64_t kForbidden = std::numeric_limits<std::int64_t>::max() / 4;

std::int64_t squared_length(const LoopCorner& a, const LoopCorner& b) {
  const Vec3<std::int64_t> d = (b.at - a.at).cast<std::int64_t>();
  return dot(d, d);
}

std::int64_t cost_of_diagonal(const LoopCorner& a, const LoopCorner& b) {
  return (a.faces & b.faces) != 0 ? kForbidden : squared_length(a, b);
}

/// Best ways to cut loop[first..last] off along the chord between its ends (Klincsek, "Minimal
/// triangulations of polygonal domains", 1980).
struct Cuts {
  std::array<std::array<std::int64_t, kMaxLoop>, kMaxLoop> cost{};
  std::array<std::array<std::uint8_t, kMaxLoop>, kMaxLoop> apex{};
};

std::size_t collect(const Cuts& cuts, std::uint8_t first, std::uint8_t last, std::size_t count,
                    LoopTriangles& triangles) {
  if (last - first < 2) return count;
  const std::uint8_t apex = cuts.apex[first][last];
  triangles[count++] = {first, apex, last};
  count = collect(cuts, first, apex, count, triangles);
  return collect(cuts, apex, last, count, triangles);
}

std::size_t cut_long_loop(std::span<const LoopCorner> loop, LoopTriangles& triangles) {
  const auto n = static_cast<std::uint8_t>(loop.size());
  Cuts cuts;
  for (std::uint8_t span = 2; span < n; ++span) {
    for (std::uint8_t first = 0; first + span < n; ++first) {
      const auto last = static_cast<std::uint8_t>(first + span);
      std::int64_t best = kForbidden;
      for (auto apex = static_cast<std::uint8_t>(first + 1); apex < last; ++apex) {
        const std::int64_t cost = cuts.cost[first][apex] + cuts.cost[apex][last];
        if (cost < best) best = cost, cuts.apex[first][last] = apex;
      }
      if (span < n - 1 && best < kForbidden) best += cost_of_diagonal(loop[first], loop[last]);
      cuts.cost[first][last] = best < kForbidden ? best : kForbidden;
    }
  }
  if (cuts.cost[0][n - 1] >= kForbidden) return 0;
  return collect(cuts, 0, static_cast<std::uint8_t>(n - 1), 0, triangles);
}

}  // namespace

std::size_t cut_loop(std::span<const LoopCorner> loop, LoopTriangles& triangles) {
  assert(loop.size() >= 3 && loop.size() <= kMaxLoop && "a loop has 3 to 12 corners");
  if (loop.size() == 3) {
    triangles[0] = {0, 1, 2};
    return 1;
  }
  if (loop.size() > 4) return cut_long_loop(loop, triangles);
  const std::int64_t first = cost_of_diagonal(loop[0], loop[2]);
  const std::int64_t second = cost_of_diagonal(loop[1], loop[3]);
  if (first >= kForbidden && second >= kForbidden) return 0;
  if (first <= second) {
    triangles[0] = {0, 1, 2}, triangles[1] = {0, 2, 3};
  } else {
    triangles[0] = {0, 1, 3}, triangles[1] = {1, 2, 3};
  }
  return 2;
}

}  // namespace cornice
