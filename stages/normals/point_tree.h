// SPDX-License-Identifier: GPL-3.0-or-later
// An octree over points in Morton order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/vec.h"

namespace cornice::normals {

/// Points a leaf may hold. Fewer: more nodes to walk; more: more candidates for each point's
/// neighbours. No more than a word of marks (search_kernels.h) has bits.
constexpr std::uint32_t kLeafPoints = 32;

/// Points [begin, end) in the tree's order. Nodes lie in depth-first order; `skip` is the index of
/// the first node that is not below this one, so a leaf's is its own index + 1.
struct TreeNode {
  Vec3f min, max;  ///< tight around the points
  std::uint32_t begin = 0, end = 0;
  std::uint32_t skip = 0;
};

/// Thread contract: const access from any number of threads.
class PointTree {
 public:
  PointTree() = default;
  /// `positions` must be in Morton order (sort_along_curve, coincident points removed), with their
  /// `keys`, and must outlive the tree unmoved. About 3 bytes a point.
  PointTree(std::span<const Vec3f> positions, std::span<const std::uint64_t> keys, int threads);

  std::span<const Vec3f> positions() const { return positions_; }
  const std::vector<TreeNode>& nodes() const { return nodes_; }
  /// Indices of the leaves among nodes(), in order; their points cover all N.
  const std::vector<std::uint32_t>& leaves() const { return leaves_; }

 private:
  std::span<const Vec3f> positions_;
  std::vector<TreeNode> nodes_;
  std::vector<std::uint32_t> leaves_;
};

}  // namespace cornice::normals
