// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/flightlines/overlap.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace cornice::flightlines {
namespace {

constexpr std::uint32_t kLeastPoints = 3;
/// Cells rougher than this are vegetation, walls or slopes that sampling alone would tilt.
constexpr double kSmoothM = 0.10;
constexpr double kMostDifferenceM = 3.0;

/// True for points that may be ground and whose time is usable.
bool takes_part(const PointCloud& points, std::size_t i) {
  if (points.return_number[i] != points.return_count[i]) return false;
  if (points.classification[i] > 2) return false;
  if (points.flags[i] & (kSynthetic | kWithheld)) return false;
  if (points.gps_time_s.empty()) return false;
  const double t = points.gps_time_s[i];
  return std::isfinite(t) && t != 0.0 && std::abs(t) < 1e10;
}

struct CellMean {
  double mean = 0.0;
  bool is_smooth = false;
};

template <class Cell>
CellMean mean_of(const Cell& cell) {
  if (cell.count < kLeastPoints) return {};
  const double n = cell.count;
  const double mean = static_cast<double>(cell.sum) / n;
  const double variance = static_cast<double>(cell.squares) / n - mean * mean;
  return {mean, variance < kSmoothM * kSmoothM};
}

std::optional<std::size_t> line_of(const SheetKey& sheet, LineFinder& finder) {
  const double middle = (static_cast<double>(sheet.slot) + 0.5) * kSheetSeconds;
  return finder.find(sheet.key.id, sheet.key.channel, middle);
}

/// Value below which half of the counts lie.
double median_of(const std::map<int, std::uint64_t>& counts, std::uint64_t total) {
  std::uint64_t below = 0;
  for (const auto& [value, count] : counts) {
    below += count;
    if (below * 2 >= total) return value;
  }
  return 0.0;
}

}  // namespace

TileOverlap::TileOverlap(Vec3d corner, double points_per_m2)
    : corner_(corner),
      cell_m_(std::clamp(std::sqrt(12.0 / std::max(points_per_m2, 1e-3)), 1.0, 10.0)) {}

void TileOverlap::add(const PointCloud& points, double metres, double metres_up) {
  const Vec3d shift{points.origin.x * metres - corner_.x, points.origin.y * metres - corner_.y,
                    points.origin.z * metres_up - corner_.z};
  const double to_cell = 1.0 / cell_m_;
  SheetKey last_key;
  std::uint64_t last_block = 0;
  Sheet* sheet = nullptr;
  Block* block = nullptr;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!takes_part(points, i)) continue;
    const SheetKey key{{points.point_source_id[i], points.scanner_channel[i], 0},
                       floor_of(points.gps_time_s[i] / kSheetSeconds)};
    const double x = (static_cast<double>(points.positions[i].x) * metres + shift.x) * to_cell;
    const double y = (static_cast<double>(points.positions[i].y) * metres + shift.y) * to_cell;
    const std::int64_t column = floor_of(x);
    const std::int64_t row = floor_of(y);
    // Floor division by the block size; two's complement shifts do it for negatives too.
    const auto code = (static_cast<std::uint64_t>(static_cast<std::uint32_t>(column >> 5)) << 32) |
                      static_cast<std::uint32_t>(row >> 5);
    if (sheet == nullptr || !(key == last_key)) {
      sheet = &sheets_[key];
      last_key = key;
      block = nullptr;
    }
    if (block == nullptr || code != last_block) {
      block = &(*sheet)[code];
      last_block = code;
    }
    Cell& cell = block->cells[static_cast<std::size_t>((row & 31) * kBlock + (column & 31))];
    const double z = static_cast<double>(points.positions[i].z) * metres_up + shift.z;
    cell.sum += static_cast<float>(z);
    cell.squares += static_cast<float>(z * z);
    ++cell.count;
  }
}

SheetPairs TileOverlap::finish() const {
  SheetPairs pairs;
  for (auto a = sheets_.begin(); a != sheets_.end(); ++a) {
    for (auto b = std::next(a); b != sheets_.end(); ++b) {
      // Next to each other in time and of one key: the same pass cut in two.
      if (a->first.key == b->first.key && b->first.slot - a->first.slot <= 1) continue;
      DifferenceCounts counts;
      for (const auto& [code, block] : a->second) {
        const auto found = b->second.find(code);
        if (found == b->second.end()) continue;
        for (std::size_t i = 0; i < block.cells.size(); ++i) {
          const CellMean first = mean_of(block.cells[i]);
          const CellMean second = mean_of(found->second.cells[i]);
          const double dz = second.mean - first.mean;
          if (first.is_smooth && second.is_smooth && std::abs(dz) < kMostDifferenceM)
            ++counts[static_cast<std::int16_t>(std::lround(dz * 100.0))];
        }
      }
      if (!counts.empty()) pairs[{a->first, b->first}] = std::move(counts);
    }
  }
  return pairs;
}

void merge_pairs(SheetPairs& whole, const SheetPairs& part) {
  for (const auto& [key, counts] : part)
    for (const auto& [difference, count] : counts) whole[key][difference] += count;
}

std::vector<OverlapPair> overlaps_of_lines(const SheetPairs& pairs, const FlightLines& lines,
                                           std::uint64_t least_cells) {
  LineFinder finder(lines, kSheetSeconds);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::map<int, std::uint64_t>> by_line;
  for (const auto& [key, counts] : pairs) {
    const auto first = line_of(key.first, finder);
    const auto second = line_of(key.second, finder);
    if (!first || !second || *first == *second) continue;
    std::uint32_t id_a = lines.lines[*first].id, id_b = lines.lines[*second].id;
    const int sign = id_a < id_b ? 1 : -1;
    if (sign < 0) std::swap(id_a, id_b);
    auto& sums = by_line[{id_a, id_b}];
    for (const auto& [difference, count] : counts) sums[sign * difference] += count;
  }
  std::vector<OverlapPair> result;
  for (const auto& [ids, counts] : by_line) {
    OverlapPair pair;
    pair.first_line = ids.first;
    pair.second_line = ids.second;
    for (const auto& [difference, count] : counts) pair.cells += count;
    if (pair.cells < least_cells) continue;
    const double median = median_of(counts, pair.cells);
    std::map<int, std::uint64_t> deviations;
    for (const auto& [difference, count] : counts)
      deviations[static_cast<int>(std::abs(difference - median))] += count;
    pair.median_dz_m = median / 100.0;
    pair.spread_m = 1.4826 * median_of(deviations, pair.cells) / 100.0;
    result.push_back(pair);
  }
  return result;
}

}  // namespace cornice::flightlines
