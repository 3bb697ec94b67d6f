// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/las_chunks.h"

#include <algorithm>
#include <optional>

#include "core/io/laz_chunk_table.h"
#include "core/io/little_endian.h"

namespace cornice {
namespace {

/// Records of uncompressed files that are handed to one thread at a time.
constexpr std::uint64_t kLasChunkPoints = 50000;

std::string text(std::uint64_t value) { return std::to_string(value); }

void plan_las(const LasInfo& info, ChunkPlan& plan) {
  const std::uint64_t bytes = info.point_data_end - info.point_data_offset;
  const std::uint64_t there = bytes / info.record_bytes;
  if (info.point_count > there) {
    plan.problem = "is cut short: the header announces " + text(info.point_count) +
                   " points, the file has room for " + text(there) + " records of " +
                   text(info.record_bytes) + " bytes from byte " + text(info.point_data_offset) +
                   " on; download or copy it again";
  }
  const std::uint64_t points = std::min(info.point_count, there);
  for (std::uint64_t first = 0; first < points; first += kLasChunkPoints) {
    const std::uint64_t count = std::min(kLasChunkPoints, points - first);
    plan.chunks.push_back({info.point_data_offset + first * info.record_bytes,
                           count * info.record_bytes, first, count});
  }
}

/// Where the chunk table begins; nothing (and a problem) where the file does not have it.
std::optional<std::uint64_t> find_table(ByteSource& source, const LasInfo& info, ChunkPlan& plan) {
  const std::uint64_t start = info.point_data_offset;
  const std::vector<std::uint8_t> pointer = read_bytes(source, start, 8);
  if (pointer.size() < 8) {
    plan.problem = "ends at byte " + text(source.size()) +
                   " before its first point; download or copy it again";
    return std::nullopt;
  }
  auto table = load_le<std::uint64_t>(pointer, 0);
  if (table == ~0ull) {  // written to a pipe: the pointer stands at the very end
    const std::vector<std::uint8_t> last = read_bytes(source, source.size() - 8, 8);
    table = load_le<std::uint64_t>(last, 0);
  }
  if (table == start) {
    plan.problem = "has no chunk table (byte " + text(start) +
                   "): its writer was interrupted; make it anew or download it again";
    return std::nullopt;
  }
  if (table < start + 8 || table > source.size() || source.size() - table < 8) {
    plan.problem = "is cut short: its chunk table should stand at byte " + text(table) +
                   ", the file has " + text(source.size()) + " bytes; download or copy it again";
    return std::nullopt;
  }
  return table;
}

/// The chunks of the table with the points of each, checked; a problem where they cannot be.
void plan_from_table(const std::vector<LazChunk>& table, const LasInfo& info,
                     std::uint64_t table_offset, ChunkPlan& plan) {
  const bool variable = plan.laz.chunk_points == LazVlr::kVariableChunks;
  PointChunk chunk{info.point_data_offset + 8, 0, 0, 0};
  for (const LazChunk& entry : table) {
    chunk.bytes = entry.bytes;
    chunk.points = std::min<std::uint64_t>(variable ? entry.points : plan.laz.chunk_points,
                                           info.point_count - chunk.first);
    if (chunk.points == 0) break;
    const bool fits = chunk.bytes <= table_offset - chunk.offset;
    if (!fits || chunk.bytes < info.record_bytes) {
      plan.problem = "has a damaged chunk table at byte " + text(table_offset) + ": chunk " +
                     text(plan.chunks.size()) + " cannot have " + text(chunk.bytes) +
                     " bytes; download or copy it again";
      return;
    }
    plan.chunks.push_back(chunk);
    chunk.offset += chunk.bytes;
    chunk.first += chunk.points;
  }
  if (chunk.first < info.point_count) {
    plan.problem = "is cut short: the header announces " + text(info.point_count) +
                   " points, its chunk table at byte " + text(table_offset) + " has " +
                   text(chunk.first) + "; download or copy it again";
  }
}

/// Layered chunks say themselves how long they are, so they can be found without a table.
void plan_by_walking(ByteSource& source, const LasInfo& info, ChunkPlan& plan) {
  const std::size_t head_bytes = layered_head_bytes(plan.laz);
  PointChunk chunk{info.point_data_offset + 8, 0, 0, 0};
  while (chunk.first < info.point_count && chunk.offset < info.point_data_end) {
    const auto head = read_layered_head(plan.laz, read_bytes(source, chunk.offset, head_bytes));
    const std::uint64_t left = info.point_data_end - chunk.offset;
    if (!head || head->points == 0 || head->chunk_bytes > left) return;
    chunk.bytes = head->chunk_bytes;
    chunk.points = std::min<std::uint64_t>(head->points, info.point_count - chunk.first);
    plan.chunks.push_back(chunk);
    chunk.offset += chunk.bytes;
    chunk.first += chunk.points;
  }
}

void plan_chunked(ByteSource& source, const LasInfo& info, ChunkPlan& plan) {
  const bool variable = plan.laz.chunk_points == LazVlr::kVariableChunks;
  if (const std::optional<std::uint64_t> table_offset = find_table(source, info, plan)) {
    // No chunk is smaller than its first record, which is stored as it is.
    const std::uint64_t most = (*table_offset - info.point_data_offset - 8) / info.record_bytes;
    // An entry is coded in at most 2 x 6 bytes.
    const std::uint64_t room =
        std::min<std::uint64_t>(source.size() - *table_offset, 64 + 12 * most);
    const auto table =
        decode_chunk_table(read_bytes(source, *table_offset, static_cast<std::size_t>(room)),
                           variable, static_cast<std::size_t>(most));
    if (table) return plan_from_table(*table, info, *table_offset, plan);
    plan.problem =
        "has a damaged chunk table at byte " + text(*table_offset) + "; download or copy it again";
  }
  if (plan.laz.compressor == LazVlr::kLayered) return plan_by_walking(source, info, plan);
  // Pointwise chunks of one size can still be decoded one behind the other.
  const std::uint64_t start = info.point_data_offset + 8;
  if (variable || start >= info.point_data_end) return;
  plan.one_stream = true;
  plan.chunks.push_back({start, info.point_data_end - start, 0, info.point_count});
}

}  // namespace

ChunkPlan plan_chunks(ByteSource& source, const LasInfo& info) {
  ChunkPlan plan;
  if (info.container != LasContainer::kLas) plan.laz = parse_laz_vlr(info, info.path.string());
  if (info.point_count == 0) return plan;
  if (plan.laz.compressor == LazVlr::kNone) {
    plan_las(info, plan);
  } else if (plan.laz.has_chunks()) {
    plan_chunked(source, info, plan);
  } else {
    plan.one_stream = true;
    plan.chunks.push_back({info.point_data_offset, info.point_data_end - info.point_data_offset, 0,
                           info.point_count});
  }
  return plan;
}

}  // namespace cornice
