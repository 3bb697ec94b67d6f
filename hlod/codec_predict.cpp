// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/codec_predict.h"

#include <cassert>
#include <cstdint>
#include <cstring>
#include <limits>

#include "core/base/clones.h"
#include "hlod/file.h"
#include "hlod/lanes.h"
#include "hlod/octahedral.h"

namespace cornice::hlod {
namespace {

using Double4 [[gnu::vector_size(32)]] = double;
using Word4 [[gnu::vector_size(16)]] = std::uint32_t;

/// x, y, z and anything.
struct alignas(32) NormalSum {
  Double4 lanes;
};

/// Positions as far apart as this have sums that doubles hold whole: 2^35 for each of 2^18
/// triangles.
constexpr std::int64_t kExactExtent = std::int64_t{1} << 17;
static_assert(kCellTriangleLimit <= std::size_t{1} << 18);

/// A vertex's position, and in the last lane whatever comes after it.
CORNICE_INLINE void load_position(const CellVertex& vertex, Int4& lanes) {
  static_assert(sizeof(CellVertex) >= sizeof(Int4));
  load_lanes(&vertex, lanes);
}

CORNICE_INLINE void set_difference(const Int4& a, const Int4& b, Double4& to) {
  // As words, for the last lanes may be any distance apart.
  to = __builtin_convertvector((Int4)((Word4)b - (Word4)a), Double4);
}

CORNICE_INLINE void set_turned(const Double4& v, Double4& to) {
#if defined(__clang__) || __GNUC__ >= 12  // as in lanes.h
  to = __builtin_shufflevector(v, v, 1, 2, 0, 3);
#else
  to = Double4{v[1], v[2], v[0], v[3]};
#endif
}

CORNICE_CLONES
bool are_near(const CellVertex* vertices, std::size_t count) {
  Int4 low = Int4{} + std::numeric_limits<std::int32_t>::max();
  Int4 high = Int4{} + std::numeric_limits<std::int32_t>::min();
  for (std::size_t v = 0; v < count; ++v) {
    Int4 p;
    load_position(vertices[v], p);
    low = p < low ? p : low;
    high = p > high ? p : high;
  }
  bool near = true;
  for (std::size_t c = 0; c < 3; ++c) near &= std::int64_t{high[c]} - low[c] <= kExactExtent;
  return near;
}

CORNICE_CLONES
void add_normals(const CellVertex* vertices, const SmallTriangle* triangles, std::size_t count,
                 NormalSum* sums) {
  for (std::size_t i = 0; i < count; ++i) {
    const SmallTriangle& t = triangles[i];
    Int4 a, b, c;
    load_position(vertices[t[0]], a);
    load_position(vertices[t[1]], b);
    load_position(vertices[t[2]], c);
    Double4 u, v, next_u, next_v, normal;
    set_difference(a, b, u), set_difference(a, c, v);
    set_turned(u, next_u), set_turned(v, next_v);
    // This is z, x, y of the cross product: it is turned instead of either factor once more.
    set_turned(u * next_v - next_u * v, normal);
    for (const std::uint16_t corner : t) sums[corner].lanes += normal;
  }
}

/// The same in whole numbers that wrap around.
std::vector<NormalSum> far_sums(std::span<const CellVertex> vertices,
                                std::span<const SmallTriangle> triangles) {
  using Wide = Vec3<std::uint64_t>;
  std::vector<Wide> whole(vertices.size());
  const auto difference = [&](std::uint16_t a, std::uint16_t b) {
    const LatticePoint p = vertices[a].position, q = vertices[b].position;
    const auto wide = [](std::int32_t x) { return static_cast<std::uint64_t>(std::int64_t{x}); };
    return Wide{wide(p.x) - wide(q.x), wide(p.y) - wide(q.y), wide(p.z) - wide(q.z)};
  };
  for (const SmallTriangle& t : triangles) {
    const Wide normal = cross(difference(t[1], t[0]), difference(t[2], t[0]));
    for (const std::uint16_t v : t) whole[v] += normal;
  }
  std::vector<NormalSum> sums(whole.size());
  for (std::size_t v = 0; v < sums.size(); ++v) {
    const Vec3d sum = whole[v].cast<std::int64_t>().cast<double>();
    sums[v].lanes = Double4{sum.x, sum.y, sum.z, 0.0};
  }
  return sums;
}

}  // namespace

std::vector<PackedNormal> guessed_normals(std::span<const CellVertex> vertices,
                                          std::span<const SmallTriangle> triangles, int bits) {
  assert(triangles.size() <= kCellTriangleLimit && "sums are not exact");
  std::vector<NormalSum> sums;
  if (are_near(vertices.data(), vertices.size())) {
    sums.resize(vertices.size());
    add_normals(vertices.data(), triangles.data(), triangles.size(), sums.data());
  } else {
    sums = far_sums(vertices, triangles);
  }
  std::vector<PackedNormal> guesses(sums.size());
  for (std::size_t v = 0; v < guesses.size(); ++v) {
    const Double4& n = sums[v].lanes;
    guesses[v] = round_octahedral(Vec3d{n[0], n[1], n[2]}, bits);
  }
  return guesses;
}

}  // namespace cornice::hlod
