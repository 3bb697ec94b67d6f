// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/compare/overhangs.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace cornice::compare {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;
constexpr double kRadians = std::numbers::pi / 180.0;
/// Vertices of two parts are one where they round to the same place on this grid.
constexpr double kBorderGridM = 0.002;

/// Clockwise from north, in equal steps.
template <std::size_t count>
std::array<Vec3d, count> make_directions() {
  std::array<Vec3d, count> directions;
  for (std::size_t k = 0; k < count; ++k) {
    const double angle =
        2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(count);
    directions[k] = {std::sin(angle), std::cos(angle), 0.0};
  }
  return directions;
}

std::uint32_t find(std::vector<std::uint32_t>& parents, std::uint32_t v) {
  while (parents[v] != v) v = parents[v] = parents[parents[v]];
  return v;
}

}  // namespace

std::uint32_t OverhangFinder::root(std::uint32_t piece) const {
  while (pieces_[piece].parent != piece) {
    piece = pieces_[piece].parent = pieces_[pieces_[piece].parent].parent;
  }
  return piece;
}

void OverhangFinder::unite(std::uint32_t a, std::uint32_t b) {
  a = root(a), b = root(b);
  if (a == b) return;
  if (b < a) std::swap(a, b);
  Piece &to = pieces_[a], &from = pieces_[b];
  from.parent = a;
  to.area += from.area, to.plan += from.plan;
  to.moment += from.moment, to.normal_sum += from.normal_sum;
  to.lowest_nz = std::min(to.lowest_nz, from.lowest_nz);
  to.box.add(from.box.min), to.box.add(from.box.max);
  for (std::size_t k = 0; k < kDirections; ++k) to.reach[k] = std::max(to.reach[k], from.reach[k]);
}

void OverhangFinder::measure(const Surface& surface, const Triangle& triangle, Piece& piece) const {
  static const std::array<Vec3d, kDirections> directions = make_directions<kDirections>();
  Vec3d p[3];
  for (std::size_t k = 0; k < 3; ++k) {
    p[k] = surface.origin + surface.positions[triangle[k]].cast<double>();
    piece.box.add(p[k]);
    for (std::size_t d = 0; d < kDirections; ++d) {
      piece.reach[d] = std::max(piece.reach[d], dot(p[k], directions[d]));
    }
  }
  const Vec3d twice = cross(p[1] - p[0], p[2] - p[0]);
  const double area = 0.5 * norm(twice);
  piece.area += area;
  piece.plan += 0.5 * std::abs(twice.z);
  piece.moment += (p[0] + p[1] + p[2]) * (area / 3.0);
  piece.normal_sum += twice * 0.5;
  if (area > 0.0) piece.lowest_nz = std::min(piece.lowest_nz, 0.5 * twice.z / area);
}

void OverhangFinder::link_border(const Surface& surface,
                                 const std::vector<std::uint32_t>& piece_of_vertex) {
  const std::vector<std::uint32_t> twins =
      match_half_edges(surface.triangles, surface.positions.size(), 1);
  for (std::uint32_t h = 0; h < twins.size(); ++h) {
    if (twins[h] != kOpenEdge) continue;
    for (const std::uint32_t corner : {h % 3, (h + 1) % 3}) {
      const std::uint32_t v = surface.triangles[h / 3][corner];
      if (piece_of_vertex[v] == kNone) continue;
      const Vec3d p = (surface.origin + surface.positions[v].cast<double>()) / kBorderGridM;
      border_.push_back(
          {{std::llround(p.x), std::llround(p.y), std::llround(p.z)}, piece_of_vertex[v]});
    }
  }
}

void OverhangFinder::add(std::size_t part, const Surface& surface) {
  if (marks_.size() <= part) marks_.resize(part + 1);
  const auto limit = static_cast<float>(-std::sin(below_deg_ * kRadians));
  std::vector<std::uint32_t> parents(surface.positions.size());
  std::iota(parents.begin(), parents.end(), 0u);
  std::vector<std::uint32_t> facing_down;
  for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
    const Triangle& c = surface.triangles[t];
    const Vec3f a = surface.positions[c[0]];
    const Vec3f turned = cross(surface.positions[c[1]] - a, surface.positions[c[2]] - a);
    if (!(turned.z < limit * norm(turned))) continue;
    facing_down.push_back(t);
    const std::uint32_t first = find(parents, c[0]);
    parents[find(parents, c[1])] = first;
    parents[find(parents, c[2])] = first;
  }
  if (facing_down.empty()) return;
  std::vector<std::uint32_t> piece_of_vertex(surface.positions.size(), kNone);
  for (const std::uint32_t t : facing_down) {
    std::uint32_t& piece = piece_of_vertex[find(parents, surface.triangles[t][0])];
    if (piece == kNone) {
      piece = static_cast<std::uint32_t>(pieces_.size());
      Piece fresh;
      fresh.parent = piece;
      fresh.reach.fill(-1e300);
      pieces_.push_back(fresh);
    }
    measure(surface, surface.triangles[t], pieces_[piece]);
    marks_[part].push_back({t, piece});
  }
  for (const std::uint32_t t : facing_down) {
    for (const std::uint32_t v : surface.triangles[t]) {
      piece_of_vertex[v] = piece_of_vertex[find(parents, v)];
    }
  }
  link_border(surface, piece_of_vertex);
}

Overhang OverhangFinder::overhang_of(const Piece& piece) {
  Overhang o;
  o.area_m2 = piece.area;
  o.plan_m2 = piece.plan;
  o.centre = piece.moment / std::max(piece.area, 1e-12);
  o.box = piece.box;
  o.height_m = piece.box.max.z - piece.box.min.z;
  o.steepest_deg = std::asin(std::clamp(-piece.lowest_nz, 0.0, 1.0)) / kRadians;
  o.azimuth_deg = std::atan2(piece.normal_sum.x, piece.normal_sum.y) / kRadians;
  if (o.azimuth_deg < 0.0) o.azimuth_deg += 360.0;
  const auto along = static_cast<std::size_t>(
                         std::llround(o.azimuth_deg / 360.0 * static_cast<double>(kDirections))) %
                     kDirections;
  const auto extent = [&](std::size_t k) {
    return piece.reach[k % kDirections] + piece.reach[(k + kDirections / 2) % kDirections];
  };
  o.depth_m = extent(along);
  o.length_m = extent(along + kDirections / 4);
  return o;
}

std::vector<Overhang> OverhangFinder::finish(double min_area_m2) {
  std::sort(border_.begin(), border_.end());
  for (std::size_t i = 1; i < border_.size(); ++i) {
    if (border_[i].first == border_[i - 1].first) unite(border_[i].second, border_[i - 1].second);
  }
  kept_.assign(pieces_.size(), 0);
  std::vector<Overhang> overhangs;
  for (std::uint32_t p = 0; p < pieces_.size(); ++p) {
    kept_[p] = pieces_[root(p)].area >= min_area_m2 ? 1 : 0;
    if (kept_[p] != 0 && root(p) == p) overhangs.push_back(overhang_of(pieces_[p]));
  }
  std::stable_sort(overhangs.begin(), overhangs.end(),
                   [](const Overhang& a, const Overhang& b) { return a.area_m2 > b.area_m2; });
  return overhangs;
}

std::vector<std::uint8_t> OverhangFinder::triangles_of(std::size_t part,
                                                       std::size_t triangle_count) const {
  std::vector<std::uint8_t> bytes;
  if (part >= marks_.size() || marks_[part].empty()) return bytes;
  bytes.assign(triangle_count, 0);
  for (const Mark& mark : marks_[part]) bytes[mark.triangle] = kept_[mark.piece];
  return bytes;
}

}  // namespace cornice::compare
