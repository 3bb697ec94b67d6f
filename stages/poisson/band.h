// SPDX-License-Identifier: GPL-3.0-or-later
// Fields of neighbouring tiles blended across their borders, so that all tiles that meet on a
// border plane compute the same numbers there.
//
//        tile A          |          tile B         Weight of A along x. Ramps of two tiles that
//   1 ________           |                         share a plane add up to 1. The weight of a tile
//             `-._       |                         is the product of its four ramps. On either side
//                 `-.    |                         of the plane both tiles' fields are evaluated:
//                    `-. |                         A needs B's in a band along the border, and B
//                       `|-.                       A's.
//   0                    |  `-._________
//            -ramp       0       ramp
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/vec.h"
#include "stages/poisson/extract.h"
#include "stages/poisson/field.h"

namespace cornice {

/// The narrowest ramp, in nodes.
inline constexpr std::int32_t kLeastRamp = 4;

/// The part of a field that lies along the borders of its tile, or a whole field.
struct TileField {
  Field field;
  LatticeBox tile;         ///< the cells that the tile owns
  std::int32_t ramp = 16;  ///< nodes from the border to where the neighbour counts for nothing
  std::string crs_text;    ///< as Crs::text()
  bool is_band = false;
  /// Nodes between which the field means something: the heights of the points and some room. Coarse
  /// bricks reach far beyond, with whatever sign.
  std::int32_t z0 = kLowestNode, z1 = kHighestNode;
};

/// Tiles lie within so many lattice steps of 0.
inline constexpr std::int32_t kFarthestTileNode = 1 << 27;

/// The lattice planes next to the tile's borders. Tiles with a common border get the same plane.
/// Throws UsageError where the tile is thinner than a step or farther than 2^27 steps from 0.
LatticeBox lattice_box(const Box2d& tile, const Lattice& lattice);
Box2d box_in_metres(const LatticeBox& box, const Lattice& lattice);

/// What other tiles need of a field to extract theirs: its bricks, on all levels, within `ramp` of
/// the tile's borders on either side, and those behind them that closed_brick() reads there. In
/// that region closed_brick() gives the same bits as the whole field.
TileField make_band(const TileField& whole);

/// The field of a tile, blended with those of its neighbours near its borders.
/// A node's value is the mean of the fields that are known there, weighted by smooth ramps that
/// depend on plan position and tile boxes alone, summed as doubles in the order of the boxes: the
/// same bits in every tile that has the same set of tiles around the node. So all tiles of a survey
/// must be given the same set, restricted to those that touch them: a tile that is missing must be
/// missing for all.
/// Thread contract: const members may be called from many threads.
class BlendedValues : public NodeValues {
 public:
  /// `own` and `neighbours` must outlive this. Neighbours too far away to matter are left out.
  /// Throws InputError where lattice, ramp or CRS differ or tiles overlap; `names` (own first, then
  /// one per neighbour) are for the messages.
  BlendedValues(const TileField& own, std::span<const TileField> neighbours,
                std::span<const std::string> names);

  const float* stored(BrickKey brick) const override;
  bool compute(BrickKey brick, std::span<float, kBrickNodes> values) const override;
  std::vector<BrickKey> crossing_bricks(BrickKey first, BrickKey last, int threads) const override;

  /// The tiles that take part, the own among them, in their order.
  std::vector<LatticeBox> tiles() const;

 private:
  struct Part {
    const TileField* tile;
    FieldValues values;
  };

  double ramp_at(std::int32_t inside) const;
  bool is_plain(BrickKey brick) const;
  void add(const Part& part, BrickKey brick, std::span<double, kBrickNodes> sums,
           std::span<double, kBrickNodes> weights, std::span<float, kBrickNodes> single) const;

  std::vector<Part> parts_;  ///< sorted by box
  std::size_t own_ = 0;
  std::vector<double> ramp_;  ///< by nodes inside the border + ramp, 0 .. 2 ramp
};

}  // namespace cornice
