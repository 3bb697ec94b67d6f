// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/cracks/random_views.h"

#include <algorithm>
#include <cmath>

namespace cornice::bench {

using namespace hlod;

FinePoint random_eye(const Tree& tree, CounterRandom& random) {
  FinePoint low = tree.cells.front().lowest, high = tree.cells.front().highest;
  for (const TreeCell& root : tree.level(0)) {
    low = {std::min(low.x, root.lowest.x), std::min(low.y, root.lowest.y),
           std::min(low.z, root.lowest.z)};
    high = {std::max(high.x, root.highest.x), std::max(high.y, root.highest.y),
            std::max(high.z, root.highest.z)};
  }
  const double spread = std::pow(4.0, random.uniform(-2.0, 3.0));
  const auto one = [&](std::int32_t a, std::int32_t b) {
    const double middle = 0.5 * (double{1} * a + b), half = 0.5 * (double{1} * b - a) + 1.0;
    double x = middle + random.uniform(-1.0, 1.0) * half * spread;
    if (random.uniform() < 0.3) {
      const int level = static_cast<int>(random.uniform(0.0, tree.metric.finest_level + 0.999));
      const double side = tree.metric.side(level);
      x = std::round(x / side) * side + std::floor(random.uniform(-1.0, 2.0));
    }
    return static_cast<std::int32_t>(std::clamp(x, -0x1p30, 0x1p30));
  };
  return {one(low.x, high.x), one(low.y, high.y), one(low.z, high.z)};
}

Radii random_radii(const Metric& metric, CounterRandom& random) {
  Radii radii;
  std::int64_t radius = 0;
  for (int l = metric.finest_level - 1; l >= 0; --l) {
    const double more = random.uniform() < 0.4 ? 0.0 : random.uniform(0.0, 2.0) * metric.side(l);
    const bool is_last = l == metric.finest_level - 1;
    if (is_last) radius = static_cast<std::int64_t>(random.uniform(-2.0, 3.0) * metric.side(l));
    if (!is_last) radius += metric.gap(l + 1) + static_cast<std::int64_t>(more);
    radii.of[static_cast<std::size_t>(l)] = radius;
  }
  settle(radii, metric);
  return radii;
}

std::vector<std::uint8_t> random_residency(const Tree& tree, CounterRandom& random) {
  std::vector<std::uint8_t> is_loaded(tree.cells.size(), 0);
  const double share = random.uniform(0.6, 1.0);
  for (std::size_t c = 0; c < tree.level(0).size(); ++c) is_loaded[c] = 1;
  for (const TreeCell& cell : tree.cells) {
    const std::size_t own = static_cast<std::size_t>(&cell - tree.cells.data());
    for (std::uint32_t n = 0; n < cell.children; ++n) {
      is_loaded[cell.first_child + n] = is_loaded[own] != 0 && random.uniform() < share ? 1 : 0;
    }
  }
  return is_loaded;
}

}  // namespace cornice::bench
