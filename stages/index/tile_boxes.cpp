// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/index/tile_boxes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "stages/index/box_finder.h"

namespace cornice::index {
namespace {

// How far points may lie beyond their tile's border: rounding of coordinates, not more.
constexpr double kRounding = 0.011;

double nearest_multiple(double value, double step) { return std::round(value / step) * step; }

/// The smallest box on multiples of `step` that holds all but the rounding of `bounds`.
Box2d outward(const Box2d& bounds, double step) {
  Box2d box{std::floor((bounds.min_x + kRounding) / step) * step,
            std::floor((bounds.min_y + kRounding) / step) * step,
            std::ceil((bounds.max_x - kRounding) / step) * step,
            std::ceil((bounds.max_y - kRounding) / step) * step};
  // A tile of one point, or of one line of points along an edge.
  if (box.max_x <= box.min_x) box.max_x = box.min_x + step;
  if (box.max_y <= box.min_y) box.max_y = box.min_y + step;
  return box;
}

/// The cells of the finest usual grid in which every footprint lies in a cell of its own and fills
/// at least half of it both ways, or nothing. Tiles cut from one grid are recognised by this though
/// water or the survey's edge keeps their points from their borders.
std::optional<std::vector<Box2d>> cells_of_a_grid(const std::vector<Footprint>& footprints,
                                                  double step) {
  for (const double side : {20.0, 25.0, 50.0, 100.0, 125.0, 200.0, 250.0, 500.0, 1000.0, 2000.0}) {
    if (std::abs(nearest_multiple(side, step) - side) > 1e-9) continue;
    std::map<std::pair<std::int64_t, std::int64_t>, std::size_t> taken;
    std::vector<Box2d> cells;
    for (const Footprint& footprint : footprints) {
      const Box2d& b = footprint.bounds;
      const double x = std::floor((b.min_x + kRounding) / side);
      const double y = std::floor((b.min_y + kRounding) / side);
      const Box2d cell{x * side, y * side, (x + 1.0) * side, (y + 1.0) * side};
      const bool fits = b.max_x <= cell.max_x + kRounding && b.max_y <= cell.max_y + kRounding;
      const bool fills = b.width() >= 0.5 * side && b.height() >= 0.5 * side;
      const auto key = std::pair(static_cast<std::int64_t>(x), static_cast<std::int64_t>(y));
      if (!fits || !fills || !taken.emplace(key, cells.size()).second) break;
      cells.push_back(cell);
    }
    if (cells.size() == footprints.size()) return cells;
  }
  return std::nullopt;
}

// Edges are numbered 4 * tile + side.
enum Side : std::size_t { kWest, kEast, kSouth, kNorth };

double& edge_of(std::vector<Box2d>& boxes, std::size_t edge) {
  Box2d& box = boxes[edge / 4];
  switch (edge % 4) {
    case kWest:
      return box.min_x;
    case kEast:
      return box.max_x;
    case kSouth:
      return box.min_y;
    default:
      return box.max_y;
  }
}

/// Edges that are to have one coordinate (union-find).
class SharedEdges {
 public:
  explicit SharedEdges(std::size_t tiles) : parent_(4 * tiles), faces_(4 * tiles, false) {
    for (std::size_t i = 0; i < parent_.size(); ++i) parent_[i] = i;
  }
  void join(std::size_t a, std::size_t b) {
    const std::size_t ra = root(a), rb = root(b);
    parent_[std::max(ra, rb)] = std::min(ra, rb);
  }
  /// Two edges that look at each other.
  void face(std::size_t a, std::size_t b) {
    faces_[a] = faces_[b] = true;
    join(a, b);
  }
  bool faces(std::size_t edge) const { return faces_[edge]; }
  std::size_t root(std::size_t edge) {
    while (parent_[edge] != edge) edge = parent_[edge] = parent_[parent_[edge]];
    return edge;
  }

 private:
  std::vector<std::size_t> parent_;
  std::vector<bool> faces_;
};

/// How two boxes lie to each other: the facing edges, where they have a border in common.
struct Border {
  std::size_t first = 0, second = 0;  ///< edges
};

std::optional<Border> border_between(const std::vector<Box2d>& boxes, std::size_t i, std::size_t j,
                                     double seam_m) {
  const Box2d &a = boxes[i], &b = boxes[j];
  // Positive: overlap; negative: gap.
  const double along_x = std::min(a.max_x, b.max_x) - std::max(a.min_x, b.min_x);
  const double along_y = std::min(a.max_y, b.max_y) - std::max(a.min_y, b.min_y);
  if (along_x < -seam_m || along_y < -seam_m) return std::nullopt;
  // Tiles that touch at a corner, give or take a seam, have no border in common.
  if (along_x <= seam_m && along_y <= seam_m) return std::nullopt;
  if (along_x <= along_y) {
    const bool in_order = a.min_x + a.max_x <= b.min_x + b.max_x;
    return in_order ? Border{4 * i + kEast, 4 * j + kWest} : Border{4 * j + kEast, 4 * i + kWest};
  }
  const bool in_order = a.min_y + a.max_y <= b.min_y + b.max_y;
  return in_order ? Border{4 * i + kNorth, 4 * j + kSouth} : Border{4 * j + kNorth, 4 * i + kSouth};
}

/// Gives the edges that face each other one coordinate; so do the edges that go on from one tile to
/// the next, so that four tiles have one corner.
void close_seams(std::vector<Box2d>& boxes, const std::vector<std::size_t>& order, double step,
                 double seam_m) {
  SharedEdges shared(boxes.size());
  std::vector<Border> borders;
  std::vector<Box2d> in_order;
  for (const std::size_t i : order) in_order.push_back(boxes[i]);
  const BoxFinder finder(in_order);
  for (std::size_t m = 0; m < order.size(); ++m) {
    for (const std::size_t n : finder.touching(in_order[m].grown(seam_m))) {
      if (n <= m) continue;
      const auto border = border_between(boxes, order[m], order[n], seam_m);
      if (!border) continue;
      borders.push_back(*border);
      shared.face(border->first, border->second);
    }
  }
  std::vector<Box2d> settled = boxes;
  for (const Border& border : borders) {
    const std::size_t a = 4 * (border.first / 4), b = 4 * (border.second / 4);
    const bool beside = border.first % 4 == kEast;
    for (const Side side : beside ? std::array{kSouth, kNorth} : std::array{kWest, kEast}) {
      const double apart = std::abs(edge_of(boxes, a + side) - edge_of(boxes, b + side));
      if (shared.faces(a + side) && shared.faces(b + side) && apart <= seam_m)
        shared.join(a + side, b + side);
    }
  }
  std::map<std::size_t, std::pair<double, double>> sums;  // by root: sum of coordinates, edges
  for (std::size_t edge = 0; edge < 4 * boxes.size(); ++edge) {
    if (!shared.faces(edge)) continue;
    auto& [sum, count] = sums[shared.root(edge)];
    sum += edge_of(boxes, edge);
    count += 1.0;
  }
  for (std::size_t edge = 0; edge < 4 * boxes.size(); ++edge) {
    if (!shared.faces(edge)) continue;
    const auto& [sum, count] = sums[shared.root(edge)];
    edge_of(settled, edge) = nearest_multiple(sum / count, step);
  }
  boxes = std::move(settled);
}

/// Whether all of `inner` lies in `outer`, such as a few points in the overlap with a neighbour.
bool holds_all(const Box2d& outer, const Box2d& inner) {
  return inner.min_x >= outer.min_x && inner.max_x <= outer.max_x && inner.min_y >= outer.min_y &&
         inner.max_y <= outer.max_y;
}

bool holds_middle(const Box2d& outer, const Box2d& inner) {
  return outer.contains(0.5 * (inner.min_x + inner.max_x), 0.5 * (inner.min_y + inner.max_y));
}

}  // namespace

TileBoxes lay_out(const std::vector<Footprint>& footprints, double step_m, double seam_m) {
  TileBoxes result;
  result.inside.assign(footprints.size(), kNobody);
  std::vector<Footprint> unnamed;
  for (const Footprint& footprint : footprints)
    if (!footprint.nominal) unnamed.push_back(footprint);
  const auto cells = cells_of_a_grid(unnamed, step_m);
  std::size_t next = 0;
  for (const Footprint& footprint : footprints) {
    if (footprint.nominal) {
      const Box2d& n = *footprint.nominal;
      result.boxes.push_back({nearest_multiple(n.min_x, step_m), nearest_multiple(n.min_y, step_m),
                              nearest_multiple(n.max_x, step_m),
                              nearest_multiple(n.max_y, step_m)});
    } else {
      result.boxes.push_back(cells ? (*cells)[next] : outward(footprint.bounds, step_m));
      ++next;
    }
  }
  // West to east, then south to north, so that the order of the files does not matter.
  std::vector<std::size_t> order(footprints.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const std::vector<Box2d> first = result.boxes;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return std::pair(first[i].min_x, first[i].min_y) < std::pair(first[j].min_x, first[j].min_y);
  });
  const BoxFinder finder(first);
  for (std::size_t i = 0; i < order.size(); ++i)
    for (const std::size_t j : finder.touching(first[i]))
      if (j < i && result.inside[j] == kNobody && holds_middle(first[j], first[i]) &&
          holds_middle(first[i], first[j]))
        result.inside[i] = j;
  // A border between a tile and what lies in it would cut the tile through its whole length.
  for (std::size_t i = 0; i < order.size(); ++i)
    for (const std::size_t j : finder.touching(first[i]))
      if (i != j && result.inside[i] == kNobody && result.inside[j] == kNobody &&
          holds_all(first[j], first[i]))
        result.inside[i] = j;
  std::erase_if(order, [&](std::size_t i) { return result.inside[i] != kNobody; });
  close_seams(result.boxes, order, step_m, seam_m);
  return result;
}

}  // namespace cornice::index
