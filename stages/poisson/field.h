// SPDX-License-Identifier: GPL-3.0-or-later
// The implicit function of a tile: values on the nodes of the survey's lattice, in sparse bricks at
// several levels. The solver makes it, border bands carry parts of it, the extraction reads it.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/vec.h"

namespace cornice {

/// The grid that every tile of a survey shares: node (i, j, k) of level 0 lies at step * (i, j, k)
/// in projected coordinates, and level l has the spacing step * 2^l.
struct Lattice {
  double step_m = 0.5;

  friend bool operator==(const Lattice&, const Lattice&) = default;
};

inline constexpr int kBrickSide = 8;                 ///< cells per axis
inline constexpr int kBrickNodes = 8 * 8 * 8;        ///< nodes that a brick owns
inline constexpr int kClosedBrickNodes = 9 * 9 * 9;  ///< with those of its far faces

/// Brick b of level l owns the nodes 8b .. 8b+7 (per axis) of that level.
struct BrickKey {
  std::int32_t x = 0, y = 0, z = 0;

  friend auto operator<=>(const BrickKey&, const BrickKey&) = default;
};

/// Bricks of one level, sorted by key, with 512 values each, x fastest, then y, then z.
struct FieldLevel {
  std::vector<BrickKey> bricks;
  std::vector<float> values;
};

/// Negative under the ground, positive above it, zero on the surface; the gradient points along the
/// outward normal. Where a level has no brick, the value is the trilinear interpolation of the next
/// coarser level. Immutable once made; may be read from several threads.
class Field {
 public:
  /// levels[0] is the finest; every brick's far neighbours may be missing.
  Field(Lattice lattice, std::vector<FieldLevel> levels);

  const Lattice& lattice() const { return lattice_; }
  const std::vector<FieldLevel>& levels() const { return levels_; }

  /// The 9 x 9 x 9 nodes of a brick of `level`, stored there or not. False where no level covers
  /// all of them; the values are then unspecified.
  bool closed_brick(int level, BrickKey brick, std::span<float, kClosedBrickNodes> values) const;

  /// Keys of the level-0 bricks between `first` and `last` (inclusive, per axis), stored or not, in
  /// which the field may change its sign; sorted.
  std::vector<BrickKey> crossing_bricks(BrickKey first, BrickKey last, int threads) const;

 private:
  Lattice lattice_;
  std::vector<FieldLevel> levels_;
};

}  // namespace cornice
