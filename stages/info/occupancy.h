// SPDX-License-Identifier: GPL-3.0-or-later
// How much ground points cover: square cells that hold at least one of them.
#pragma once

#include <cstdint>
#include <unordered_map>

namespace cornice::info {

/// Counts occupied cells at every power-of-two multiple of a smallest cell.
class Occupancy {
 public:
  /// cell: side of the smallest cells, in the unit of the coordinates.
  explicit Occupancy(double cell) : cell_(cell) {}
  void add(double x, double y);

  struct Cover {
    double cell = 0.0;  ///< side
    std::uint64_t cells = 0;
  };
  /// The finest cells that hold `points_per_cell` points on average (cells of few points would say
  /// more about themselves than about the ground); the coarsest where there are too few points.
  Cover cover(double points_per_cell) const;

 private:
  void coarsen();

  double cell_;
  std::uint64_t points_ = 0;
  // 8 x 8 cells a block, one bit each; most points fall into the block of the one before.
  std::unordered_map<std::uint64_t, std::uint64_t> blocks_;
  std::uint64_t latest_key_ = 0;
  std::uint64_t* latest_ = nullptr;
};

}  // namespace cornice::info
