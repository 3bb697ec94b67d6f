// SPDX-License-Identifier: GPL-3.0-or-later
// The implicit function of a tile: values on the nodes of the survey's lattice, in sparse bricks at
// several levels. The solver makes it, border bands carry parts of it, the extraction reads it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "stages/poisson/bricks.h"

namespace cornice {

/// The grid that every tile of a survey shares: node (i, j, k) of level 0 lies at step * (i, j, k)
/// in projected coordinates, and level l has the spacing step * 2^l.
struct Lattice {
  double step_m = 0.5;

  friend bool operator==(const Lattice&, const Lattice&) = default;
};

/// Bricks of one level, sorted by key, each once, with 512 values each, x fastest, then y, then z.
struct FieldLevel {
  std::vector<BrickKey> bricks;
  std::vector<float> values;
};

/// Negative under the ground, positive above it, zero on the surface; the gradient points along the
/// outward normal. Where a level has no brick, the value is the trilinear interpolation of the next
/// coarser level: every node of every level that the coarsest one covers has one value, the same
/// bits whichever brick it is read with. Immutable once made; may be read from several threads.
class Field {
 public:
  Field() = default;
  /// levels[0] is the finest; every brick's far neighbours may be missing. Values are finite.
  Field(Lattice lattice, std::vector<FieldLevel> levels);

  const Lattice& lattice() const { return lattice_; }
  const std::vector<FieldLevel>& levels() const { return levels_; }

  /// Position of a brick in levels()[level].bricks, BrickIndex::kNone where it is not stored.
  std::uint32_t find(int level, BrickKey brick) const;

  /// The 9 x 9 x 9 nodes of a brick of `level`, stored there or not, x fastest. False where no
  /// level covers all of them; the values are then unspecified.
  bool closed_brick(int level, BrickKey brick, std::span<float, kClosedBrickNodes> values) const;

  /// Keys of the level-0 bricks between `first` and `last` (inclusive, per axis), stored or not, in
  /// which the field may change its sign: those whose closed brick holds both a value <= 0 and one
  /// >= 0, not all of them 0. Sorted. The same with any number of threads (0: all cores).
  std::vector<BrickKey> crossing_bricks(BrickKey first, BrickKey last, int threads) const;

 private:
  Lattice lattice_;
  std::vector<FieldLevel> levels_;
  std::vector<BrickIndex> index_;
};

}  // namespace cornice
