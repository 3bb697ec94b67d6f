// SPDX-License-Identifier: GPL-3.0-or-later
// An octree over points in Morton order, and the search for neighbours of one leaf at a time.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/base/vec.h"

namespace cornice::normals {

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
  /// `keys`, and must outlive the tree unmoved. About 5 bytes a point.
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

/// How many neighbours make a neighbourhood, the point itself included: all within radius_m, but
/// the nearest `least` where those are fewer, and only the nearest `most` where they are more.
struct NeighbourRule {
  std::uint32_t least = 16;
  std::uint32_t most = 16;
  float radius_m = 0.0f;
};

/// Neighbours of one point, itself included, in ascending order of index; among points at exactly
/// the same distance the lower index is nearer. The arrays have `size` entries and are valid until
/// the next search.
struct Neighbourhood {
  std::uint32_t size = 0;
  const std::uint32_t* index = nullptr;
  const float* dx = nullptr;  ///< neighbour - point, metres
  const float* dy = nullptr;
  const float* dz = nullptr;
  float reach_sq = 0.0f;  ///< square of the distance to the farthest neighbour
};

/// Exact neighbour search for points of one leaf after the other; leaves that follow each other
/// share what has been learnt about the density. Results do not depend on the order of the calls.
/// Thread contract: one object per thread.
class LeafSearch {
 public:
  LeafSearch(const PointTree& tree, const NeighbourRule& rule);
  /// Makes `leaf` (an index of nodes()) the one whose points are asked for next.
  void open(std::uint32_t leaf);
  /// Neighbours of point i of the open leaf; `factor` times as many as the rule says.
  Neighbourhood find(std::uint32_t i, std::uint32_t factor = 1);

 private:
  struct NearLeaf {
    Vec3f min, max;
    std::uint32_t begin, end;
  };
  void collect_near_leaves(float reach_m);
  void gather(float reach_m);
  std::size_t measure(Vec3f p);
  float generous_limit(std::size_t padded, std::uint32_t wanted, float& below);
  std::uint32_t choose_within(float limit);
  void drop_excess(std::uint32_t n, std::uint32_t wanted, float below, float limit);
  void choose(std::size_t padded, std::uint32_t wanted);
  Neighbourhood copy_chosen(Vec3f p, std::uint32_t n);

  const PointTree* tree_;
  NeighbourRule rule_;
  std::uint32_t leaf_ = 0;
  float reach_m_ = 0.0f;           ///< candidates hold every point this close to the leaf's box
  float hint_m_ = 0.0f;            ///< farthest neighbour met in the leaf before
  float farthest_sq_ = 0.0f;       ///< farthest neighbour met in this leaf
  float latest_sq_ = 0.0f;         ///< farthest neighbour of the point asked for last
  Vec3f region_min_, region_max_;  ///< near_leaves_ are all leaves that meet this box
  std::vector<NearLeaf> near_leaves_;
  bool whole_tree_ = false;  ///< candidates hold every point there is
  std::size_t candidates_ = 0;
  std::vector<float> x_, y_, z_, dist_sq_;
  std::vector<std::uint32_t> index_, chosen_;
  std::vector<float> dx_, dy_, dz_, chosen_sq_;
};

/// Calls body(i, neighbourhood) once for every point that is `wanted` (all where empty), on up to
/// `threads` threads; body must write only what belongs to point i.
void for_each_neighbourhood(const PointTree& tree, const NeighbourRule& rule, int threads,
                            const std::function<bool(std::uint32_t)>& wanted,
                            const std::function<void(std::uint32_t, const Neighbourhood&)>& body);

}  // namespace cornice::normals
