// SPDX-License-Identifier: GPL-3.0-or-later
// Leaves hold a handful of points that are searched for together: the points around a leaf are
// collected once, then every point of the leaf measures them all in straight loops without
// branches, which the compiler turns into vector instructions. docs/decisions/ compares it with
// FLANN.
#include "stages/normals/point_tree.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"

namespace cornice::normals {
namespace {

/// Points a leaf may hold. Fewer: more nodes to walk; more: more candidates per point.
constexpr std::uint32_t kLeafPoints = 16;
/// Subtrees of at most this many points are built in parallel.
constexpr std::uint32_t kTaskPoints = 1u << 16;
constexpr int kTopShift = 60;  ///< of the first octant digit in a 63-bit key
/// Candidate arrays are padded to whole vectors with points that are nobody's neighbour.
constexpr std::size_t kLanes = 16;
constexpr float kFarAway = 1e18f;
/// Points whose leaves share one walk from the root.
constexpr std::uint32_t kGroupPoints = 256;
/// Neighbours too many that are cheaper to drop one by one than to avoid.
constexpr std::uint32_t kExcess = 4;

using Nodes = std::vector<TreeNode>;

bool meets(Vec3f a_min, Vec3f a_max, Vec3f b_min, Vec3f b_max) {
  return (a_min.x <= b_max.x) & (a_max.x >= b_min.x) & (a_min.y <= b_max.y) & (a_max.y >= b_min.y) &
         (a_min.z <= b_max.z) & (a_max.z >= b_min.z);
}

bool encloses(Vec3f a_min, Vec3f a_max, Vec3f b_min, Vec3f b_max) {
  return a_min.x <= b_min.x && a_max.x >= b_max.x && a_min.y <= b_min.y && a_max.y >= b_max.y &&
         a_min.z <= b_min.z && a_max.z >= b_max.z;
}

std::uint32_t count_within(const float* dist_sq, std::size_t n, float limit_sq) {
  std::int32_t count = 0;
  for (std::size_t j = 0; j < n; ++j) count += dist_sq[j] <= limit_sq ? 1 : 0;
  return static_cast<std::uint32_t>(count);
}

/// Regula falsi for the limit of squared distance that a wanted number of points do not exceed. On
/// a sheet the count grows with the square of the distance, so few rounds are needed.
struct LimitSearch {
  float low, high;              ///< limits that fewer, and at least as many, do not exceed
  float low_count, high_count;  ///< how many do not exceed them

  bool brackets(float limit) const { return limit > low && limit < high; }
  float middle(float aim) const {
    const float share = (aim - low_count) / std::max(high_count - low_count, 1.0f);
    return low + (high - low) * std::clamp(share, 0.05f, 0.95f);
  }
  /// Takes in that `count` do not exceed `limit`; returns the limit to try next.
  float next(float limit, std::uint32_t count, std::uint32_t wanted, float beyond) {
    (count < wanted ? low : high) = limit;
    (count < wanted ? low_count : high_count) = static_cast<float>(count);
    return middle(static_cast<float>(wanted) + beyond);
  }
};

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

/// Distance within which about `count` points lie if they are spread over the leaf's box as on a
/// sheet; 0 where the box has no area.
float guessed_reach(const TreeNode& leaf, std::uint32_t count) {
  Vec3f size = leaf.max - leaf.min;
  if (size.x < size.y) std::swap(size.x, size.y);
  if (size.y < size.z) std::swap(size.y, size.z);
  if (size.x < size.y) std::swap(size.x, size.y);
  const float area = size.x * size.y;
  const auto points = static_cast<float>(leaf.end - leaf.begin);
  return std::sqrt(area * static_cast<float>(count) / (3.14f * points));
}

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

LeafSearch::LeafSearch(const PointTree& tree, const NeighbourRule& rule)
    : tree_(&tree), rule_(rule) {}

void LeafSearch::open(std::uint32_t leaf) {
  leaf_ = leaf;
  if (farthest_sq_ > 0.0f) hint_m_ = std::sqrt(farthest_sq_);
  farthest_sq_ = 0.0f;
  const TreeNode& node = tree_->nodes()[leaf];
  // The reach decides the work, never the result.
  const float guess = hint_m_ > 0.0f ? hint_m_ * 1.1f : guessed_reach(node, rule_.least) * 1.2f;
  gather(std::max({guess, rule_.radius_m, 1e-3f}));
}

/// Lists the leaves around the largest node above the open leaf with at most kGroupPoints, so that
/// the leaves that follow need not start from the root.
void LeafSearch::collect_near_leaves(float reach_m) {
  const std::vector<TreeNode>& nodes = tree_->nodes();
  const std::uint32_t first = nodes[leaf_].begin;
  std::uint32_t group = 0;
  while (group != leaf_ && nodes[group].end - nodes[group].begin > kGroupPoints) {
    for (++group; first >= nodes[group].end;) group = nodes[group].skip;
  }
  const float margin = 1.5f * reach_m;
  region_min_ = nodes[group].min - Vec3f{margin, margin, margin};
  region_max_ = nodes[group].max + Vec3f{margin, margin, margin};
  near_leaves_.clear();
  for (std::uint32_t at = 0; at < nodes.size();) {
    const TreeNode& node = nodes[at];
    if (!meets(node.min, node.max, region_min_, region_max_)) {
      at = node.skip;
    } else {
      if (node.skip == at + 1) near_leaves_.push_back({node.min, node.max, node.begin, node.end});
      ++at;
    }
  }
}

void LeafSearch::gather(float reach_m) {
  reach_m_ = reach_m;
  const TreeNode& leaf = tree_->nodes()[leaf_];
  const Vec3f low = leaf.min - Vec3f{reach_m, reach_m, reach_m};
  const Vec3f high = leaf.max + Vec3f{reach_m, reach_m, reach_m};
  if (near_leaves_.empty() || !encloses(region_min_, region_max_, low, high)) {
    collect_near_leaves(reach_m);
  }
  const Vec3f* const positions = tree_->positions().data();
  std::size_t n = 0;
  for (const NearLeaf& near : near_leaves_) {
    if (!meets(near.min, near.max, low, high)) continue;
    const std::size_t needed = n + (near.end - near.begin) + kLanes;
    if (x_.size() < needed) {
      for (auto* array : {&x_, &y_, &z_, &dist_sq_, &chosen_sq_}) array->resize(2 * needed);
      for (auto* array : {&index_, &chosen_}) array->resize(2 * needed);
    }
    for (std::uint32_t i = near.begin; i < near.end; ++i) {
      const Vec3f p = positions[i];
      x_[n] = p.x, y_[n] = p.y, z_[n] = p.z, index_[n] = i;
      n += meets(p, p, low, high) ? 1 : 0;
    }
  }
  candidates_ = n;
  whole_tree_ = n == tree_->positions().size();
  for (; n % kLanes != 0; ++n) x_[n] = y_[n] = z_[n] = kFarAway;
}

/// Squared distances of all candidates to p; returns the padded number of candidates.
std::size_t LeafSearch::measure(Vec3f p) {
  const std::size_t n = (candidates_ + kLanes - 1) / kLanes * kLanes;
  const float* x = x_.data();
  const float* y = y_.data();
  const float* z = z_.data();
  float* out = dist_sq_.data();
  for (std::size_t j = 0; j < n; ++j) {
    const float dx = x[j] - p.x, dy = y[j] - p.y, dz = z[j] - p.z;
    out[j] = dx * dx + dy * dy + dz * dz;
  }
  return n;
}

/// A limit that at least `wanted` of the squared distances do not exceed, and mostly few more.
/// `below` gets one that fewer do not exceed.
float LeafSearch::generous_limit(std::size_t padded, std::uint32_t wanted, float& below) {
  float high = std::numeric_limits<float>::max();
  if (!whole_tree_) high = reach_m_ * reach_m_;
  LimitSearch search{0.0f, high, 0.0f, static_cast<float>(candidates_)};
  float limit = std::min(latest_sq_ > 0.0f ? 1.2f * latest_sq_ : 0.3f * high, high);
  for (int round = 0; round < 12 && search.brackets(limit); ++round) {
    const std::uint32_t count = count_within(dist_sq_.data(), padded, limit);
    below = search.low;
    if (count >= wanted && count <= wanted + kExcess) return limit;
    limit = search.next(limit, count, wanted, 0.5f * kExcess);
  }
  below = search.low;
  return search.high;
}

/// Copies the places and squared distances of candidates within `limit` to the front of chosen_.
std::uint32_t LeafSearch::choose_within(float limit) {
  std::uint32_t n = 0;
  for (std::uint32_t j = 0; j < candidates_; ++j) {
    chosen_[n] = j;
    chosen_sq_[n] = dist_sq_[j];
    n += dist_sq_[j] <= limit ? 1 : 0;
  }
  return n;
}

/// Drops all but the `wanted` nearest of the n chosen, which stay in order.
void LeafSearch::drop_excess(std::uint32_t n, std::uint32_t wanted, float below, float limit) {
  const std::size_t padded = (n + kLanes - 1) / kLanes * kLanes;
  std::fill(chosen_sq_.begin() + n, chosen_sq_.begin() + static_cast<std::ptrdiff_t>(padded),
            std::numeric_limits<float>::max());
  LimitSearch search{below, limit, 0.0f, static_cast<float>(n)};
  search.low_count = static_cast<float>(count_within(chosen_sq_.data(), padded, below));
  limit = search.middle(static_cast<float>(wanted));
  for (int round = 0; round < 8 && search.brackets(limit); ++round) {
    const std::uint32_t count = count_within(chosen_sq_.data(), padded, limit);
    if (count == wanted) break;
    limit = search.next(limit, count, wanted, 0.0f);
  }
  if (count_within(chosen_sq_.data(), padded, limit) != wanted) {
    std::vector<float> sorted(chosen_sq_.begin(), chosen_sq_.begin() + n);
    std::nth_element(sorted.begin(), sorted.begin() + (wanted - 1), sorted.end());
    limit = sorted[wanted - 1];
  }
  // Where more than are wanted lie within the limit, they tie at it: the lower indices are nearer.
  std::uint32_t excess = count_within(chosen_sq_.data(), padded, limit) - wanted;
  for (std::uint32_t c = n; c-- > 0 && excess > 0;) {
    if (chosen_sq_[c] != limit) continue;
    chosen_sq_[c] = std::numeric_limits<float>::max();
    --excess;
  }
  std::uint32_t kept = 0;
  for (std::uint32_t c = 0; c < n; ++c) {
    chosen_[kept] = chosen_[c];
    kept += chosen_sq_[c] <= limit ? 1 : 0;
  }
}

/// Leaves in chosen_ the places of the `wanted` nearest candidates, in ascending order.
void LeafSearch::choose(std::size_t padded, std::uint32_t wanted) {
  float below = 0.0f;
  float limit = kFarAway * kFarAway;
  if (wanted < candidates_) limit = generous_limit(padded, wanted, below);
  const std::uint32_t n = choose_within(limit);
  if (n > wanted) drop_excess(n, wanted, below, limit);
}

Neighbourhood LeafSearch::copy_chosen(Vec3f p, std::uint32_t n) {
  if (dx_.size() < n) {
    for (auto* array : {&dx_, &dy_, &dz_}) array->resize(2 * n);
  }
  Neighbourhood found{n, chosen_.data(), dx_.data(), dy_.data(), dz_.data(), 0.0f};
  for (std::uint32_t c = 0; c < n; ++c) {
    const std::uint32_t j = chosen_[c];
    dx_[c] = x_[j] - p.x, dy_[c] = y_[j] - p.y, dz_[c] = z_[j] - p.z;
    found.reach_sq = std::max(found.reach_sq, dist_sq_[j]);
    chosen_[c] = index_[j];
  }
  return found;
}

Neighbourhood LeafSearch::find(std::uint32_t i, std::uint32_t factor) {
  const auto times = [factor](std::uint32_t count) {
    constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
    return static_cast<std::uint32_t>(std::min(kMost, std::uint64_t{count} * factor));
  };
  const std::uint32_t least = times(rule_.least), most = times(rule_.most);
  const Vec3f p = tree_->positions()[i];
  std::size_t padded = measure(p);
  const float radius_sq = rule_.radius_m * rule_.radius_m;
  // The box of candidates holds the ball of radius reach_m_ around p, but perhaps no larger one.
  while (!whole_tree_ && count_within(dist_sq_.data(), padded, reach_m_ * reach_m_) < least) {
    gather(reach_m_ * 1.5f);
    padded = measure(p);
  }
  std::uint32_t wanted = least;
  if (most > least) {
    wanted = std::clamp(count_within(dist_sq_.data(), padded, radius_sq), least, most);
  }
  wanted = std::min(wanted, static_cast<std::uint32_t>(candidates_));
  choose(padded, wanted);
  const Neighbourhood found = copy_chosen(p, wanted);
  if (factor == 1) {
    latest_sq_ = found.reach_sq;
    farthest_sq_ = std::max(farthest_sq_, found.reach_sq);
  }
  return found;
}

void for_each_neighbourhood(const PointTree& tree, const NeighbourRule& rule, int threads,
                            const std::function<bool(std::uint32_t)>& wanted,
                            const std::function<void(std::uint32_t, const Neighbourhood&)>& body) {
  constexpr std::size_t kLeavesPerTask = 512;
  const std::vector<std::uint32_t>& leaves = tree.leaves();
  parallel_for(leaves.size(), kLeavesPerTask, threads, [&](std::size_t begin, std::size_t end) {
    LeafSearch search(tree, rule);
    for (std::size_t l = begin; l < end; ++l) {
      const TreeNode& leaf = tree.nodes()[leaves[l]];
      bool is_open = false;
      for (std::uint32_t i = leaf.begin; i < leaf.end; ++i) {
        if (wanted && !wanted(i)) continue;
        if (!is_open) search.open(leaves[l]);
        is_open = true;
        body(i, search.find(i));
      }
    }
  });
}

}  // namespace cornice::normals
