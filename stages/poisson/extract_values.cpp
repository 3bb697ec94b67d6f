// SPDX-License-Identifier: GPL-3.0-or-later
// What extraction reads of a field alone. The surface is followed from brick to brick anyway, so it
// is enough to find it somewhere: the stored values are looked at in a row, which is many times
// faster than Field::crossing_bricks(), which promises all.
#include <algorithm>
#include <array>

#include "core/base/parallel.h"
#include "stages/poisson/extract.h"

namespace cornice {
namespace {

constexpr std::size_t kBricksAtATime = 512;
constexpr int kClosed = kBrickSide + 1;

enum class Sign : std::uint8_t { kMixed, kNegative, kNotNegative };

/// Signs of the nodes that a brick owns.
Sign sign_of(const float* nodes) {
  std::int32_t below = 0;
  for (int n = 0; n < kBrickNodes; ++n) below += nodes[n] < 0.0f ? 1 : 0;
  return below == 0 ? Sign::kNotNegative : below == kBrickNodes ? Sign::kNegative : Sign::kMixed;
}

/// Finds bricks of level 0 that the surface passes through: of every piece at least one. Looks at
/// what is stored of every level, and below bricks of coarser levels where finer ones are missing.
class SeedFinder {
 public:
  SeedFinder(const Field& field, BrickKey first, BrickKey last, int threads)
      : field_(field), first_(first), last_(last), threads_(threads) {}

  std::vector<BrickKey> find() const {
    std::vector<BrickKey> all;
    for (std::size_t l = 0; l < field_.levels().size(); ++l) {
      const std::vector<BrickKey> found = seeds_of_level(l);
      all.insert(all.end(), found.begin(), found.end());
    }
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  }

 private:
  bool is_inside(std::size_t level, BrickKey b) const {
    const auto within = [&](std::int32_t c, std::int32_t low, std::int32_t high) {
      return c >= low >> level && c <= high >> level;
    };
    return within(b.x, first_.x, last_.x) && within(b.y, first_.y, last_.y) &&
           within(b.z, first_.z, last_.z);
  }

  std::vector<Sign> signs_of_level(std::size_t level) const {
    const FieldLevel& stored = field_.levels()[level];
    std::vector<Sign> signs(stored.bricks.size());
    parallel_for(signs.size(), kBricksAtATime, threads_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t b = begin; b < end; ++b) {
        signs[b] = sign_of(stored.values.data() + b * kBrickNodes);
      }
    });
    return signs;
  }

  /// True where the sign changes in the brick, or between it and the next one along an axis.
  bool may_cross(std::size_t level, const std::vector<Sign>& signs, std::size_t b) const {
    if (signs[b] == Sign::kMixed) return true;
    for (int axis = 0; axis < 3; ++axis) {
      const BrickKey next = shifted(field_.levels()[level].bricks[b], axis == 0 ? 1 : 0,
                                    axis == 1 ? 1 : 0, axis == 2 ? 1 : 0);
      const std::uint32_t at = field_.find(static_cast<int>(level), next);
      if (at != BrickIndex::kNone && signs[at] != Sign::kMixed && signs[at] != signs[b])
        return true;
    }
    return false;
  }

  std::vector<BrickKey> seeds_of_level(std::size_t level) const {
    const std::vector<BrickKey>& bricks = field_.levels()[level].bricks;
    const std::vector<Sign> signs = signs_of_level(level);
    return parallel_reduce(
        bricks.size(), kBricksAtATime, threads_, std::vector<BrickKey>(),
        [&](std::size_t begin, std::size_t end) {
          std::vector<BrickKey> part;
          for (std::size_t b = begin; b < end; ++b) {
            if (!is_inside(level, bricks[b]) || !may_cross(level, signs, b)) continue;
            if (level == 0) {
              part.push_back(bricks[b]);
            } else {
              descend(level, bricks[b], part);
            }
          }
          return part;
        },
        [](std::vector<BrickKey>& sum, const std::vector<BrickKey>& part) {
          sum.insert(sum.end(), part.begin(), part.end());
        });
  }

  /// Follows the crossings of a brick into those of its children that are not stored.
  void descend(std::size_t level, BrickKey brick, std::vector<BrickKey>& seeds) const {
    std::array<float, kClosedBrickNodes> closed;
    bool is_read = false;
    for (int o = 0; o < 8; ++o) {
      const int dx = o & 1, dy = o >> 1 & 1, dz = o >> 2;
      const BrickKey child{2 * brick.x + dx, 2 * brick.y + dy, 2 * brick.z + dz};
      if (!is_inside(level - 1, child) ||
          field_.find(static_cast<int>(level) - 1, child) != BrickIndex::kNone) {
        continue;
      }
      if (!is_read && !field_.closed_brick(static_cast<int>(level), brick, closed)) return;
      is_read = true;
      if (!crosses(closed, dx, dy, dz)) continue;
      if (level == 1) {
        seeds.push_back(child);
      } else {
        descend(level - 1, child, seeds);
      }
    }
  }

  /// True where the closed nodes of an eighth of a brick have both signs.
  static bool crosses(const std::array<float, kClosedBrickNodes>& closed, int dx, int dy, int dz) {
    constexpr int kHalf = kBrickSide / 2;
    int below = 0;
    for (int k = kHalf * dz; k <= kHalf * (dz + 1); ++k) {
      for (int j = kHalf * dy; j <= kHalf * (dy + 1); ++j) {
        const float* row = closed.data() + kHalf * dx + kClosed * (j + kClosed * k);
        for (int i = 0; i <= kHalf; ++i) below += row[i] < 0.0f ? 1 : 0;
      }
    }
    return below > 0 && below < (kHalf + 1) * (kHalf + 1) * (kHalf + 1);
  }

  const Field& field_;
  BrickKey first_, last_;
  int threads_;
};

}  // namespace

const float* FieldValues::stored(BrickKey brick) const {
  if (field_->levels().empty() || !is_known(brick)) return nullptr;
  const std::uint32_t at = field_->find(0, brick);
  if (at == BrickIndex::kNone) return nullptr;
  return field_->levels()[0].values.data() + std::size_t{at} * kBrickNodes;
}

bool FieldValues::compute(BrickKey brick, std::span<float, kBrickNodes> values) const {
  std::array<float, kClosedBrickNodes> closed;
  if (!is_known(brick) || !field_->closed_brick(0, brick, closed)) return false;
  for (int k = 0; k < kBrickSide; ++k) {
    for (int j = 0; j < kBrickSide; ++j) {
      std::copy_n(closed.data() + kClosed * (j + kClosed * k), kBrickSide,
                  values.data() + kBrickSide * (j + kBrickSide * k));
    }
  }
  return true;
}

std::vector<BrickKey> FieldValues::crossing_bricks(BrickKey first, BrickKey last,
                                                   int threads) const {
  first.z = first_z_, last.z = last_z_;
  return SeedFinder(*field_, first, last, threads).find();
}

}  // namespace cornice
