// SPDX-License-Identifier: GPL-3.0-or-later
// Li 2024, "Multi-scale simplification and visualization of large 3D models" (thesis, Sorbonne
// Université), 5.1.2, step (7), with support ranked over all points and with agreement across the
// chord instead of the product of two normals.
#include "stages/normals/propagate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/parallel.h"

namespace cornice::normals {
namespace {

constexpr std::size_t kGrain = 4096;

/// Support from neighbours counts as much as this much mean |n . b|.
constexpr float kNeighbourWeight = 0.5f;

/// Levels of support, highest first; a point waits until no point anywhere reaches a higher one.
/// Points far apart do not meet, so the outcome at a place does not depend on what lies elsewhere.
constexpr std::array<float, 5> kLevels{0.5f, 0.3f, 0.15f, 0.05f, 0.0f};

/// Lists of different lengths, one after the other.
struct Rows {
  std::vector<std::size_t> first;  ///< rows + 1
  std::vector<std::uint32_t> items;
  std::span<const std::uint32_t> operator[](std::size_t row) const {
    return std::span(items).subspan(first[row], first[row + 1] - first[row]);
  }
};

/// The points to settle.
struct Pending {
  std::vector<std::uint32_t> points;
  std::vector<std::uint32_t> place;  ///< by point: its place among `points`
  Rows neighbours;                   ///< by place: points, itself included
  Rows watchers;                     ///< by place: places of those that have it as a neighbour
};

bool is_open(SettledBy by) { return by == SettledBy::kNothing; }

void collect_neighbours(const PointTree& tree, const OrientOptions& options,
                        const std::vector<SettledBy>& settled_by, Pending& pending) {
  const auto search = [&](const auto& body) {
    for_each_neighbourhood(
        tree, options.neighbours, options.threads,
        [&](std::uint32_t i) { return is_open(settled_by[i]); },
        [&](std::uint32_t i, const Neighbourhood& found) { body(pending.place[i], found); });
  };
  auto& [first, items] = pending.neighbours;
  first.assign(pending.points.size() + 1, 0);
  if (options.neighbours.least == options.neighbours.most) {
    const std::size_t size = std::min<std::size_t>(options.neighbours.least, settled_by.size());
    std::fill(first.begin() + 1, first.end(), size);
  } else {
    search([&](std::uint32_t p, const Neighbourhood& found) { first[p + 1] = found.size; });
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  items.resize(first.back());
  search([&](std::uint32_t p, const Neighbourhood& found) {
    std::copy_n(found.index, found.size, items.begin() + static_cast<std::ptrdiff_t>(first[p]));
  });
}

void collect_watchers(const std::vector<SettledBy>& settled_by, Pending& pending) {
  auto& [first, items] = pending.watchers;
  first.assign(pending.points.size() + 2, 0);
  const auto for_each_pair = [&](const auto& body) {
    for (std::uint32_t p = 0; p < pending.points.size(); ++p) {
      for (const std::uint32_t j : pending.neighbours[p]) {
        if (is_open(settled_by[j]) && j != pending.points[p]) body(pending.place[j], p);
      }
    }
  };
  for_each_pair([&](std::uint32_t watched, std::uint32_t) { ++first[watched + 2]; });
  std::partial_sum(first.begin(), first.end(), first.begin());
  items.resize(first.back());
  for_each_pair([&](std::uint32_t watched, std::uint32_t p) { items[first[watched + 1]++] = p; });
  first.pop_back();
}

Pending collect(const PointTree& tree, const OrientOptions& options,
                const std::vector<SettledBy>& settled_by) {
  Pending pending;
  pending.place.resize(settled_by.size());
  for (std::uint32_t i = 0; i < settled_by.size(); ++i) {
    if (!is_open(settled_by[i])) continue;
    pending.place[i] = static_cast<std::uint32_t>(pending.points.size());
    pending.points.push_back(i);
  }
  if (pending.points.empty()) return pending;
  collect_neighbours(tree, options, settled_by, pending);
  collect_watchers(settled_by, pending);
  return pending;
}

/// Support for the side a point is turned to; negative for the other side.
float support(std::span<const Vec3f> positions, const Pending& pending, std::size_t p,
              std::span<const float> evidence, const OrientedNormals& normals) {
  const std::uint32_t i = pending.points[p];
  float sum = 0.0f, weights = 0.0f;
  for (const std::uint32_t j : pending.neighbours[p]) {
    if (j == i || normals.settled_by[j] == SettledBy::kNoPlane) continue;
    weights += normals.quality[j];
    if (normals.settled_by[j] == SettledBy::kNothing) continue;
    sum += normals.quality[j] *
           agreement(normals.normals[i], normals.normals[j], positions[j] - positions[i]);
  }
  const float from_neighbours = weights > 0.0f ? sum / weights : 0.0f;
  return evidence[i] + kNeighbourWeight * from_neighbours;
}

}  // namespace

float agreement(Vec3f n_a, Vec3f n_b, Vec3f d) {
  const float length_sq = dot(d, d);
  if (length_sq == 0.0f) return dot(n_a, n_b);
  return dot(n_a, n_b) - 2.0f * dot(n_a, d) * dot(n_b, d) / length_sq;
}

int propagate(const PointTree& tree, std::span<const float> evidence, const OrientOptions& options,
              OrientedNormals& normals) {
  const Pending pending = collect(tree, options, normals.settled_by);
  std::vector<float> supports(pending.points.size());
  std::array<std::vector<std::uint32_t>, kLevels.size()> queues;
  const auto level_of = [&](float value) {
    std::size_t level = 0;
    while (level < kLevels.size() && std::abs(value) < kLevels[level]) ++level;
    return std::abs(value) < options.least_support ? kLevels.size() : level;
  };
  std::vector<std::uint32_t> changed(pending.points.size());
  std::iota(changed.begin(), changed.end(), 0u);
  std::vector<int> round_of_change(pending.points.size(), -1);
  for (int round = 0;; ++round) {
    parallel_for(changed.size(), kGrain, options.threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t c = begin; c < end; ++c) {
        supports[changed[c]] = support(tree.positions(), pending, changed[c], evidence, normals);
      }
    });
    for (const std::uint32_t p : changed) {
      const std::size_t level = level_of(supports[p]);
      if (level < queues.size()) queues[level].push_back(p);
    }
    std::vector<std::uint32_t> settled;
    for (std::size_t level = 0; level < queues.size() && settled.empty(); ++level) {
      for (const std::uint32_t p : queues[level]) {
        SettledBy& by = normals.settled_by[pending.points[p]];
        // Entries are left behind where support has changed since.
        if (by != SettledBy::kNothing || level_of(supports[p]) != level) continue;
        by = SettledBy::kPropagation;
        settled.push_back(p);
      }
      queues[level].clear();
    }
    if (settled.empty()) return round;
    changed.clear();
    for (const std::uint32_t p : settled) {
      Vec3f& normal = normals.normals[pending.points[p]];
      if (supports[p] < 0.0f) normal = -normal;
      for (const std::uint32_t watcher : pending.watchers[p]) {
        if (!is_open(normals.settled_by[pending.points[watcher]])) continue;
        if (std::exchange(round_of_change[watcher], round) != round) changed.push_back(watcher);
      }
    }
  }
}

}  // namespace cornice::normals
