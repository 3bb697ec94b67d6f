// SPDX-License-Identifier: GPL-3.0-or-later
// How a vertex moves between its own place and its parent's, in whole numbers alone: a shader that
// follows these lines with 32-bit integers comes to the same bits, and so do two cells that share a
// vertex. Everything is in fine steps, that is steps of the finest level, unless said otherwise.
// docs/decisions/0600-radii.md proves why nothing cracks.
//
//      lambda
//   1 ------------.                     a vertex of level l at distance d from the eye is drawn at
//                  \                    parent + lambda (itself - parent)
//   0 --------------'-------- d
//            start_l  end_l
//
// The band is a sixteenth of the way to its end, or what radii leave of that.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>

#include "hlod/cell.h"

namespace cornice::hlod {

/// Position in fine steps. Vertices: |coordinate| <= 2^29; eyes: <= 2^30.
using FinePoint = Vec3<std::int32_t>;

/// Levels at most: 0..16.
inline constexpr int kLevelLimit = 17;

/// What distances are measured in. In a quadtree cells are columns, so the height of what stands in
/// them must not count: the vertical part is the eye's distance to the slab that holds everything.
struct Metric {
  int finest_level = 0;
  int cell_bits = 14;
  double edge_share = 0.25;
  Partition partition = Partition::kQuadtree;
  std::int32_t slab_low = 0, slab_high = 0;  ///< heights of all vertices; quadtrees only

  /// Side of a cell of a level.
  std::int32_t side(int level) const { return 1 << (cell_bits + finest_level - level); }
  /// s0 times that, rounded up: how far vertices lie outside of their cells at most.
  std::int32_t share(int level) const;
  /// Least D_{level-1} - D_level: (1 + 3 s0) cell sides and a sixteenth, which is the narrowest
  /// band a level may morph in.
  std::int32_t gap(int level) const {
    return side(level) + 3 * share(level) + std::max(1, side(level) >> 4);
  }
};

/// The eye's fine step: floor, held within 2^30 of the origin, from where everything is far.
FinePoint fine_eye(Vec3d eye, const Lattice& lattice);

/// The vertical part of every distance in a quadtree; 0 in an octree.
inline std::int32_t slab_distance(FinePoint eye, const Metric& metric) {
  if (metric.partition == Partition::kOctree) return 0;
  return std::max({0, metric.slab_low - eye.z, eye.z - metric.slab_high});
}

/// A vertex of `level`, its own steps, seen from the eye: fine steps.
inline FinePoint seen_from(FinePoint eye, LatticePoint p, int finer) {
  return {(p.x << finer) - eye.x, (p.y << finer) - eye.y, (p.z << finer) - eye.z};
}

/// Distance of a vertex that is seen from the eye; slab: slab_distance().
inline std::int32_t eye_distance(FinePoint seen, std::int32_t slab, Partition partition) {
  const std::int32_t vertical = partition == Partition::kOctree ? std::abs(seen.z) : slab;
  return std::max({std::abs(seen.x), std::abs(seen.y), vertical});
}

/// D_l of every level, fine steps; see the decision page. D_{l-1} >= D_l + gap(l), D_L <= 0.
struct Radii {
  std::array<std::int64_t, kLevelLimit> of{};
};

/// What a shader needs to know of a level to morph its vertices: four numbers a frame.
struct MorphBand {
  std::int32_t end = 0;    ///< fine steps: at this distance and beyond, lambda is 0
  std::int32_t shift = 0;  ///< of distances, so that band fits 15 bits
  std::int32_t band = 1;   ///< 1..32767: (end - start) >> shift
  std::int32_t finer = 0;  ///< finest level - level
};

/// Of a level above 0 that is drawn, that is, D_{level-1} > 0.
MorphBand morph_band(const Radii& radii, int level, const Metric& metric);

/// lambda times 2^15: 0 at the parent, 32768 at the vertex itself.
inline std::int32_t morph_weight(std::int32_t distance, const MorphBand& m) {
  const std::int32_t t = std::clamp((m.end - distance) >> m.shift, 0, m.band);
  return (t << 15) / m.band;
}

/// One coordinate of parent + lambda (own - parent), seen from the eye. own: steps of the vertex's
/// level; parent: of the level above; weight: 0..32768, both of which give the ends exactly.
/// Rounded down to fine steps, or to 2^-15 of the vertex's own where those are coarser.
inline std::int32_t morph_coordinate(std::int32_t own, std::int32_t parent, std::int32_t eye,
                                     std::int32_t weight, int finer) {
  const std::int32_t way = own - (parent << 1);
  // way * weight has up to 46 bits: its high 31 in `whole` and `low`, 15 bits of fraction below.
  const std::int32_t low = (way & 32767) * weight;
  const std::int32_t whole = (way >> 15) * weight + (low >> 15);
  const int bits = std::min(finer, 15);
  const std::int32_t fraction = (low & 32767) >> (15 - bits);
  return (((parent << 1) + whole) << finer) + (fraction << (finer - bits)) - eye;
}

/// Where a vertex is drawn, seen from the eye.
inline FinePoint morphed(LatticePoint own, LatticePoint parent, FinePoint eye, std::int32_t slab,
                         Partition partition, const MorphBand& m) {
  const std::int32_t distance = eye_distance(seen_from(eye, own, m.finer), slab, partition);
  const std::int32_t weight = morph_weight(distance, m);
  return {morph_coordinate(own.x, parent.x, eye.x, weight, m.finer),
          morph_coordinate(own.y, parent.y, eye.y, weight, m.finer),
          morph_coordinate(own.z, parent.z, eye.z, weight, m.finer)};
}

}  // namespace cornice::hlod
