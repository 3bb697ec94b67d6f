// SPDX-License-Identifier: GPL-3.0-or-later
// File layout after LASzip 3.5 (Isenburg), see lax_writer.cpp.
#include "core/io/lax_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/base/error.h"
#include "core/io/byte_source.h"
#include "core/io/las_header.h"
#include "core/io/little_endian.h"

namespace cornice {
namespace {

constexpr std::size_t kCellsAt = 64;       // first cell, behind the quadtree's and the cells' heads
constexpr std::uint32_t kMostLevels = 15;  // cell numbers of deeper trees do not fit 32 bits
constexpr std::uint64_t kMostIndexBytes = 1ull << 30;

/// The square that the quadtree divides. Floats as in the file: with them LASzip decides in which
/// cell a point lies.
struct QuadTree {
  std::uint32_t levels = 0;
  float min_x = 0, max_x = 0, min_y = 0, max_y = 0;
};

std::optional<QuadTree> parse_head(std::span<const std::uint8_t> lax) {
  const auto has_tag = [&](std::size_t at, const char* tag) {
    return std::memcmp(lax.data() + at, tag, 4) == 0;
  };
  if (lax.size() < kCellsAt || !has_tag(0, "LASX") || !has_tag(8, "LASS") || !has_tag(16, "LASQ") ||
      !has_tag(52, "LASV")) {
    return std::nullopt;
  }
  // Kind 0 is a quadtree; one that is part of a larger tree numbers its cells differently.
  if (load_le<std::uint32_t>(lax, 12) != 0 || load_le<std::uint32_t>(lax, 32) != 0) {
    return std::nullopt;
  }
  const QuadTree tree{load_le<std::uint32_t>(lax, 24), load_le<float>(lax, 36),
                      load_le<float>(lax, 40), load_le<float>(lax, 44), load_le<float>(lax, 48)};
  const bool usable = tree.levels <= kMostLevels && tree.min_x <= tree.max_x &&
                      tree.min_y <= tree.max_y && std::isfinite(tree.min_x + tree.max_x) &&
                      std::isfinite(tree.min_y + tree.max_y);
  return usable ? std::optional(tree) : std::nullopt;
}

/// Where a cell's points can lie, half-open at the top; cells at the tree's border reach to
/// infinity, because points outside the square are put there. Nothing where the number is of no
/// cell.
std::optional<Box2d> cell_box(const QuadTree& tree, std::uint32_t number) {
  // Cells of coarser levels are numbered before those of finer ones.
  std::uint32_t level = 0;
  std::uint64_t first = 0;
  while (number >= first + (std::uint64_t{1} << (2 * level))) {
    first += std::uint64_t{1} << (2 * level);
    if (++level > tree.levels) return std::nullopt;
  }
  const std::uint64_t place = number - first;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Box2d box{-kInfinity, -kInfinity, kInfinity, kInfinity};
  float min_x = tree.min_x, max_x = tree.max_x, min_y = tree.min_y, max_y = tree.max_y;
  while (level-- > 0) {
    const std::uint64_t quarter = (place >> (2 * level)) & 3;
    const float middle_x = (min_x + max_x) / 2;
    const float middle_y = (min_y + max_y) / 2;
    ((quarter & 1) != 0 ? min_x : max_x) = middle_x;
    ((quarter & 1) != 0 ? box.min_x : box.max_x) = middle_x;
    ((quarter & 2) != 0 ? min_y : max_y) = middle_y;
    ((quarter & 2) != 0 ? box.min_y : box.max_y) = middle_y;
  }
  return box;
}

/// The index's bytes: FILE.lax, or the record that LAStools appends. Empty where there is none.
std::vector<std::uint8_t> read_index(const LasInfo& info) {
  std::filesystem::path path = info.path;
  path.replace_extension(".lax");
  std::error_code failure;
  const auto written = std::filesystem::last_write_time(path, failure);
  if (!failure && !info.zipped) {
    const auto points_written = std::filesystem::last_write_time(info.path, failure);
    if (failure || written < points_written) return {};
    const std::unique_ptr<ByteSource> source = open_point_file(path).bytes;
    if (source->size() > kMostIndexBytes) return {};
    return read_bytes(*source, 0, static_cast<std::size_t>(source->size()));
  }
  const LasVlr* record = find_vlr(info, "LAStools", 30);
  return record != nullptr ? record->data : std::vector<std::uint8_t>{};
}

}  // namespace

std::optional<std::vector<PointInterval>> lax_intervals_in(std::span<const std::uint8_t> lax,
                                                           const Box2d& window,
                                                           std::uint64_t point_count) {
  const std::optional<QuadTree> tree = parse_head(lax);
  if (!tree) return std::nullopt;
  const auto cells = load_le<std::uint32_t>(lax, 60);
  std::vector<PointInterval> found;
  std::uint64_t indexed = 0;
  std::size_t at = kCellsAt;
  for (std::uint32_t c = 0; c < cells; ++c) {
    if (lax.size() - at < 12) return std::nullopt;
    const std::optional<Box2d> box = cell_box(*tree, load_le<std::uint32_t>(lax, at));
    const std::uint64_t intervals = load_le<std::uint32_t>(lax, at + 4);
    indexed += load_le<std::uint32_t>(lax, at + 8);
    at += 12;
    if (!box || (lax.size() - at) / 8 < intervals) return std::nullopt;
    for (std::uint64_t i = 0; i < intervals; ++i, at += 8) {
      const PointInterval interval{load_le<std::uint32_t>(lax, at),
                                   load_le<std::uint32_t>(lax, at + 4)};
      if (interval.first > interval.last || interval.last >= point_count) return std::nullopt;
      if (box->intersects(window)) found.push_back(interval);
    }
  }
  // An index of other points would lose some of these in silence.
  return indexed == point_count ? std::optional(std::move(found)) : std::nullopt;
}

bool keep_lax_chunks_in(const LasInfo& info, const Box2d& window, ChunkPlan& plan) {
  if (plan.one_stream || plan.chunks.empty()) return false;
  auto intervals = lax_intervals_in(read_index(info), window, info.point_count);
  if (!intervals) return false;
  std::sort(intervals->begin(), intervals->end(),
            [](PointInterval a, PointInterval b) { return a.first < b.first; });
  std::vector<PointChunk> inside;
  std::uint64_t reach = 0;  // 1 + the last point of all intervals that begin before the chunk's end
  auto next = intervals->begin();
  for (const PointChunk& chunk : plan.chunks) {
    for (; next != intervals->end() && next->first < chunk.first + chunk.points; ++next) {
      reach = std::max<std::uint64_t>(reach, std::uint64_t{next->last} + 1);
    }
    if (reach > chunk.first) inside.push_back(chunk);
  }
  plan.chunks = std::move(inside);
  return true;
}

}  // namespace cornice
