// SPDX-License-Identifier: GPL-3.0-or-later
// One level of the solver: its bricks, which of their nodes are unknowns, and the values there.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/vec.h"
#include "stages/poisson/closed_brick.h"
#include "stages/poisson/samples.h"

namespace cornice::poisson {

/// Rows of 8 nodes along x in a brick; row y + 8 z.
inline constexpr int kBrickRows = 64;

/// One bit for each node of a row, lowest x first.
using RowMasks = std::array<std::uint8_t, kBrickRows>;

/// Where the 27 bricks around a brick, itself included, lie in their array: x fastest.
using Neighbours = std::array<std::uint32_t, 27>;
inline constexpr int kItself = 13;

/// Box of bricks, ends inclusive.
struct BrickBox {
  BrickKey first, last;
};

/// A level's nodes. Those that are unknown are `active`; every neighbour of an active node is
/// stored, and the nodes that are not active keep what the coarser level says.
struct Grid {
  std::vector<BrickKey> bricks;  ///< sorted
  BrickIndex index;
  std::vector<Neighbours> neighbours;
  std::vector<RowMasks> active;
  std::vector<float> values;       ///< the field, 512 a brick
  std::vector<float> constraints;  ///< right-hand side, over the spacing; 512 a brick
  /// What the equations are solved for while finer levels take part (composite.h); over the
  /// spacing, 512 a brick.
  std::vector<float> right_side;
  bool whole = false;  ///< covers the whole domain: reflecting border, every node active
};

/// Unknowns around the dense samples of a level.
Grid make_band(const SampleLevel& samples, int threads);

/// All nodes of a box. `box` is not empty.
Grid make_whole(const BrickBox& box, int threads);

/// What neighbours a brick has, from the index.
std::vector<Neighbours> find_neighbours(std::span<const BrickKey> bricks, const BrickIndex& index,
                                        int threads);

/// Number of active nodes.
std::uint64_t count_active(const Grid& grid);

/// True for the nodes of a brick (0 .. 511) that the next coarser level has, too.
constexpr bool is_even(int node) { return (node & 0111) == 0; }

/// Sets all values to the interpolation of the coarser levels: coarser[0] is the next one.
void prolong(Grid& grid, std::span<const LevelView> coarser, int threads);

/// The same, but adds it to what the nodes hold that are not even.
void prolong_below_details(Grid& grid, std::span<const LevelView> coarser, int threads);

}  // namespace cornice::poisson
