// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/point_tree.h"

#include <algorithm>
#include <cassert>

#include "core/base/parallel.h"

namespace cornice::normals {
namespace {

/// Subtrees of at most this many points are built in parallel.
constexpr std::uint32_t kTaskPoints = 1u << 16;
constexpr int kTopShift = 60;  ///< of the first octant digit in a 63-bit key

using Nodes = std::vector<TreeNode>;

TreeNode box_around(std::span<const Vec3f> positions, std::uint32_t begin, std::uint32_t end) {
  TreeNode node{positions[begin], positions[begin], begin, end, 0};
  for (std::uint32_t i = begin + 1; i < end; ++i) {
    const Vec3f p = positions[i];
    node.min = {std::min(node.min.x, p.x), std::min(node.min.y, p.y), std::min(node.min.z, p.z)};
    node.max = {std::max(node.max.x, p.x), std::max(node.max.y, p.y), std::max(node.max.z, p.z)};
  }
  return node;
}

void grow(TreeNode& node, const TreeNode& child) {
  node.min = {std::min(node.min.x, child.min.x), std::min(node.min.y, child.min.y),
              std::min(node.min.z, child.min.z)};
  node.max = {std::max(node.max.x, child.max.x), std::max(node.max.y, child.max.y),
              std::max(node.max.z, child.max.z)};
}

/// Builds nodes over sorted keys, depth first.
class Builder {
 public:
  Builder(std::span<const Vec3f> positions, std::span<const std::uint64_t> keys)
      : positions_(positions), keys_(keys) {}

  /// Calls visit(begin, end, shift) for the parts of [begin, end), in order. Keys that are all
  /// equal are halved instead: they are sorted by x, so the halves are slabs.
  template <class Visit>
  void for_each_child(std::uint32_t begin, std::uint32_t end, int shift, Visit visit) const {
    if (keys_[begin] == keys_[end - 1]) {
      const std::uint32_t middle = begin + (end - begin) / 2;
      visit(begin, middle, shift);
      visit(middle, end, shift);
      return;
    }
    // Digits above the first that differs would give chains of nodes with one child.
    while ((keys_[begin] >> shift) == (keys_[end - 1] >> shift)) shift -= 3;
    while (begin < end) {
      const std::uint64_t past = ((keys_[begin] >> shift) + 1) << shift;
      const auto first = keys_.begin() + begin;
      const auto last = std::lower_bound(first, keys_.begin() + end, past);
      const auto next = begin + static_cast<std::uint32_t>(last - first);
      visit(begin, next, shift - 3);
      begin = next;
    }
  }

  /// Ends of the subtrees that parallel tasks build: at most kTaskPoints each, in order.
  void split(std::uint32_t begin, std::uint32_t end, int shift,
             std::vector<std::pair<std::uint32_t, int>>& tasks) const {
    if (end - begin <= kTaskPoints) {
      tasks.emplace_back(begin, shift);
      return;
    }
    for_each_child(begin, end, shift,
                   [&](std::uint32_t b, std::uint32_t e, int s) { split(b, e, s, tasks); });
  }

  void build(std::uint32_t begin, std::uint32_t end, int shift, Nodes& nodes) const {
    const std::size_t self = nodes.size();
    if (end - begin <= kLeafPoints) {
      nodes.push_back(box_around(positions_, begin, end));
    } else {
      nodes.push_back({positions_[begin], positions_[begin], begin, end, 0});
      for_each_child(begin, end, shift, [&](std::uint32_t b, std::uint32_t e, int s) {
        const std::size_t child = nodes.size();
        build(b, e, s, nodes);
        grow(nodes[self], nodes[child]);
      });
    }
    nodes[self].skip = static_cast<std::uint32_t>(nodes.size());
  }

  /// As build(), taking finished subtrees from `parts` instead of building them.
  void assemble(std::uint32_t begin, std::uint32_t end, int shift, std::vector<Nodes>& parts,
                std::size_t& part, Nodes& nodes) const {
    const std::size_t self = nodes.size();
    if (end - begin <= kTaskPoints) {
      for (TreeNode& node : parts[part]) {
        node.skip += static_cast<std::uint32_t>(self);
        nodes.push_back(node);
      }
      parts[part++] = {};
      return;
    }
    nodes.push_back({positions_[begin], positions_[begin], begin, end, 0});
    for_each_child(begin, end, shift, [&](std::uint32_t b, std::uint32_t e, int s) {
      const std::size_t child = nodes.size();
      assemble(b, e, s, parts, part, nodes);
      grow(nodes[self], nodes[child]);
    });
    nodes[self].skip = static_cast<std::uint32_t>(nodes.size());
  }

 private:
  std::span<const Vec3f> positions_;
  std::span<const std::uint64_t> keys_;
};

}  // namespace

PointTree::PointTree(std::span<const Vec3f> positions, std::span<const std::uint64_t> keys,
                     int threads)
    : positions_(positions) {
  assert(positions.size() == keys.size());
  if (positions.empty()) return;
  const auto n = static_cast<std::uint32_t>(positions.size());
  const Builder builder(positions, keys);
  std::vector<std::pair<std::uint32_t, int>> tasks;
  builder.split(0, n, kTopShift, tasks);
  std::vector<Nodes> parts(tasks.size());
  parallel_for(tasks.size(), 1, threads, [&](std::size_t t, std::size_t) {
    const std::uint32_t end = t + 1 < tasks.size() ? tasks[t + 1].first : n;
    builder.build(tasks[t].first, end, tasks[t].second, parts[t]);
  });
  std::size_t total = 64 + tasks.size();
  for (const Nodes& part : parts) total += part.size();
  nodes_.reserve(total);
  std::size_t part = 0;
  builder.assemble(0, n, kTopShift, parts, part, nodes_);
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    if (nodes_[i].skip == i + 1) leaves_.push_back(i);
  }
}

}  // namespace cornice::normals
