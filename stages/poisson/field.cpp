// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/field.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

#include "core/base/parallel.h"
#include "stages/poisson/closed_brick.h"

namespace cornice {
namespace {

constexpr int kClosedSide = kBrickSide + 1;
constexpr std::size_t kBricksAtATime = 256;
constexpr std::size_t kLevelsMax = 32;

constexpr int at9(int x, int y, int z) { return x + kClosedSide * (y + kClosedSide * z); }

struct Range {
  float low, high;
  bool may_cross() const { return low <= 0.0f && high >= 0.0f && !(low == 0.0f && high == 0.0f); }
};

/// Least and greatest of `side`^3 closed nodes from (x, y, z) on.
Range range_of(const float* closed, int x, int y, int z, int side) {
  Range range{closed[at9(x, y, z)], closed[at9(x, y, z)]};
  for (int k = z; k < z + side; ++k) {
    for (int j = y; j < y + side; ++j) {
      for (int i = x; i < x + side; ++i) {
        range.low = std::min(range.low, closed[at9(i, j, k)]);
        range.high = std::max(range.high, closed[at9(i, j, k)]);
      }
    }
  }
  return range;
}

/// Box of brick keys of one level, ends inclusive.
struct KeyBox {
  BrickKey first, last;
  bool contains(BrickKey b) const {
    return b.x >= first.x && b.x <= last.x && b.y >= first.y && b.y <= last.y && b.z >= first.z &&
           b.z <= last.z;
  }
  /// The bricks `levels` coarser that cover it.
  KeyBox coarser(int levels) const {
    return {{first.x >> levels, first.y >> levels, first.z >> levels},
            {last.x >> levels, last.y >> levels, last.z >> levels}};
  }
};

/// Bricks to look at on one level: those stored there, those that read nodes of a stored one on
/// their far faces, and those that a coarser level handed down.
std::vector<BrickKey> merged(const FieldLevel& stored, const BrickIndex& index,
                             std::vector<BrickKey> handed_down, const KeyBox& box) {
  for (const BrickKey brick : stored.bricks) {
    for (int o = 0; o < 8; ++o) {
      const BrickKey reader = shifted(brick, -(o & 1), -(o >> 1 & 1), -(o >> 2));
      if (!box.contains(reader)) continue;
      if (o == 0 || index.find(stored.bricks, reader) == BrickIndex::kNone)
        handed_down.push_back(reader);
    }
  }
  std::sort(handed_down.begin(), handed_down.end());
  handed_down.erase(std::unique(handed_down.begin(), handed_down.end()), handed_down.end());
  return handed_down;
}

/// All of `candidates` that pick(brick, out) appends, in their order.
template <class Pick>
std::vector<BrickKey> picked(const std::vector<BrickKey>& candidates, int threads, Pick pick) {
  std::vector<BrickKey> all;
  return parallel_reduce(
      candidates.size(), kBricksAtATime, threads, std::move(all),
      [&](std::size_t begin, std::size_t end) {
        std::vector<BrickKey> part;
        for (std::size_t i = begin; i < end; ++i) pick(candidates[i], part);
        return part;
      },
      [](std::vector<BrickKey>& sum, const std::vector<BrickKey>& part) {
        sum.insert(sum.end(), part.begin(), part.end());
      });
}

}  // namespace

Field::Field(Lattice lattice, std::vector<FieldLevel> levels)
    : lattice_(lattice), levels_(std::move(levels)) {
  assert(levels_.size() <= kLevelsMax && "coordinates have 31 bits");
  index_.reserve(levels_.size());
  for (const FieldLevel& level : levels_) {
    assert(level.values.size() == level.bricks.size() * kBrickNodes && "512 values a brick");
    assert(std::is_sorted(level.bricks.begin(), level.bricks.end()) && "bricks are sorted");
    index_.emplace_back(level.bricks);
  }
}

std::uint32_t Field::find(int level, BrickKey brick) const {
  const auto l = static_cast<std::size_t>(level);
  return index_[l].find(levels_[l].bricks, brick);
}

bool Field::closed_brick(int level, BrickKey brick,
                         std::span<float, kClosedBrickNodes> values) const {
  if (level < 0 || static_cast<std::size_t>(level) >= levels_.size()) return false;
  std::array<LevelView, kLevelsMax> views;
  std::size_t count = 0;
  for (auto l = static_cast<std::size_t>(level); l < levels_.size(); ++l)
    views[count++] = {levels_[l].bricks, &index_[l], levels_[l].values};
  return read_closed_brick(std::span(views).first(count), brick, values);
}

std::vector<BrickKey> Field::crossing_bricks(BrickKey first, BrickKey last, int threads) const {
  const KeyBox box{first, last};
  std::vector<BrickKey> candidates;
  for (int level = static_cast<int>(levels_.size()) - 1; level > 0; --level) {
    const auto l = static_cast<std::size_t>(level);
    candidates = merged(levels_[l], index_[l], std::move(candidates), box.coarser(level));
    const KeyBox finer = box.coarser(level - 1);
    candidates = picked(candidates, threads, [&](BrickKey brick, std::vector<BrickKey>& out) {
      std::array<float, kClosedBrickNodes> closed;
      if (!closed_brick(level, brick, closed)) return;
      constexpr int half = kBrickSide / 2;
      for (int o = 0; o < 8; ++o) {
        const int dx = o & 1, dy = o >> 1 & 1, dz = o >> 2;
        const BrickKey child{2 * brick.x + dx, 2 * brick.y + dy, 2 * brick.z + dz};
        if (!finer.contains(child)) continue;
        if (range_of(closed.data(), half * dx, half * dy, half * dz, half + 1).may_cross())
          out.push_back(child);
      }
    });
  }
  if (levels_.empty()) return {};
  candidates = merged(levels_[0], index_[0], std::move(candidates), box);
  return picked(candidates, threads, [&](BrickKey brick, std::vector<BrickKey>& out) {
    std::array<float, kClosedBrickNodes> closed;
    if (closed_brick(0, brick, closed) && range_of(closed.data(), 0, 0, 0, kClosedSide).may_cross())
      out.push_back(brick);
  });
}

}  // namespace cornice
