// SPDX-License-Identifier: GPL-3.0-or-later
// Height mismatch of overlapping flight lines: median height difference over smooth ground cells
// that both have seen.
#pragma once

#include <cstdint>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/base/vec.h"
#include "core/points/flight_line.h"
#include "core/points/point_cloud.h"
#include "stages/flightlines/pulse_bins.h"

namespace cornice::flightlines {

/// Points of one key within some seconds: never two passes over one place.
struct SheetKey {
  LineKey key;
  std::int64_t slot = 0;  ///< floor(time / kSheetSeconds)
  friend auto operator<=>(const SheetKey&, const SheetKey&) = default;
};
inline constexpr double kSheetSeconds = 16.0;

/// Differences (second minus first) in centimetres and their counts.
using DifferenceCounts = std::map<std::int16_t, std::uint32_t>;
using SheetPairs = std::map<std::pair<SheetKey, SheetKey>, DifferenceCounts>;

/// Grids the lowest returns of one tile line by line. Memory grows with the area seen, not with the
/// points: some 12 bytes a cell and line.
class TileOverlap {
 public:
  /// `corner`: of the tile, metres; `points_per_m2`: of all lines, sets the cell size.
  TileOverlap(Vec3d corner, double points_per_m2);
  void add(const PointCloud& points, double metres = 1.0, double metres_up = 1.0);
  /// Differences of every pair of sheets of different passes that share smooth cells.
  SheetPairs finish() const;
  double cell_m() const { return cell_m_; }

 private:
  static constexpr int kBlock = 32;  ///< cells along the side of a block
  struct Cell {
    float sum = 0.0f;
    float squares = 0.0f;
    std::uint32_t count = 0;
  };
  struct Block {
    std::vector<Cell> cells = std::vector<Cell>(kBlock * kBlock);
  };
  using Sheet = std::unordered_map<std::uint64_t, Block>;

  Vec3d corner_;
  double cell_m_;
  std::map<SheetKey, Sheet> sheets_;
};

void merge_pairs(SheetPairs& whole, const SheetPairs& part);

/// Two lines that overlap.
struct OverlapPair {
  std::uint32_t first_line = 0;
  std::uint32_t second_line = 0;
  double median_dz_m = 0.0;  ///< second minus first
  double spread_m = 0.0;     ///< 1.4826 x median absolute deviation of the cells
  std::uint64_t cells = 0;
};

/// Sums sheet pairs up by line (channels told apart by user data alone are none: their pairs are
/// left out); pairs of fewer than `least_cells` cells are left out. Sorted by ids.
std::vector<OverlapPair> overlaps_of_lines(const SheetPairs& pairs, const FlightLines& lines,
                                           std::uint64_t least_cells = 20);

}  // namespace cornice::flightlines
