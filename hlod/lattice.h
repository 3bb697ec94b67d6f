// SPDX-License-Identifier: GPL-3.0-or-later
// The integer lattice of a hierarchy: every position of every level is a whole number of its
// level's steps, so that a vertex shared by two cells is the same numbers in both.
#pragma once

#include <cassert>
#include <cstdint>

#include "core/base/vec.h"

namespace cornice::hlod {

/// Position in steps of one level, from the lattice's origin. |x|, |y|, |z| < 2^30.
using LatticePoint = Vec3<std::int32_t>;

/// Levels run from 0 (coarsest, one root cell or few) to finest_level. The side of a cell of level
/// l is root_side / 2^l; the step of level l is the side of its cells / 2^cell_bits. A step of
/// level l is therefore exactly two steps of level l+1, and a cell of level l holds 2 x 2 (x 2) of
/// level l+1.
struct Lattice {
  Vec3d origin;          ///< projected CRS, metres; corner of cell (0, 0, 0) of every level
  double root_side = 0;  ///< metres
  int finest_level = 0;  ///< 0..16
  int cell_bits = 14;    ///< 8..16: a cell's side is 2^cell_bits steps of its own level

  /// Side of a cell of a level, metres.
  double cell_side(int level) const { return root_side / static_cast<double>(1 << level); }
  /// Step of a level, metres.
  double step(int level) const { return cell_side(level) / static_cast<double>(1 << cell_bits); }
  Vec3d position(LatticePoint p, int level) const {
    return origin + step(level) * p.cast<double>();
  }

  friend bool operator==(const Lattice&, const Lattice&) = default;
};

/// The nearest point of the next coarser level's lattice, halves towards positive infinity: a
/// function of the position alone, so every cell and every machine rounds a shared vertex alike.
constexpr LatticePoint coarsened(LatticePoint p) {
  return {(p.x + 1) >> 1, (p.y + 1) >> 1, (p.z + 1) >> 1};
}
/// The same place in steps of the next finer level: exact.
constexpr LatticePoint refined(LatticePoint p) { return {2 * p.x, 2 * p.y, 2 * p.z}; }

}  // namespace cornice::hlod
