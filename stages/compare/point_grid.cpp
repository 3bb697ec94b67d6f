// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/compare/point_grid.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace cornice::compare {
namespace {

constexpr int kBits = 21;
constexpr std::int64_t kBias = std::int64_t{1} << (kBits - 1);

}  // namespace

std::int64_t PointGrid::cube(float x) const {
  return static_cast<std::int64_t>(std::floor(x / side_m_));
}

std::uint64_t PointGrid::key(std::int64_t x, std::int64_t y, std::int64_t z) {
  const auto part = [](std::int64_t v) {
    return static_cast<std::uint64_t>(std::clamp(v + kBias, std::int64_t{0}, 2 * kBias - 1));
  };
  return (part(z) << (2 * kBits)) | (part(y) << kBits) | part(x);
}

PointGrid::PointGrid(const std::vector<Vec3f>& positions, float side_m)
    : positions_(positions), side_m_(side_m), keys_(positions.size()), order_(positions.size()) {
  std::vector<std::uint64_t> unsorted(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Vec3f p = positions[i];
    unsorted[i] = key(cube(p.x), cube(p.y), cube(p.z));
  }
  std::iota(order_.begin(), order_.end(), 0u);
  std::sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return unsorted[a] != unsorted[b] ? unsorted[a] < unsorted[b] : a < b;
  });
  for (std::size_t i = 0; i < order_.size(); ++i) keys_[i] = unsorted[order_[i]];
}

std::size_t PointGrid::first_at_least(std::uint64_t wanted) const {
  return static_cast<std::size_t>(std::lower_bound(keys_.begin(), keys_.end(), wanted) -
                                  keys_.begin());
}

}  // namespace cornice::compare
