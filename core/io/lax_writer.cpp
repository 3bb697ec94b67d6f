// SPDX-License-Identifier: GPL-3.0-or-later
// File layout after LASzip 3.5 (Isenburg), which documents it by its reader alone:
//   "LASX" version, "LASS" kind, "LASQ" version levels 0 0 min_x max_x min_y max_y (floats),
//   "LASV" version cells { cell intervals points { first last } }, all 32 bits little-endian.
#include "core/io/lax_writer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <system_error>
#include <utility>

#include "core/io/little_endian.h"

namespace cornice {
namespace {

/// Points of other cells that an interval may span before a new one starts: decoding a few points
/// too many is cheaper than a seek within a LAZ chunk.
constexpr std::uint32_t kMostSkipped = 1000;
constexpr std::uint64_t kBias = std::uint64_t{1} << 31;

std::uint64_t key_of(std::int64_t column, std::int64_t row) {
  return (static_cast<std::uint64_t>(column + static_cast<std::int64_t>(kBias)) << 32) |
         static_cast<std::uint64_t>(row + static_cast<std::int64_t>(kBias));
}
std::int64_t column_of(std::uint64_t key) {
  return static_cast<std::int64_t>(key >> 32) - static_cast<std::int64_t>(kBias);
}
std::int64_t row_of(std::uint64_t key) {
  return static_cast<std::int64_t>(key & 0xffffffffu) - static_cast<std::int64_t>(kBias);
}

/// Number of a cell within its level: two bits a level, x in the lower one.
std::uint32_t interleaved(std::uint32_t column, std::uint32_t row) {
  std::uint32_t index = 0;
  for (unsigned bit = 0; bit < 16; ++bit) {
    index |= ((column >> bit) & 1u) << (2 * bit);
    index |= ((row >> bit) & 1u) << (2 * bit + 1);
  }
  return index;
}

/// Number of the first cell of a level: those of coarser levels come before.
std::uint32_t level_offset(unsigned level) {
  std::uint32_t offset = 0;
  for (unsigned l = 0; l < level; ++l) offset += 1u << (2 * l);
  return offset;
}

/// The quadtree's square: as many cells of one side, a power of two, as cover the points.
struct Grid {
  std::int64_t min_column = 0;
  std::int64_t min_row = 0;
  unsigned cell_levels = 0;  ///< 2^cell_levels cells a side
  unsigned coarser = 0;      ///< levels that the tree ends above the cells

  unsigned levels() const { return cell_levels - coarser; }
  std::uint32_t number(std::int64_t column, std::int64_t row) const {
    return level_offset(levels()) +
           interleaved(static_cast<std::uint32_t>((column - min_column) >> coarser),
                       static_cast<std::uint32_t>((row - min_row) >> coarser));
  }
};

/// Deepest tree whose cell numbers fit 32 bits with those of all coarser levels before them.
constexpr unsigned kMostLevels = 15;

template <class Cells>
Grid grid_of(const Cells& cells) {
  Grid grid;
  if (cells.empty()) return grid;
  grid.min_column = grid.min_row = std::numeric_limits<std::int64_t>::max();
  for (const auto& [key, cell] : cells) {
    grid.min_column = std::min(grid.min_column, column_of(key));
    grid.min_row = std::min(grid.min_row, row_of(key));
  }
  std::int64_t span = 1;
  for (const auto& [key, cell] : cells) {
    span = std::max({span, column_of(key) - grid.min_column + 1, row_of(key) - grid.min_row + 1});
  }
  grid.cell_levels = static_cast<unsigned>(std::bit_width(static_cast<std::uint64_t>(span - 1)));
  grid.coarser = grid.cell_levels > kMostLevels ? grid.cell_levels - kMostLevels : 0;
  return grid;
}

void put_head(std::string& out, const Grid& grid, double cell) {
  const double side = std::ldexp(cell, static_cast<int>(grid.cell_levels));
  const double min_x = static_cast<double>(grid.min_column) * cell;
  const double min_y = static_cast<double>(grid.min_row) * cell;
  out += "LASX";
  append_le(out, std::uint32_t{0});
  out += "LASS";
  append_le(out, std::uint32_t{0});  // kind: quadtree
  out += "LASQ";
  append_le(out, std::uint32_t{0});
  append_le(out, static_cast<std::uint32_t>(grid.levels()));
  append_le(out, std::uint32_t{0});  // index and levels of a tile within a larger tree: none
  append_le(out, std::uint32_t{0});
  for (double bound : {min_x, min_x + side, min_y, min_y + side}) {
    append_le(out, static_cast<float>(bound));
  }
}

}  // namespace

void LaxIndex::add(double x, double y) {
  const auto column = static_cast<std::int64_t>(std::floor(x / cell_));
  const auto row = static_cast<std::int64_t>(std::floor(y / cell_));
  const std::uint64_t key = key_of(column, row);
  if (latest_ == nullptr || key != latest_key_) {
    latest_ = &cells_[key];
    latest_key_ = key;
  }
  Cell& cell = *latest_;
  const std::uint32_t index = points_++;
  ++cell.points;
  if (!cell.intervals.empty() && index - cell.intervals.back().last <= kMostSkipped) {
    cell.intervals.back().last = index;
  } else {
    cell.intervals.push_back({index, index});
  }
}

std::string LaxIndex::bytes() const {
  const Grid grid = grid_of(cells_);
  // Ordered, so that the bytes do not depend on the hash table; coarser cells gather several.
  std::map<std::uint32_t, Cell> numbered;
  for (const auto& [key, cell] : cells_) {
    Cell& whole = numbered[grid.number(column_of(key), row_of(key))];
    whole.points += cell.points;
    whole.intervals.insert(whole.intervals.end(), cell.intervals.begin(), cell.intervals.end());
  }
  std::string out;
  put_head(out, grid, cell_);
  out += "LASV";
  append_le(out, std::uint32_t{0});
  append_le(out, static_cast<std::uint32_t>(numbered.size()));
  for (auto& [number, cell] : numbered) {
    const std::vector<Interval> intervals = joined(std::move(cell.intervals));
    append_le(out, number);
    append_le(out, static_cast<std::uint32_t>(intervals.size()));
    append_le(out, cell.points);
    for (const Interval& interval : intervals) {
      append_le(out, interval.first);
      append_le(out, interval.last);
    }
  }
  return out;
}

std::vector<LaxIndex::Interval> LaxIndex::joined(std::vector<Interval> intervals) {
  std::sort(intervals.begin(), intervals.end(),
            [](const Interval& a, const Interval& b) { return a.first < b.first; });
  std::vector<Interval> result;
  for (const Interval& interval : intervals) {
    if (!result.empty() && interval.first <= result.back().last + kMostSkipped) {
      result.back().last = std::max(result.back().last, interval.last);
    } else {
      result.push_back(interval);
    }
  }
  return result;
}

std::filesystem::path lax_path_of(const std::filesystem::path& las) {
  return std::filesystem::path(las).replace_extension(".lax");
}

void remove_stale_lax(const std::filesystem::path& las) {
  std::error_code ignored;
  std::filesystem::remove(lax_path_of(las), ignored);
}

}  // namespace cornice
