// SPDX-License-Identifier: GPL-3.0-or-later
// Spatial index beside a LAS or LAZ file (FILE.lax), as LASzip and LAStools read it: a quadtree of
// square cells over the plan, each with the intervals of the points that fall into it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/base/vec.h"

namespace cornice {

/// Collects the cells of points in file order. Memory grows with the cells, not with the points.
class LaxIndex {
 public:
  /// Cells of 8 units (metres, feet), or of 2^-13 degrees. Both are powers of two: cell borders are
  /// then exact in the format's floats, so reader and writer agree on every point.
  explicit LaxIndex(bool is_degrees) : cell_(is_degrees ? 0x1.0p-13 : 8.0) {}
  /// Adds the next point of the file. x, y as a reader computes them from the stored integers.
  void add(double x, double y);
  /// The file's bytes.
  std::string bytes() const;

 private:
  struct Interval {
    std::uint32_t first = 0;
    std::uint32_t last = 0;
  };
  struct Cell {
    std::uint32_t points = 0;
    std::vector<Interval> intervals;
  };

  /// In file order, those that nearly touch made one.
  static std::vector<Interval> joined(std::vector<Interval> intervals);

  double cell_;
  std::uint32_t points_ = 0;
  std::uint64_t latest_key_ = 0;
  Cell* latest_ = nullptr;  ///< most points fall into the cell of the one before
  std::unordered_map<std::uint64_t, Cell> cells_;
};

/// Where LASzip looks for the index of a file.
std::filesystem::path lax_path_of(const std::filesystem::path& las);

/// Removes the index of a file about to be replaced: it would lead to wrong points.
void remove_stale_lax(const std::filesystem::path& las);

}  // namespace cornice
