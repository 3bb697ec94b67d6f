// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/poisson/extract_brick.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "core/base/random.h"
#include "stages/poisson/extract_table.h"

namespace cornice {
namespace {

constexpr int kSide = BrickSurface::kSide;
constexpr std::array<int, 3> kStride{1, kSide, kSide* kSide};
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

/// Bits 1 .. 9: nodes 0 .. 8 of a row.
constexpr unsigned kClosedBits = 0x3fe;
/// Bits 0 .. 9: lower nodes -1 .. 8 of edges along x.
constexpr unsigned kLowerBits = 0x3ff;

constexpr int row_at(int j, int k) { return j + 1 + kSide * (k + 1); }

struct NodePlace {
  int i, j, k;
};
constexpr NodePlace place_of(int node) {
  return {node % kSide - 1, node / kSide % kSide - 1, node / (kSide * kSide) - 1};
}

/// Directions are 2 * axis for the positive one, 2 * axis + 1 for the other.
constexpr int step_of(int direction) {
  return (direction & 1) != 0 ? -kStride[static_cast<std::size_t>(direction >> 1)]
                              : kStride[static_cast<std::size_t>(direction >> 1)];
}

}  // namespace

std::uint32_t VertexTable::number() {
  std::uint32_t count = 0;
  for (std::size_t w = 0; w < mask.size(); ++w) {
    before[w] = static_cast<std::uint16_t>(count);
    count += static_cast<std::uint32_t>(std::popcount(mask[w]));
  }
  return count;
}

std::uint32_t VertexTable::rank(int node, VertexKind kind) const {
  const auto bit = static_cast<unsigned>(4 * node + static_cast<int>(kind));
  const std::uint64_t below = (std::uint64_t{1} << (bit & 63)) - 1;
  return before[bit >> 6] + static_cast<std::uint32_t>(std::popcount(mask[bit >> 6] & below));
}

std::size_t VertexTable::welded() const {
  std::size_t count = 0;
  for (const std::uint64_t word : mask) {
    count += static_cast<std::size_t>(std::popcount(word & 0x1111111111111111ULL));
  }
  return count;
}

std::size_t BrickCache::Hash::operator()(BrickKey b) const {
  return mix64(
      mix64(static_cast<std::uint32_t>(b.x) + 0x9e3779b97f4a7c15ULL) +
      (std::uint64_t{static_cast<std::uint32_t>(b.y)} << 32 | static_cast<std::uint32_t>(b.z)));
}

BrickCache::Nodes BrickCache::nodes(BrickKey brick) {
  if (const float* kept = values_.stored(brick)) return {kept, true};
  const auto [entry, is_new] = computed_.try_emplace(brick);
  Computed& computed = entry->second;
  if (is_new) {
    computed.values = std::make_unique<std::array<float, kBrickNodes>>();
    if (!values_.compute(brick, *computed.values)) {
      computed.values.reset();
    } else {
      computed.all_known = std::none_of(computed.values->begin(), computed.values->end(),
                                        [](float v) { return std::isnan(v); });
    }
  }
  return {computed.values ? computed.values->data() : nullptr, computed.all_known};
}

BrickSurface::BrickSurface(const BrickRules& rules) : rules_(rules) {}

bool BrickSurface::load(BrickKey brick, BrickCache& cache) {
  brick_ = brick;
  x0_ = rules_.window.x0 - kBrickSide * brick.x, x1_ = rules_.window.x1 - kBrickSide * brick.x;
  y0_ = rules_.window.y0 - kBrickSide * brick.y, y1_ = rules_.window.y1 - kBrickSide * brick.y;
  const LatticeBox nodes{kBrickSide * brick.x, kBrickSide * brick.y, kBrickSide * (brick.x + 1),
                         kBrickSide * (brick.y + 1)};
  planes_.clear();
  for (const LatticeBox& border : rules_.borders) {
    if (border.touches(nodes)) planes_.push_back(border);
  }
  gather(cache);
  read_signs();
  unsigned any = 0, all = ~0u;
  for (std::size_t r = 0; r < negative_.size(); ++r) {
    any |= negative_[r];
    all &= negative_[r] | ~static_cast<unsigned>(known_[r]);
  }
  // Unknown nodes count as neither sign.
  const bool one_sign = any == 0 || (all & 0x7ff) == 0x7ff;
  for (const std::int16_t node : touched_) {
    near_[static_cast<std::size_t>(node)] = weld_[static_cast<std::size_t>(node)] = 0;
  }
  touched_.clear();
  crowded_.clear();
  if (one_sign) return false;
  find_crossings();
  weld();
  return true;
}

/// Copies what brick + (dx, dy, dz) owns of the padded nodes; `from` null: nothing is known there.
void BrickSurface::copy_nodes(const float* from, int dx, int dy, int dz) {
  const auto first = [](int d) { return d < 0 ? -1 : d == 0 ? 0 : 8; };
  const auto end = [](int d) { return d < 0 ? 0 : d == 0 ? 8 : 10; };
  const auto copy_rows = [&]<int kCount>(std::integral_constant<int, kCount>, int i0) {
    for (int k = first(dz); k < end(dz); ++k) {
      for (int j = first(dy); j < end(dy); ++j) {
        float* to = values_.data() + at(i0, j, k);
        if (from == nullptr) {
          std::fill_n(to, kCount, kUnknown);
        } else {
          // A length known to the compiler: these copies are most of the work of reading.
          std::memcpy(to, from + (i0 & 7) + kBrickSide * ((j & 7) + kBrickSide * (k & 7)),
                      kCount * sizeof(float));
        }
      }
    }
  };
  if (dx < 0) copy_rows(std::integral_constant<int, 1>(), -1);
  if (dx == 0) copy_rows(std::integral_constant<int, 8>(), 0);
  if (dx > 0) copy_rows(std::integral_constant<int, 2>(), 8);
}

void BrickSurface::gather(BrickCache& cache) {
  all_known_ = true;
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const BrickCache::Nodes nodes = cache.nodes(shifted(brick_, dx, dy, dz));
        all_known_ = all_known_ && nodes.all_known;
        copy_nodes(nodes.values, dx, dy, dz);
      }
    }
  }
}

void BrickSurface::read_signs() {
  for (std::size_t r = 0; r < negative_.size(); ++r) {
    unsigned negative = 0, known = 0x7ff;
    const float* row = values_.data() + r * kSide;
    for (int b = 0; b < kSide; ++b) negative |= static_cast<unsigned>(row[b] < 0.0f) << b;
    if (!all_known_) {
      known = 0;
      for (int b = 0; b < kSide; ++b) known |= static_cast<unsigned>(!std::isnan(row[b])) << b;
    }
    negative_[r] = static_cast<std::uint16_t>(negative);
    known_[r] = static_cast<std::uint16_t>(known);
  }
}

/// Nodes (bits) of a row whose edge along `axis` is crossed.
unsigned BrickSurface::crossings(int row, int axis) const {
  const auto r = static_cast<std::size_t>(row);
  if (axis == 0) {
    const unsigned n = negative_[r], k = known_[r];
    return (n ^ n >> 1) & k & k >> 1 & kLowerBits;
  }
  const std::size_t next = r + (axis == 1 ? 1 : kSide);
  return static_cast<unsigned>((negative_[r] ^ negative_[next]) & known_[r] & known_[next]);
}

void BrickSurface::find_crossings() {
  for (int k = -1; k < 9; ++k) {
    for (int j = -1; j < 9; ++j) {
      const int row = row_at(j, k);
      if (j >= 0 && k >= 0) add_crossings(crossings(row, 0), row, 0);
      if (k >= 0) add_crossings(crossings(row, 1) & kClosedBits, row, 1);
      if (j >= 0) add_crossings(crossings(row, 2) & kClosedBits, row, 2);
    }
  }
}

/// Places the crossings of a row's edges and notes which nodes they are close to.
void BrickSurface::add_crossings(unsigned bits, int row, int axis) {
  const int stride = kStride[static_cast<std::size_t>(axis)];
  for (; bits != 0; bits &= bits - 1) {
    const int node = row * kSide + std::countr_zero(bits);
    const double low = values_[static_cast<std::size_t>(node)];
    const double high = values_[static_cast<std::size_t>(node + stride)];
    const double part = low / (low - high);
    const int units =
        std::clamp(static_cast<int>(part * kUnitsPerStep + 0.5), 1, kUnitsPerStep - 1);
    units_[static_cast<std::size_t>(axis)][static_cast<std::size_t>(node)] =
        static_cast<std::int16_t>(units);
    int close = -1, direction = 2 * axis;
    if (units < rules_.weld_units) close = node;
    if (units > kUnitsPerStep - rules_.weld_units) close = node + stride, ++direction;
    if (close < 0) continue;
    std::uint8_t& near = near_[static_cast<std::size_t>(close)];
    (near == 0 ? touched_ : crowded_).push_back(static_cast<std::int16_t>(close));
    near = static_cast<std::uint8_t>(near | 1u << direction);
  }
}

void BrickSurface::weld() {
  for (const std::int16_t node : crowded_) {
    const auto [i, j, k] = place_of(node);
    if (std::min({i, j, k}) < 0 || std::max({i, j, k}) > 8) continue;
    weld_[static_cast<std::size_t>(node)] = weld_of(node);
  }
}

/// Axes (bits) that a vertex at the node must not move along, because it is on a border plane.
unsigned BrickSurface::constrained_axes(int node) const {
  const auto [i, j, k] = place_of(node);
  const std::int32_t x = kBrickSide * brick_.x + i, y = kBrickSide * brick_.y + j;
  unsigned axes = 0;
  for (const LatticeBox& border : planes_) {
    if (!border.touches({x, y, x, y})) continue;
    if (x == border.x0 || x == border.x1) axes |= 1;
    if (y == border.y0 || y == border.y1) axes |= 2;
  }
  return axes;
}

/// Directions (bits) of the vertices that become one with the node; none where fewer than two, or
/// where it would not leave a manifold.
std::uint8_t BrickSurface::weld_of(int node) const {
  const auto known = [&](int n) { return !std::isnan(values_[static_cast<std::size_t>(n)]); };
  unsigned near = near_[static_cast<std::size_t>(node)];
  const unsigned fixed = constrained_axes(node);
  if ((fixed & 1) != 0) near &= ~3u;
  if ((fixed & 2) != 0) near &= ~12u;
  if (std::popcount(near) < 2) return 0;
  const bool sign = is_negative(node);
  std::array<int, 3> steps{};
  int crossed = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int stride = kStride[static_cast<std::size_t>(axis)];
    if (!known(node + stride) || !known(node - stride)) return 0;
    const bool up = is_negative(node + stride) != sign, down = is_negative(node - stride) != sign;
    if (up && down) return 0;
    if (up || down) steps[static_cast<std::size_t>(crossed++)] = up ? stride : -stride;
  }
  for (int a = 0; a < crossed; ++a) {
    for (int b = a + 1; b < crossed; ++b) {
      const int across =
          node + steps[static_cast<std::size_t>(a)] + steps[static_cast<std::size_t>(b)];
      if (!known(across) || is_negative(across) == sign) return 0;
    }
  }
  return static_cast<std::uint8_t>(near);
}

VertexTable BrickSurface::vertices() const {
  VertexTable table;
  for (int k = 0; k < 8; ++k) {
    for (int j = std::max(y0_, 0); j < 8 && j <= y1_; ++j) {
      for (int axis = 0; axis < 3; ++axis) {
        if (axis == 1 && j == y1_) continue;
        const int row = row_at(j, k);
        for (unsigned bits = crossings(row, axis) & 0x1fe; bits != 0; bits &= bits - 1) {
          const int i = std::countr_zero(bits) - 1;
          if (i < x0_ || i > x1_ || (axis == 0 && i == x1_)) continue;
          const BrickVertex vertex = vertex_on(at(i, j, k), axis);
          if (vertex.kind != VertexKind::kNode) table.set(i + 8 * (j + 8 * k), vertex.kind);
        }
      }
    }
  }
  for (const std::int16_t node : crowded_) {
    const auto [i, j, k] = place_of(node);
    if (weld_[static_cast<std::size_t>(node)] == 0 || std::max({i, j, k}) > 7) continue;
    if (i < x0_ || i > x1_ || j < y0_ || j > y1_) continue;
    table.set(i + 8 * (j + 8 * k), VertexKind::kNode);
  }
  return table;
}

std::uint32_t BrickSurface::neighbours_needed() const {
  const auto bit = [](int dx, int dy, int dz) {
    return 1u << (dx + 1 + 3 * (dy + 1) + 9 * (dz + 1));
  };
  std::uint32_t needed = 0;
  // A plane of nodes goes on where it holds known nodes of both signs.
  std::array<std::array<bool, 2>, 6> seen{};
  for (int k = 0; k < 9; ++k) {
    for (int j = 0; j < 9; ++j) {
      const auto r = static_cast<std::size_t>(row_at(j, k));
      const unsigned below = negative_[r] & kClosedBits;
      const unsigned above = ~static_cast<unsigned>(negative_[r]) & known_[r] & kClosedBits;
      const auto look = [&](std::size_t plane, unsigned bits) {
        seen[plane][0] = seen[plane][0] || (below & bits) != 0;
        seen[plane][1] = seen[plane][1] || (above & bits) != 0;
      };
      look(0, 1u << 1), look(1, 1u << 9);
      if (j == 0) look(2, kClosedBits);
      if (j == 8) look(3, kClosedBits);
      if (k == 0) look(4, kClosedBits);
      if (k == 8) look(5, kClosedBits);
    }
  }
  const auto both = [&](std::size_t plane) { return seen[plane][0] && seen[plane][1]; };
  if (both(0)) needed |= bit(-1, 0, 0);
  if (both(1)) needed |= bit(1, 0, 0);
  if (both(2)) needed |= bit(0, -1, 0);
  if (both(3)) needed |= bit(0, 1, 0);
  if (both(4)) needed |= bit(0, 0, -1);
  if (both(5)) needed |= bit(0, 0, 1);
  for (const std::int16_t node : crowded_) {
    const auto [i, j, k] = place_of(node);
    if (weld_[static_cast<std::size_t>(node)] != 0) needed |= bit(i >> 3, j >> 3, k >> 3);
  }
  return needed & ~bit(0, 0, 0);
}

/// The vertex that stands for the crossing of the edge from `node` along `axis`.
BrickVertex BrickSurface::vertex_on(int node, int axis) const {
  const int stride = kStride[static_cast<std::size_t>(axis)];
  if ((weld_[static_cast<std::size_t>(node)] >> (2 * axis) & 1) != 0) {
    return {node, VertexKind::kNode};
  }
  if ((weld_[static_cast<std::size_t>(node + stride)] >> (2 * axis + 1) & 1) != 0) {
    return {node + stride, VertexKind::kNode};
  }
  return {node, static_cast<VertexKind>(axis + 1)};
}

Vec3<std::int32_t> BrickSurface::position(BrickVertex vertex) const {
  const auto [i, j, k] = place_of(vertex.node);
  std::array<std::int32_t, 3> p{kUnitsPerStep * i, kUnitsPerStep * j, kUnitsPerStep * k};
  if (vertex.kind != VertexKind::kNode) {
    const auto axis = static_cast<std::size_t>(vertex.kind) - 1;
    p[axis] += units_[axis][static_cast<std::size_t>(vertex.node)];
  } else {
    const unsigned members = weld_[static_cast<std::size_t>(vertex.node)];
    const int count = std::popcount(members);
    for (unsigned bits = members; bits != 0; bits &= bits - 1) {
      const int direction = std::countr_zero(bits);
      const auto axis = static_cast<std::size_t>(direction >> 1);
      const bool down = (direction & 1) != 0;
      const int edge = down ? vertex.node - kStride[axis] : vertex.node;
      const int units = units_[axis][static_cast<std::size_t>(edge)];
      const int share = ((down ? kUnitsPerStep - units : units) + count / 2) / count;
      p[axis] += down ? -share : share;
    }
  }
  return {p[0], p[1], p[2]};
}

/// Central differences, one-sided where the field is not known on one side.
Vec3f BrickSurface::gradient(int node) const {
  std::array<float, 3> g{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float here = values_[static_cast<std::size_t>(node)];
    float above = values_[static_cast<std::size_t>(node + kStride[axis])];
    float below = values_[static_cast<std::size_t>(node - kStride[axis])];
    float scale = 0.5f;
    if (!all_known_) {
      if (std::isnan(above)) above = here, scale = 1.0f;
      if (std::isnan(below)) below = here, scale = 1.0f;
    }
    g[axis] = scale * (above - below);
  }
  return {g[0], g[1], g[2]};
}

Vec3f BrickSurface::normal(BrickVertex vertex) const {
  if (vertex.kind == VertexKind::kNode) {
    const Vec3f g = gradient(vertex.node);
    return norm(g) > 0.0f ? normalized(g) : Vec3f{0, 0, 1};
  }
  const auto axis = static_cast<std::size_t>(vertex.kind) - 1;
  const float part = static_cast<float>(units_[axis][static_cast<std::size_t>(vertex.node)]) /
                     static_cast<float>(kUnitsPerStep);
  const int end = vertex.node + kStride[axis];
  const Vec3f g = gradient(vertex.node) * (1.0f - part) + gradient(end) * part;
  if (norm(g) > 0.0f) return normalized(g);
  // The values change along the edge, whatever the differences around say.
  const float sign = is_negative(vertex.node) ? 1.0f : -1.0f;
  return {axis == 0 ? sign : 0, axis == 1 ? sign : 0, axis == 2 ? sign : 0};
}

/// Cells (bits i) of a row that the surface passes through.
unsigned BrickSurface::cells_of_row(int j, int k) const {
  unsigned any = 0, all = ~0u, known = ~0u;
  for (const int row : {row_at(j, k), row_at(j + 1, k), row_at(j, k + 1), row_at(j + 1, k + 1)}) {
    any |= negative_[static_cast<std::size_t>(row)];
    all &= negative_[static_cast<std::size_t>(row)];
    known &= known_[static_cast<std::size_t>(row)];
  }
  const unsigned cells = (any | any >> 1) & ~(all & all >> 1) & known & known >> 1;
  const int first = std::max(x0_, 0), end = std::min(x1_, 8);
  if (first >= end) return 0;
  return cells >> 1 & ((1u << end) - (1u << first));
}

unsigned BrickSurface::signs_of_cell(int cell) const {
  unsigned negative = 0;
  for (unsigned c = 0; c < 8; ++c) {
    const int node = cell + static_cast<int>(c & 1) + kSide * static_cast<int>(c >> 1 & 1) +
                     kSide * kSide * static_cast<int>(c >> 2);
    negative |= static_cast<unsigned>(is_negative(node)) << c;
  }
  return negative;
}

/// Faces (bits) across which the negative corners hang together, by the sign at the saddle of the
/// bilinear interpolation: Nielson & Hamann, "The asymptotic decider" (1991). Products of two
/// floats are exact as doubles, so both cells of a face decide alike.
unsigned BrickSurface::joined_faces(int cell, unsigned negative, unsigned ambiguous) const {
  unsigned joined = 0;
  for (; ambiguous != 0; ambiguous &= ambiguous - 1) {
    const auto face = static_cast<unsigned>(std::countr_zero(ambiguous));
    double below = 1.0, above = 1.0;
    for (const unsigned c : kFaceNodes[face]) {
      const int node = cell + static_cast<int>(c & 1) + kSide * static_cast<int>(c >> 1 & 1) +
                       kSide * kSide * static_cast<int>(c >> 2);
      ((negative >> c & 1) != 0 ? below : above) *= values_[static_cast<std::size_t>(node)];
    }
    if (below > above) joined |= 1u << face;
  }
  return joined;
}

LoopCorner BrickSurface::corner_on(int cell, unsigned edge) const {
  const unsigned low = edge & 1, high = edge >> 1 & 1;
  const auto axis = static_cast<int>(edge >> 2);
  const auto offset = [&](int first, int second) {
    return static_cast<int>(low) * kStride[static_cast<std::size_t>(first)] +
           static_cast<int>(high) * kStride[static_cast<std::size_t>(second)];
  };
  const int node = cell + (axis == 0 ? offset(1, 2) : axis == 1 ? offset(0, 2) : offset(0, 1));
  const BrickVertex vertex = vertex_on(node, axis);
  LoopCorner corner;
  corner.vertex = static_cast<std::uint32_t>(4 * vertex.node + static_cast<int>(vertex.kind));
  corner.faces = kEdgeFaces[edge];
  if (vertex.kind == VertexKind::kNode) {
    const auto [i, j, k] = place_of(vertex.node);
    const auto [ci, cj, ck] = place_of(cell);
    corner.faces =
        static_cast<std::uint8_t>(1u << (i - ci) | 1u << (2 + j - cj) | 1u << (4 + k - ck));
  }
  return corner;
}

/// The corners of a loop, each once; those that were made one are next to each other.
std::size_t BrickSurface::make_corners(int cell, const std::uint8_t* edges, std::size_t length,
                                       std::array<LoopCorner, kMaxLoop>& corners) const {
  std::size_t count = 0;
  for (std::size_t e = 0; e < length; ++e) {
    const LoopCorner corner = corner_on(cell, edges[e]);
    if (count == 0 || corner.vertex != corners[count - 1].vertex) corners[count++] = corner;
  }
  while (count > 1 && corners[count - 1].vertex == corners[0].vertex) --count;
  // Of three corners there is nothing to choose.
  for (std::size_t c = 0; count > 3 && c < count; ++c) {
    const std::uint32_t code = corners[c].vertex;
    corners[c].at = position({static_cast<int>(code >> 2), static_cast<VertexKind>(code & 3)});
  }
  return count;
}

/// `corners` are more than three, or they could have been cut.
CentreVertex BrickSurface::centre_of(int cell, std::span<const LoopCorner> corners) const {
  CentreVertex centre;
  for (const LoopCorner& corner : corners) centre.position += corner.at;
  // All lie in the brick or within a step of it: one step more makes every sum positive.
  const auto n = static_cast<std::int32_t>(corners.size());
  const auto mean = [n](std::int32_t sum) {
    return (sum + n * kUnitsPerStep + n / 2) / n - kUnitsPerStep;
  };
  centre.position = {mean(centre.position.x), mean(centre.position.y), mean(centre.position.z)};
  Vec3f g{};
  for (int c = 0; c < 8; ++c) {
    g += gradient(cell + (c & 1) + kSide * (c >> 1 & 1) + kSide * kSide * (c >> 2));
  }
  centre.normal = norm(g) > 0.0f ? normalized(g) : Vec3f{0, 0, 1};
  return centre;
}

void BrickSurface::cut_cell(int cell, std::vector<std::array<std::uint32_t, 3>>& triangles,
                            std::vector<CentreVertex>& centres) const {
  const unsigned negative = signs_of_cell(cell);
  const unsigned ambiguous = ambiguous_faces(negative);
  const CellLoops& loops =
      cell_loops(negative, ambiguous == 0 ? 0 : joined_faces(cell, negative, ambiguous));
  std::array<LoopCorner, kMaxLoop> corners;
  LoopTriangles cut;
  const std::uint8_t* edges = loops.edges.data();
  for (std::size_t l = 0; l < loops.loops; edges += loops.length[l], ++l) {
    const std::size_t count = make_corners(cell, edges, loops.length[l], corners);
    if (count < 3) continue;
    const std::span<const LoopCorner> loop(corners.data(), count);
    const std::size_t cuts = cut_loop(loop, cut);
    for (std::size_t t = 0; t < cuts; ++t) {
      triangles.push_back({loop[cut[t][0]].vertex, loop[cut[t][1]].vertex, loop[cut[t][2]].vertex});
    }
    if (cuts > 0) continue;
    const auto centre = static_cast<std::uint32_t>(kCentre + centres.size());
    for (std::size_t c = 0; c < count; ++c) {
      triangles.push_back({loop[c].vertex, loop[(c + 1) % count].vertex, centre});
    }
    centres.push_back(centre_of(cell, loop));
  }
}

void BrickSurface::cut(std::vector<std::array<std::uint32_t, 3>>& triangles,
                       std::vector<CentreVertex>& centres) const {
  for (int k = 0; k < 8; ++k) {
    for (int j = std::max(y0_, 0); j < std::min(y1_, 8); ++j) {
      for (unsigned cells = cells_of_row(j, k); cells != 0; cells &= cells - 1) {
        cut_cell(at(std::countr_zero(cells), j, k), triangles, centres);
      }
    }
  }
}

}  // namespace cornice
