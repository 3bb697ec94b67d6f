// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/edge_grid.h"

#include <algorithm>
#include <cmath>

namespace cornice::stitch {
namespace {

/// Borders nearer than this share of their edges are one. The two sides of a hole that ends at an
/// inner border part at an angle of some 40 degrees, which makes it 0.64; vertices shifted by a
/// tenth of an edge make it 0.2.
constexpr double kReachOfLength = 0.4;
constexpr std::int64_t kMostCells = (std::int64_t{1} << 21) - 2;
/// A vertex that is this much farther from an edge than from its end in the edge's direction lies
/// beside the end, as the vertices of a border that leaves a corner of tiles at right angles do.
constexpr double kBesideEnd = 2.0;

}  // namespace

LooseBorders::LooseBorders(const Borders& borders, const Matches& matches, double tolerance_m)
    : tolerance_m_(tolerance_m),
      edges_(borders.edges()),
      positions_(borders.positions()),
      vertex_tiles_(borders.vertex_tiles()),
      in_(positions_.size(), kNone),
      out_(positions_.size(), kNone) {
  for (std::uint32_t e = 0; e < edges_.size(); ++e) {
    if (matches.partner[e] != kNone) continue;
    loose_.push_back(e);
    if (out_[edges_[e].from] == kNone) out_[edges_[e].from] = e;
    if (in_[edges_[e].to] == kNone) in_[edges_[e].to] = e;
  }
  for (std::uint32_t v = 0; v < positions_.size(); ++v) {
    if (is_loose(v)) vertices_.push_back(v);
  }
  fill_grid();
}

void LooseBorders::fill_grid() {
  Box3d box;
  double lengths = 0.0;
  for (const std::uint32_t e : loose_) {
    box.add(positions_[edges_[e].from]);
    box.add(positions_[edges_[e].to]);
    lengths += length(e);
  }
  if (loose_.empty()) return;
  const Vec3d extent = box.max - box.min;
  cell_m_ = std::max({2.0 * tolerance_m_, lengths / static_cast<double>(loose_.size()),
                      std::max({extent.x, extent.y, extent.z}) / static_cast<double>(kMostCells)});
  corner_ = box.min - Vec3d{cell_m_, cell_m_, cell_m_};
  for (const std::uint32_t e : loose_) {
    // Steps of half a cell: no point of the edge is farther than a quarter from one of them.
    const auto steps = static_cast<std::uint32_t>(std::ceil(2.0 * length(e) / cell_m_)) + 1;
    for (std::uint32_t s = 0; s <= steps; ++s) {
      const Vec3d p =
          (positions_[edges_[e].from] + along(e) * (static_cast<double>(s) / steps) - corner_) /
          cell_m_;
      cells_.emplace_back(cell_of(static_cast<std::int64_t>(p.x), static_cast<std::int64_t>(p.y),
                                  static_cast<std::int64_t>(p.z)),
                          e);
    }
  }
  std::sort(cells_.begin(), cells_.end());
  cells_.erase(std::unique(cells_.begin(), cells_.end()), cells_.end());
}

std::uint64_t LooseBorders::cell_of(std::int64_t x, std::int64_t y, std::int64_t z) const {
  return static_cast<std::uint64_t>(x) << 42 | static_cast<std::uint64_t>(y) << 21 |
         static_cast<std::uint64_t>(z);
}

double LooseBorders::length_at(std::uint32_t v) const {
  return std::max(in_[v] == kNone ? 0.0 : length(in_[v]), out_[v] == kNone ? 0.0 : length(out_[v]));
}

double LooseBorders::reach(double length_a, double length_b) const {
  return std::min(tolerance_m_, kReachOfLength * std::max(length_a, length_b));
}

Vec3d LooseBorders::normal_at(std::uint32_t v) const {
  Vec3d sum{};
  if (in_[v] != kNone) sum += edges_[in_[v]].normal.cast<double>();
  if (out_[v] != kNone) sum += edges_[out_[v]].normal.cast<double>();
  return sum;
}

bool LooseBorders::may_join(std::uint32_t v, std::uint32_t w) const {
  const double distance = norm(positions_[v] - positions_[w]);
  if (distance > reach(length_at(v), length_at(w))) return false;
  if (dot(normal_at(v), normal_at(w)) < 0.0) return false;
  const auto opposed = [&](std::uint32_t a, std::uint32_t b) {
    return a != kNone && b != kNone && dot(along(a), along(b)) < 0.0;
  };
  return opposed(in_[v], out_[w]) || opposed(out_[v], in_[w]);
}

std::vector<LooseBorders::Near> LooseBorders::edges_near(std::uint32_t v) const {
  return edges_near(positions_[v], in_[v] == kNone ? Vec3d{} : along(in_[v]),
                    out_[v] == kNone ? Vec3d{} : along(out_[v]), normal_at(v), length_at(v),
                    vertex_tiles_[v]);
}

std::vector<LooseBorders::Near> LooseBorders::edges_near(Vec3d p, Vec3d in, Vec3d out, Vec3d normal,
                                                         double length_m, std::uint32_t own) const {
  std::vector<std::uint32_t> candidates;
  const Vec3d at = (p - corner_) / cell_m_;
  const auto x = static_cast<std::int64_t>(std::floor(at.x));
  const auto y = static_cast<std::int64_t>(std::floor(at.y));
  const auto z = static_cast<std::int64_t>(std::floor(at.z));
  for (std::int64_t i = std::max<std::int64_t>(x - 1, 0); i <= x + 1; ++i) {
    for (std::int64_t j = std::max<std::int64_t>(y - 1, 0); j <= y + 1; ++j) {
      const std::uint64_t low = cell_of(i, j, std::max<std::int64_t>(z - 1, 0));
      const std::uint64_t high = cell_of(i, j, std::max<std::int64_t>(z + 1, 0));
      for (auto cell = std::lower_bound(cells_.begin(), cells_.end(), Cell{low, 0});
           cell != cells_.end() && cell->first <= high; ++cell) {
        candidates.push_back(cell->second);
      }
    }
  }
  std::sort(candidates.begin(), candidates.end());
  candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
  std::vector<Near> found;
  std::uint32_t last_tile = kNone;
  for (const std::uint32_t e : candidates) {  // by tile, as edges are numbered tile by tile
    const std::uint32_t tile = vertex_tiles_[edges_[e].from];
    if (tile == own) continue;
    const Vec3d a = positions_[edges_[e].from], ab = along(e);
    if (dot(ab, in) >= 0.0 && dot(ab, out) >= 0.0) continue;
    if (dot(normal, edges_[e].normal.cast<double>()) < 0.0) continue;
    const double t = dot(p - a, ab) / std::max(dot(ab, ab), 1e-30);
    if (!(t > 0.0 && t < 1.0)) continue;
    const double distance = norm(p - (a + ab * t));
    if (distance > reach(length_m, norm(ab))) continue;
    if (distance > kBesideEnd * std::min(t, 1.0 - t) * norm(ab)) continue;
    if (tile != last_tile) {
      found.push_back({e, t, distance});
      last_tile = tile;
    } else if (distance < found.back().distance_m) {
      found.back() = {e, t, distance};
    }
  }
  return found;
}

}  // namespace cornice::stitch
