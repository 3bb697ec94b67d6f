// SPDX-License-Identifier: GPL-3.0-or-later
// Levels of detail after Schuetz, Potree: rendering large point clouds in web browsers (2016),
// section 3.2: a node keeps points that are at least its spacing apart (here: one a grid cell).
#include "core/io/copc_octree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/parallel.h"

namespace cornice {
namespace {

/// Bits of a coordinate within the cube. 7 of them number the grid cells of the deepest level.
constexpr int kBits = 28;
constexpr int kGridBits = 7;
constexpr int kDeepest = kBits - kGridBits;
static_assert(1 << kGridBits == kCopcGrid);

/// Turns stored integers into positions within the cube, 0 to 2^kBits - 1.
class Quantizer {
 public:
  Quantizer(const std::vector<Vec3<std::int32_t>>& stored, Vec3d scale, Vec3d offset,
            const CopcCube& cube)
      : stored_(stored), factor_(scale * (std::ldexp(1.0, kBits) / cube.side)) {
    shift_ = (offset - cube.min) * (std::ldexp(1.0, kBits) / cube.side);
  }
  Vec3<std::uint32_t> operator()(std::uint32_t i) const {
    const Vec3<std::int32_t>& p = stored_[i];
    return {clamped(p.x * factor_.x + shift_.x), clamped(p.y * factor_.y + shift_.y),
            clamped(p.z * factor_.z + shift_.z)};
  }

 private:
  static std::uint32_t clamped(double value) {
    constexpr double kMost = (1u << kBits) - 1;
    return static_cast<std::uint32_t>(std::clamp(value, 0.0, kMost));
  }

  const std::vector<Vec3<std::int32_t>>& stored_;
  Vec3d factor_;
  Vec3d shift_;
};

/// A node with what it keeps, and with what its children get.
struct Split {
  CopcNode node;
  std::array<std::vector<std::uint32_t>, 8> children;
};

/// Cells of a grid that have a point already.
class Occupancy {
 public:
  Occupancy() : bits_((std::size_t{1} << (3 * kGridBits)) / 64) {}
  /// True for the first point of a cell.
  bool take(std::uint32_t cell) {
    std::uint64_t& word = bits_[cell >> 6];
    const std::uint64_t bit = std::uint64_t{1} << (cell & 63u);
    const bool is_first = (word & bit) == 0;
    word |= bit;
    return is_first;
  }

 private:
  std::vector<std::uint64_t> bits_;
};

Split split(CopcNode open, const Quantizer& position, std::size_t most_points) {
  Split result;
  result.node.level = open.level;
  result.node.key = open.key;
  if (open.points.size() <= most_points || open.level >= kDeepest) {
    result.node.points = std::move(open.points);
    return result;
  }
  const int cell_shift = kBits - open.level - kGridBits;
  const int child_shift = kBits - open.level - 1;
  constexpr std::uint32_t kMask = kCopcGrid - 1;
  Occupancy occupied;
  for (const std::uint32_t i : open.points) {
    const Vec3<std::uint32_t> p = position(i);
    const std::uint32_t cell = ((p.x >> cell_shift) & kMask) |
                               (((p.y >> cell_shift) & kMask) << kGridBits) |
                               (((p.z >> cell_shift) & kMask) << (2 * kGridBits));
    if (occupied.take(cell)) {
      result.node.points.push_back(i);
    } else {
      const std::uint32_t child = ((p.x >> child_shift) & 1u) | (((p.y >> child_shift) & 1u) << 1) |
                                  (((p.z >> child_shift) & 1u) << 2);
      result.children[child].push_back(i);
    }
  }
  return result;
}

CopcNode child_of(const CopcNode& parent, std::uint32_t child, std::vector<std::uint32_t> points) {
  const auto bit = [child](unsigned axis) {
    return static_cast<std::int32_t>((child >> axis) & 1u);
  };
  CopcNode node;
  node.level = parent.level + 1;
  node.key = {2 * parent.key.x + bit(0), 2 * parent.key.y + bit(1), 2 * parent.key.z + bit(2)};
  node.points = std::move(points);
  return node;
}

}  // namespace

CopcCube copc_cube(const std::vector<Vec3<std::int32_t>>& stored, Vec3d scale, Vec3d offset) {
  Box3d box;
  for (const Vec3<std::int32_t>& p : stored) {
    box.add({p.x * scale.x + offset.x, p.y * scale.y + offset.y, p.z * scale.z + offset.z});
  }
  if (box.empty()) box.add(offset);
  const Vec3d extent = box.max - box.min;
  CopcCube cube;
  cube.min = box.min;
  // One step more, so that a single point has a cube too and the largest lies inside.
  cube.side = std::max({extent.x, extent.y, extent.z}) + std::max({scale.x, scale.y, scale.z});
  return cube;
}

std::vector<CopcNode> build_copc_octree(const std::vector<Vec3<std::int32_t>>& stored, Vec3d scale,
                                        Vec3d offset, const CopcCube& cube, std::size_t most_points,
                                        int threads, Progress& progress) {
  const Quantizer position(stored, scale, offset, cube);
  CopcNode root;
  root.points.resize(stored.size());
  for (std::size_t i = 0; i < stored.size(); ++i) root.points[i] = static_cast<std::uint32_t>(i);

  std::vector<CopcNode> nodes;
  std::vector<CopcNode> open;
  open.push_back(std::move(root));
  while (!open.empty()) {
    check_cancelled(progress);
    std::vector<Split> splits(open.size());
    parallel_for(open.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        splits[k] = split(std::move(open[k]), position, most_points);
      }
    });
    std::vector<CopcNode> next;
    for (Split& done : splits) {
      for (std::uint32_t child = 0; child < 8; ++child) {
        if (done.children[child].empty()) continue;
        next.push_back(child_of(done.node, child, std::move(done.children[child])));
      }
      nodes.push_back(std::move(done.node));
    }
    open = std::move(next);
  }
  return nodes;
}

}  // namespace cornice
