// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/band.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <set>
#include <utility>

#include "core/base/error.h"

namespace cornice {
namespace {

/// Beyond its window a tile looks at this many nodes more: for welds and for normals.
constexpr std::int32_t kRim = 2;

using Column = std::pair<std::int32_t, std::int32_t>;

std::int32_t brick_of(std::int32_t node) { return node >> 3; }

/// Columns of level-0 bricks with a node within `reach` of the border of `box`.
std::set<Column> ring_columns(const LatticeBox& box, std::int32_t reach) {
  const LatticeBox outer = box.grown(reach), inner = box.grown(-reach);
  std::set<Column> columns;
  for (std::int32_t x = brick_of(outer.x0); x <= brick_of(outer.x1); ++x) {
    for (std::int32_t y = brick_of(outer.y0); y <= brick_of(outer.y1); ++y) {
      const bool within = kBrickSide * x > inner.x0 && kBrickSide * x + 7 < inner.x1 &&
                          kBrickSide * y > inner.y0 && kBrickSide * y + 7 < inner.y1;
      if (!within) columns.insert({x, y});
    }
  }
  return columns;
}

/// Columns of level `level` that closed_brick() may read for bricks of the given ones.
std::set<Column> columns_read(const std::set<Column>& finest, int level) {
  std::set<Column> columns;
  for (const auto& [x, y] : finest) {
    for (const int dx : {0, 1}) {
      for (const int dy : {0, 1}) columns.insert({(x >> level) + dx, (y >> level) + dy});
    }
  }
  return columns;
}

FieldLevel restrict_level(const FieldLevel& level, const std::set<Column>& columns) {
  FieldLevel kept;
  for (std::size_t b = 0; b < level.bricks.size(); ++b) {
    if (!columns.contains({level.bricks[b].x, level.bricks[b].y})) continue;
    kept.bricks.push_back(level.bricks[b]);
    const auto first = level.values.begin() + static_cast<std::ptrdiff_t>(b * kBrickNodes);
    kept.values.insert(kept.values.end(), first, first + kBrickNodes);
  }
  return kept;
}

std::string text(const LatticeBox& box, const Lattice& lattice) {
  const Box2d m = box_in_metres(box, lattice);
  return std::to_string(m.min_x) + "," + std::to_string(m.min_y) + "," + std::to_string(m.max_x) +
         "," + std::to_string(m.max_y);
}

void check_pair(const TileField& a, const TileField& b, const std::string& a_name,
                const std::string& b_name) {
  if (!(a.field.lattice() == b.field.lattice())) {
    throw InputError(b_name, "has the step " + std::to_string(b.field.lattice().step_m) +
                                 " m, but " + a_name + " " +
                                 std::to_string(a.field.lattice().step_m) +
                                 " m; solve all tiles with one step");
  }
  if (a.ramp != b.ramp) {
    throw InputError(b_name, "has a band of " + std::to_string(b.ramp) + " steps, but " + a_name +
                                 " of " + std::to_string(a.ramp) +
                                 "; solve all tiles with one band width");
  }
  if (a.crs_text != b.crs_text) {
    throw InputError(b_name, "is in " + (b.crs_text.empty() ? "no CRS" : b.crs_text) + ", but " +
                                 a_name + " in " + (a.crs_text.empty() ? "none" : a.crs_text));
  }
  const bool apart = a.tile.x1 <= b.tile.x0 || b.tile.x1 <= a.tile.x0 || a.tile.y1 <= b.tile.y0 ||
                     b.tile.y1 <= a.tile.y0;
  if (!apart) {
    throw InputError(b_name, "covers " + text(b.tile, b.field.lattice()) + " and overlaps " +
                                 a_name + ", " + text(a.tile, a.field.lattice()) +
                                 "; give each tile the square that it owns (--tile)");
  }
}

}  // namespace

LatticeBox lattice_box(const Box2d& tile, const Lattice& lattice) {
  const auto plane = [&](double metres) {
    const double node = std::round(metres / lattice.step_m);
    if (!(std::abs(node) < kFarthestTileNode)) {
      throw UsageError("--tile", "lies " + std::to_string(metres) +
                                     " m from 0, which is more than 2^27 lattice steps");
    }
    return static_cast<std::int32_t>(node);
  };
  const LatticeBox box{plane(tile.min_x), plane(tile.min_y), plane(tile.max_x), plane(tile.max_y)};
  if (box.empty()) {
    throw UsageError("--tile",
                     "is thinner than a lattice step of " + std::to_string(lattice.step_m) + " m");
  }
  return box;
}

Box2d box_in_metres(const LatticeBox& box, const Lattice& lattice) {
  const double step = lattice.step_m;
  return {box.x0 * step, box.y0 * step, box.x1 * step, box.y1 * step};
}

TileField make_band(const TileField& whole) {
  const std::set<Column> ring = ring_columns(whole.tile, whole.ramp + kRim);
  std::vector<FieldLevel> levels;
  for (std::size_t l = 0; l < whole.field.levels().size(); ++l) {
    levels.push_back(
        restrict_level(whole.field.levels()[l], columns_read(ring, static_cast<int>(l))));
  }
  return {Field(whole.field.lattice(), std::move(levels)),
          whole.tile,
          whole.ramp,
          whole.crs_text,
          true,
          whole.z0,
          whole.z1};
}

BlendedValues::BlendedValues(const TileField& own, std::span<const TileField> neighbours,
                             std::span<const std::string> names) {
  assert(own.ramp >= kLeastRamp && "welds and normals look two nodes beyond the border");
  assert(names.size() == neighbours.size() + 1 && "a name for each tile");
  for (std::size_t n = 0; n < neighbours.size(); ++n) {
    check_pair(own, neighbours[n], names[0], names[n + 1]);
    for (std::size_t m = 0; m < n; ++m) {
      check_pair(neighbours[m], neighbours[n], names[m + 1], names[n + 1]);
    }
  }
  parts_.push_back({&own, FieldValues(own.field, own.z0, own.z1)});
  const LatticeBox seen = own.tile.grown(kRim + own.ramp);
  for (const TileField& tile : neighbours) {
    if (tile.tile.touches(seen))
      parts_.push_back({&tile, FieldValues(tile.field, tile.z0, tile.z1)});
  }
  std::sort(parts_.begin(), parts_.end(),
            [](const Part& a, const Part& b) { return a.tile->tile < b.tile->tile; });
  while (parts_[own_].tile != &own) ++own_;
  for (std::int32_t s = 0; s <= 2 * own.ramp; ++s) {
    const double u = s / (2.0 * own.ramp);
    ramp_.push_back(u * u * (3.0 - 2.0 * u));
  }
}

/// Weight of a tile `inside` nodes inside one of its borders.
double BlendedValues::ramp_at(std::int32_t inside) const {
  const std::int32_t ramp = parts_[own_].tile->ramp;
  if (inside >= ramp) return 1.0;
  return inside <= -ramp ? 0.0 : ramp_[static_cast<std::size_t>(inside + ramp)];
}

/// True where no other tile has a weight above 0 on any of the brick's own nodes.
bool BlendedValues::is_plain(BrickKey brick) const {
  const LatticeBox nodes{kBrickSide * brick.x, kBrickSide * brick.y, kBrickSide * brick.x + 7,
                         kBrickSide * brick.y + 7};
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    // A weight is above 0 less than a ramp away.
    const std::int32_t reach = parts_[p].tile->ramp - 1;
    if (p != own_ && parts_[p].tile->tile.grown(reach).touches(nodes)) return false;
  }
  return true;
}

const float* BlendedValues::stored(BrickKey brick) const {
  return is_plain(brick) ? parts_[own_].values.stored(brick) : nullptr;
}

void BlendedValues::add(const Part& part, BrickKey brick, std::span<double, kBrickNodes> sums,
                        std::span<double, kBrickNodes> weights,
                        std::span<float, kBrickNodes> single) const {
  const LatticeBox& box = part.tile->tile;
  std::array<double, kBrickSide> along_x, along_y;
  double most_x = 0.0, most_y = 0.0;
  for (std::int32_t n = 0; n < kBrickSide; ++n) {
    const std::int32_t x = kBrickSide * brick.x + n, y = kBrickSide * brick.y + n;
    const auto at = static_cast<std::size_t>(n);
    along_x[at] = ramp_at(x - box.x0) * ramp_at(box.x1 - x);
    along_y[at] = ramp_at(y - box.y0) * ramp_at(box.y1 - y);
    most_x = std::max(most_x, along_x[at]), most_y = std::max(most_y, along_y[at]);
  }
  if (most_x == 0.0 || most_y == 0.0) return;
  std::array<float, kBrickNodes> room;
  const float* values = part.values.stored(brick);
  if (values == nullptr) {
    if (!part.values.compute(brick, room)) return;
    values = room.data();
  }
  for (std::size_t n = 0; n < kBrickNodes; ++n) {
    const double weight = along_x[n & 7] * along_y[n >> 3 & 7];
    if (weight == 0.0) continue;
    // One tile alone keeps its value to the bit.
    single[n] = weights[n] == 0.0 ? values[n] : std::nanf("");
    sums[n] += weight * values[n];
    weights[n] += weight;
  }
}

bool BlendedValues::compute(BrickKey brick, std::span<float, kBrickNodes> values) const {
  if (is_plain(brick)) return parts_[own_].values.compute(brick, values);
  std::array<double, kBrickNodes> sums{}, weights{};
  for (const Part& part : parts_) add(part, brick, sums, weights, values);
  bool known = false;
  for (std::size_t n = 0; n < kBrickNodes; ++n) {
    if (weights[n] == 0.0) {
      values[n] = std::nanf("");
    } else {
      if (std::isnan(values[n])) values[n] = static_cast<float>(sums[n] / weights[n]);
      known = true;
    }
  }
  return known;
}

std::vector<BrickKey> BlendedValues::crossing_bricks(BrickKey first, BrickKey last,
                                                     int threads) const {
  std::vector<BrickKey> all;
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const LatticeBox reach = parts_[p].tile->tile.grown(parts_[p].tile->ramp);
    BrickKey low = first, high = last;
    if (p != own_) {
      low.x = std::max(low.x, brick_of(reach.x0)), low.y = std::max(low.y, brick_of(reach.y0));
      high.x = std::min(high.x, brick_of(reach.x1)), high.y = std::min(high.y, brick_of(reach.y1));
    }
    if (low.x > high.x || low.y > high.y) continue;
    const std::vector<BrickKey> found = parts_[p].values.crossing_bricks(low, high, threads);
    all.insert(all.end(), found.begin(), found.end());
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

std::vector<LatticeBox> BlendedValues::tiles() const {
  std::vector<LatticeBox> boxes;
  for (const Part& part : parts_) boxes.push_back(part.tile->tile);
  return boxes;
}

}  // namespace cornice
