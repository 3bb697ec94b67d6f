// SPDX-License-Identifier: GPL-3.0-or-later
// What a decoder can guess of a vertex before it reads it. Encoder and decoder
// must come to the same guess on every machine: whole numbers that wrap around,
// and doubles in operations that IEEE 754 rounds exactly (the build forbids
// fused ones).
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "hlod/cell.h"
#include "hlod/codec_fields.h"
#include "hlod/codec_walk.h"

namespace cornice::hlod {

inline std::uint32_t wrapped(std::int32_t value) { return static_cast<std::uint32_t>(value); }

/// Positions as three numbers, so that an axis can be chosen at run time.
using Triple = std::array<std::int32_t, 3>;
inline Triple triple(LatticePoint p) { return {p.x, p.y, p.z}; }

/// A vertex beyond edge a-b of triangle (a, b, o). Two coordinates are taken
/// from the parallelogram a + b - o; the third, along which the triangle's
/// plane is least steep, from that plane once the two are known: on a slope the
/// parallelogram's error in plan does not spoil the height.
class PositionGuess {
 public:
  PositionGuess(const Triple& a, const Triple& b, const Triple& o) : o_(o) {
    std::array<double, 3> u{}, v{};
    for (std::size_t c = 0; c < 3; ++c) {
      u[c] = static_cast<double>(a[c]) - o[c];
      v[c] = static_cast<double>(b[c]) - o[c];
      flat_[c] = static_cast<std::int32_t>(wrapped(a[c]) + wrapped(b[c]) - wrapped(o[c]));
    }
    normal_ = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const double x = std::abs(normal_[0]), y = std::abs(normal_[1]), z = std::abs(normal_[2]);
    axis_ = z >= x && z >= y ? 2 : y >= x ? 1 : 0;
  }

  /// The coordinate to be guessed last, 0..2.
  std::size_t axis() const { return axis_; }
  /// Of one of the other two.
  std::int32_t flat(std::size_t coordinate) const { return flat_[coordinate]; }
  /// Of coordinate kAxis, which must be axis(), the other two of `p` being
  /// right.
  template <std::size_t kAxis>
  std::int32_t last(const Triple& p) const {
    if (normal_[kAxis] == 0.0) return flat_[kAxis];
    constexpr std::size_t s = (kAxis + 1) % 3, t = (kAxis + 2) % 3;
    const double ds = static_cast<double>(p[s]) - o_[s], dt = static_cast<double>(p[t]) - o_[t];
    const double guess = o_[kAxis] - (normal_[s] * ds + normal_[t] * dt) / normal_[kAxis];
    if (!(std::abs(guess) < 0x1p30)) return flat_[kAxis];
    // To the nearest whole number, by way of a positive one: floor() is a call
    // where it is not an instruction.
    return static_cast<std::int32_t>(static_cast<std::int64_t>(guess + (0x1p31 + 0.5)) -
                                     (std::int64_t{1} << 31));
  }

 private:
  Triple o_, flat_;
  std::array<double, 3> normal_;
  std::size_t axis_;
};

/// Per vertex the direction of the sum of its triangles' normals, each as long as twice the
/// triangle's area, as a rounded octahedral pair of `bits` bits a component. Sums wrap around where
/// positions are wild. At most kCellTriangleLimit triangles.
std::vector<PackedNormal> guessed_normals(std::span<const CellVertex> vertices,
                                          std::span<const SmallTriangle> triangles, int bits);

}  // namespace cornice::hlod
