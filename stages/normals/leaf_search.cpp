// SPDX-License-Identifier: GPL-3.0-or-later
// The points around a leaf are collected once; then every point of the leaf measures them all in
// straight loops (search_kernels.h). The k nearest are those within a limit of squared distance
// that is found by counting: eight limits at a time, compared as the integers that floats >= 0 are
// ordered like. docs/decisions/ compares it with FLANN.
#include "stages/normals/leaf_search.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"

namespace cornice::normals {
namespace {

/// Points whose leaves share one walk from the root.
constexpr std::uint32_t kGroupPoints = 256;
/// A limit beyond every real squared distance, in square metres, and coordinates beyond that, for
/// what fills up the last word.
constexpr float kBeyond_sq = 1e32f;
constexpr float kFarAway = 1e18f;
/// Candidates within a limit that are cheaper to copy than to count once more among all.
constexpr std::uint32_t kFew = 64;
/// Squares of the farthest neighbours' distances of two points next to each other differ by some
/// tenths; the last rung is for the reach.
constexpr std::array<float, kRungs - 1> kLadder{0.75f, 0.87f, 0.97f, 1.07f, 1.18f, 1.32f, 1.6f};

bool meets(Vec3f a_min, Vec3f a_max, Vec3f b_min, Vec3f b_max) {
  return (a_min.x <= b_max.x) & (a_max.x >= b_min.x) & (a_min.y <= b_max.y) & (a_max.y >= b_min.y) &
         (a_min.z <= b_max.z) & (a_max.z >= b_min.z);
}

bool encloses(Vec3f a_min, Vec3f a_max, Vec3f b_min, Vec3f b_max) {
  return a_min.x <= b_min.x && a_max.x >= b_max.x && a_min.y <= b_min.y && a_max.y >= b_max.y &&
         a_min.z <= b_min.z && a_max.z >= b_max.z;
}

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

/// Eight limits in (low, high], evenly spaced, the last of them high.
Rungs rungs_between(std::int32_t low, std::int32_t high) {
  Rungs rungs;
  const std::int64_t width = std::int64_t{high} - low;
  for (std::size_t r = 0; r < kRungs; ++r) {
    const auto share = static_cast<std::int64_t>(r + 1);
    rungs[r] = static_cast<std::int32_t>(low + (width * share + kRungs - 1) / kRungs);
  }
  return rungs;
}

std::uint32_t times(std::uint32_t count, std::uint32_t factor) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
  return static_cast<std::uint32_t>(std::min(kMost, std::uint64_t{count} * factor));
}

}  // namespace

LeafSearch::LeafSearch(const PointTree& tree, const NeighbourRule& rule)
    : tree_(&tree), rule_(rule) {}

void LeafSearch::open(std::uint32_t leaf, std::uint32_t factor) {
  if (factor_ == 1 && farthest_sq_ > 0.0f) hint_m_ = std::sqrt(farthest_sq_);
  // On a sheet the number of points grows with the square of the distance.
  const auto growth = static_cast<float>(factor) / static_cast<float>(factor_);
  latest_sq_ *= growth;
  farthest_sq_ = 0.0f;
  leaf_ = leaf;
  factor_ = factor;
  least_ = times(rule_.least, factor);
  most_ = times(rule_.most, factor);
  const TreeNode& node = tree_->nodes()[leaf];
  // The reach decides the work, never the result.
  const float guess = hint_m_ > 0.0f ? 1.1f * hint_m_ : 1.2f * guessed_reach(node, rule_.least);
  gather(std::max({guess * std::sqrt(static_cast<float>(factor)), rule_.radius_m, 1e-3f}));
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
  std::uint32_t place = 0;
  for (std::uint32_t at = 0; at < nodes.size();) {
    const TreeNode& node = nodes[at];
    if (!meets(node.min, node.max, region_min_, region_max_)) {
      at = node.skip;
      continue;
    }
    if (node.skip == at + 1) {
      near_leaves_.push_back({node.min, node.max, node.begin, node.end, place});
      place += node.end - node.begin;
    }
    ++at;
  }
  if (near_x_.size() < place + kWordBits) {
    for (auto* array : {&near_x_, &near_y_, &near_z_}) array->resize(2 * place + kWordBits);
  }
  for (const NearLeaf& near : near_leaves_) {
    for (std::uint32_t i = near.begin; i < near.end; ++i) {
      const Vec3f p = tree_->positions()[i];
      const std::uint32_t to = near.place + (i - near.begin);
      near_x_[to] = p.x, near_y_[to] = p.y, near_z_[to] = p.z;
    }
  }
}

/// Adds those points of a leaf that are marked.
void LeafSearch::add_candidates(const NearLeaf& near, std::uint32_t marks) {
  std::size_t n = candidates_;
  for (; marks != 0; marks &= marks - 1) {
    const auto b = static_cast<std::uint32_t>(std::countr_zero(marks));
    const std::uint32_t from = near.place + b;
    x_[n] = near_x_[from], y_[n] = near_y_[from], z_[n] = near_z_[from];
    index_[n++] = near.begin + b;
  }
  candidates_ = n;
}

void LeafSearch::gather(float reach_m) {
  reach_m_ = reach_m;
  const TreeNode& leaf = tree_->nodes()[leaf_];
  const Vec3f low = leaf.min - Vec3f{reach_m, reach_m, reach_m};
  const Vec3f high = leaf.max + Vec3f{reach_m, reach_m, reach_m};
  if (near_leaves_.empty() || !encloses(region_min_, region_max_, low, high)) {
    collect_near_leaves(reach_m);
  }
  candidates_ = 0;
  for (const NearLeaf& near : near_leaves_) {
    if (!meets(near.min, near.max, low, high)) continue;
    const std::size_t needed = candidates_ + 2 * kWordBits;
    if (x_.size() < needed) {
      for (auto* array : {&x_, &y_, &z_}) array->resize(2 * needed);
      for (auto* array : {&dist_sq_, &chosen_sq_}) array->resize(2 * needed);
      for (auto* array : {&index_, &chosen_, &marks_}) array->resize(2 * needed);
    }
    const std::uint32_t filled = ~std::uint32_t{0} >> (kWordBits - (near.end - near.begin));
    const std::uint32_t marks =
        mark_inside(near_x_.data() + near.place, near_y_.data() + near.place,
                    near_z_.data() + near.place, low, high);
    add_candidates(near, marks & filled);
  }
  whole_tree_ = candidates_ == tree_->positions().size();
  for (std::size_t n = candidates_; n % kWordBits != 0; ++n) x_[n] = y_[n] = z_[n] = kFarAway;
}

/// Measures the candidates, gathers more where fewer than wanted lie within reach, and looks around
/// the farthest neighbour of the point before.
LeafSearch::Bracket LeafSearch::first_bracket(Vec3f p, std::uint32_t wanted) {
  for (;; gather(1.5f * reach_m_)) {
    measure(x_.data(), y_.data(), z_.data(), candidates_, p, dist_sq_.data());
    // The box of candidates holds the ball of radius reach_m_ around p, but perhaps no larger one.
    const float reach_sq = whole_tree_ ? kBeyond_sq : reach_m_ * reach_m_;
    Rungs rungs;
    for (std::size_t r = 0; r < kLadder.size(); ++r) {
      rungs[r] = bits_of(std::min(kLadder[r] * latest_sq_, reach_sq));
    }
    rungs.back() = bits_of(reach_sq);
    const Rungs counts = count_within(dist_sq_.data(), candidates_, rungs);
    const auto count = [&](std::size_t r) { return static_cast<std::uint32_t>(counts[r]); };
    if (count(kRungs - 1) < wanted && !whole_tree_) continue;
    std::size_t r = 0;
    while (r + 1 < kRungs && count(r) < wanted) ++r;
    return {r > 0 ? rungs[r - 1] : -1, rungs[r], count(r)};
  }
}

std::uint32_t LeafSearch::count_in_radius() const {
  Rungs rungs;
  rungs.fill(bits_of(rule_.radius_m * rule_.radius_m));
  return static_cast<std::uint32_t>(count_within(dist_sq_.data(), candidates_, rungs).front());
}

/// Copies the places and squared distances of candidates within `limit` to the front of chosen_ and
/// chosen_sq_.
std::uint32_t LeafSearch::choose_within(std::int32_t limit) {
  const std::size_t words = (candidates_ + kWordBits - 1) / kWordBits;
  mark_within(dist_sq_.data(), words, limit, marks_.data());
  std::uint32_t n = 0;
  for (std::size_t w = 0; w < words; ++w) {
    for (std::uint32_t marks = marks_[w]; marks != 0; marks &= marks - 1) {
      const auto j = static_cast<std::uint32_t>(w * kWordBits) +
                     static_cast<std::uint32_t>(std::countr_zero(marks));
      chosen_[n] = j;
      chosen_sq_[n++] = dist_sq_[j];
    }
  }
  return n;
}

namespace {

/// Tightens a bracket over `values` by counting at eight limits inside it.
template <class Bracket>
void tighten(const std::int32_t* values, std::size_t n, std::uint32_t wanted, Bracket& bracket) {
  const Rungs rungs = rungs_between(bracket.low, bracket.high);
  const Rungs counts = count_within(values, n, rungs);
  for (std::size_t r = 0; r < kRungs; ++r) {
    const auto count = static_cast<std::uint32_t>(counts[r]);
    if (count >= wanted) {
      bracket.high = rungs[r];
      bracket.high_count = count;
      return;
    }
    bracket.low = rungs[r];
  }
}

}  // namespace

/// Drops all but the `wanted` nearest of the bracket.high_count chosen, which stay in order.
void LeafSearch::drop_excess(Bracket bracket, std::uint32_t wanted) {
  const std::uint32_t n = bracket.high_count;
  while (bracket.high_count > wanted && bracket.is_open()) {
    tighten(chosen_sq_.data(), n, wanted, bracket);
  }
  // Where more than are wanted are left, they tie at the limit: the lower indices are nearer.
  std::uint32_t excess = bracket.high_count - wanted;
  for (std::uint32_t c = n; c-- > 0 && excess > 0;) {
    if (chosen_sq_[c] != bracket.high) continue;
    chosen_sq_[c] = std::numeric_limits<std::int32_t>::max();
    --excess;
  }
  std::uint32_t kept = 0;
  for (std::uint32_t c = 0; c < n; ++c) {
    chosen_[kept] = chosen_[c];
    kept += chosen_sq_[c] <= bracket.high ? 1 : 0;
  }
}

/// Leaves in chosen_ the places of the `wanted` nearest candidates, in ascending order.
void LeafSearch::choose(Bracket bracket, std::uint32_t wanted) {
  while (bracket.high_count > wanted + kFew && bracket.is_open()) {
    tighten(dist_sq_.data(), candidates_, wanted, bracket);
  }
  choose_within(bracket.high);
  if (bracket.high_count > wanted) drop_excess(bracket, wanted);
}

/// Leaves in chosen_ the places of p's neighbours; returns how many there are.
std::uint32_t LeafSearch::choose_neighbours(Vec3f p) {
  Bracket bracket = first_bracket(p, least_);
  std::uint32_t wanted = least_;
  if (most_ > least_) {
    const std::uint32_t in_radius = count_in_radius();
    wanted = std::clamp(in_radius, least_, most_);
    if (wanted > bracket.high_count) {
      bracket = {-1, bits_of(rule_.radius_m * rule_.radius_m), in_radius};
    }
  }
  wanted = std::min(wanted, static_cast<std::uint32_t>(candidates_));
  choose(bracket, wanted);
  return wanted;
}

void LeafSearch::learn(float reach_sq) {
  latest_sq_ = reach_sq;
  farthest_sq_ = std::max(farthest_sq_, reach_sq);
}

Neighbourhood LeafSearch::find(std::uint32_t i) {
  const Vec3f p = tree_->positions()[i];
  const std::uint32_t n = choose_neighbours(p);
  if (dx_.size() < n) {
    for (auto* array : {&dx_, &dy_, &dz_}) array->resize(2 * n);
  }
  std::int32_t farthest = 0;
  for (std::uint32_t c = 0; c < n; ++c) {
    const std::uint32_t j = chosen_[c];
    dx_[c] = x_[j] - p.x, dy_[c] = y_[j] - p.y, dz_[c] = z_[j] - p.z;
    farthest = std::max(farthest, dist_sq_[j]);
    chosen_[c] = index_[j];
  }
  const auto reach_sq = std::bit_cast<float>(farthest);
  learn(reach_sq);
  return {n, chosen_.data(), dx_.data(), dy_.data(), dz_.data(), reach_sq};
}

void LeafSearch::find(std::uint32_t i, NeighbourBlock& block) {
  const Vec3f p = tree_->positions()[i];
  const std::uint32_t n = choose_neighbours(p);
  block.open_lane(i, n);
  std::int32_t farthest = 0;
  for (std::uint32_t c = 0; c < n; ++c) {
    const std::uint32_t j = chosen_[c];
    block.set(block.place() + c * kLanes, index_[j], x_[j] - p.x, y_[j] - p.y, z_[j] - p.z);
    farthest = std::max(farthest, dist_sq_[j]);
  }
  learn(std::bit_cast<float>(farthest));
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
