// SPDX-License-Identifier: GPL-3.0-or-later
// The search for neighbours, one leaf of the tree at a time.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/vec.h"
#include "stages/normals/neighbours.h"
#include "stages/normals/point_tree.h"
#include "stages/normals/search_kernels.h"

namespace cornice::normals {

/// Exact neighbour search for points of one leaf after the other; leaves that follow each other
/// share what has been learnt about the density. Results do not depend on the order of the calls.
/// Thread contract: one object per thread.
class LeafSearch {
 public:
  LeafSearch(const PointTree& tree, const NeighbourRule& rule);
  /// Makes `leaf` (an index of nodes()) the one whose points are asked for next, with `factor`
  /// times as many neighbours as the rule says.
  void open(std::uint32_t leaf, std::uint32_t factor = 1);
  /// Neighbours of point i of the open leaf.
  Neighbourhood find(std::uint32_t i);
  /// The same, into the next lane of `block`.
  void find(std::uint32_t i, NeighbourBlock& block);

 private:
  struct NearLeaf {
    Vec3f min, max;
    std::uint32_t begin, end;
    std::uint32_t place;  ///< of its first point in near_x_, near_y_, near_z_
  };
  /// Limits (bits of squared distances) that fewer, and at least as many as wanted, do not exceed.
  struct Bracket {
    std::int32_t low, high;
    std::uint32_t high_count;
    bool is_open() const { return high - low > 1; }
  };
  void collect_near_leaves(float reach_m);
  void gather(float reach_m);
  void add_candidates(const NearLeaf& near, std::uint32_t marks);
  Bracket first_bracket(Vec3f p, std::uint32_t wanted);
  std::uint32_t count_in_radius() const;
  std::uint32_t choose_within(std::int32_t limit);
  void drop_excess(Bracket bracket, std::uint32_t wanted);
  void choose(Bracket bracket, std::uint32_t wanted);
  std::uint32_t choose_neighbours(Vec3f p);
  void learn(float reach_sq);

  const PointTree* tree_;
  NeighbourRule rule_;
  std::uint32_t leaf_ = 0;
  std::uint32_t least_ = 0, most_ = 0;  ///< of the open leaf
  float reach_m_ = 0.0f;      ///< candidates hold every point this close to the leaf's box
  float hint_m_ = 0.0f;       ///< farthest neighbour met in the leaf before, factor 1
  float farthest_sq_ = 0.0f;  ///< farthest neighbour met in this leaf
  float latest_sq_ = 0.0f;    ///< farthest neighbour of the point asked for last
  std::uint32_t factor_ = 1;
  Vec3f region_min_, region_max_;  ///< near_leaves_ are all leaves that meet this box
  std::vector<NearLeaf> near_leaves_;
  std::vector<float> near_x_, near_y_, near_z_;
  bool whole_tree_ = false;  ///< candidates hold every point there is
  std::size_t candidates_ = 0;
  std::vector<float> x_, y_, z_;
  std::vector<std::int32_t> dist_sq_, chosen_sq_;
  std::vector<std::uint32_t> index_, chosen_, marks_;
  std::vector<float> dx_, dy_, dz_;
};

/// Calls body(i, neighbourhood) once for every point that is `wanted` (all where empty), on up to
/// `threads` threads; body must write only what belongs to point i.
void for_each_neighbourhood(const PointTree& tree, const NeighbourRule& rule, int threads,
                            const std::function<bool(std::uint32_t)>& wanted,
                            const std::function<void(std::uint32_t, const Neighbourhood&)>& body);

}  // namespace cornice::normals
