// SPDX-License-Identifier: GPL-3.0-or-later
// Source: COPC specification 1.0 (copc.io). LASzip cannot end a chunk by hand, so every node is
// compressed as a small LAZ stream of its own in memory, and its one chunk is taken out.
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/io/copc_octree.h"
#include "core/io/las.h"
#include "core/io/las_head_writer.h"
#include "core/io/las_header.h"
#include "core/io/laszip_encoder.h"
#include "core/io/lax_writer.h"
#include "core/io/laz_chunk_table.h"
#include "core/io/little_endian.h"
#include "core/io/output_stream.h"

namespace cornice {
namespace {

constexpr std::size_t kInfoBytes = 160;
constexpr std::size_t kEntryBytes = 32;
constexpr std::size_t kChunkTablePointer = 8;
/// Nodes compressed before the next ones are: bounds the memory for finished chunks.
constexpr std::size_t kBatch = 64;

constexpr std::uint32_t kNeverReached = std::numeric_limits<std::uint32_t>::max() - 1;

/// A compressed node.
struct Chunk {
  std::string bytes;
  LasTally tally;
};

/// Where a node stands in the file.
struct Place {
  std::uint64_t offset = 0;
  std::uint32_t bytes = 0;
};

LasWriteOptions copc_options(const LasWriteOptions& asked) {
  LasWriteOptions options = asked;
  options.version_minor = 4;
  options.compress = true;
  if (options.point_format < 6 || options.point_format > 8) {
    throw UsageError("point format",
                     std::to_string(options.point_format) + " cannot be COPC; 6, 7 and 8 can");
  }
  check_las_write_options(options);
  // LASzip's mark of chunks of varying size; it then never ends a chunk by itself.
  options.chunk_points = std::numeric_limits<std::uint32_t>::max();
  return options;
}

Chunk compress(const PointCloud& points, const CopcNode& node, const LasWriteOptions& options,
               const std::string& name) {
  Chunk chunk;
  if (node.points.empty()) return chunk;
  std::ostringstream stream(std::ios::binary);
  // A fixed size that no node reaches: with chunks of varying size LASzip 3.5 loses 4 KiB a writer.
  LasWriteOptions one_chunk = options;
  one_chunk.chunk_points = kNeverReached;
  LaszipEncoder encoder(stream, one_chunk, name);
  encoder.write(points, 0, node.points.size(), chunk.tally, node.points.data());
  encoder.finish();
  std::string bytes = std::move(stream).str();
  // The stream: offset of the chunk table, the chunk, the table.
  std::uint64_t table_at = 0;
  std::copy_n(bytes.data(), kChunkTablePointer, reinterpret_cast<char*>(&table_at));
  if (table_at < kChunkTablePointer || table_at > bytes.size()) {
    throw RunError(name, "LASzip placed a chunk table outside its stream");
  }
  if (table_at > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max())) {
    throw InputError(name,
                     "a node of the octree takes more than 2 GiB, which COPC cannot hold; "
                     "are there millions of points at one place?");
  }
  chunk.bytes = bytes.substr(kChunkTablePointer, table_at - kChunkTablePointer);
  return chunk;
}

/// The info record: cube, spacing, place of the hierarchy, span of GPS times.
std::vector<std::uint8_t> info_record(const CopcCube& cube, std::uint64_t hierarchy_at,
                                      std::uint64_t hierarchy_bytes,
                                      const std::vector<double>& gps_times) {
  double first = std::numeric_limits<double>::infinity();
  double last = -first;
  for (const double time : gps_times) {
    if (!std::isfinite(time)) continue;
    first = std::min(first, time);
    last = std::max(last, time);
  }
  const double half = cube.side / 2.0;
  std::vector<std::uint8_t> bytes;
  append_le(bytes, cube.min.x + half);
  append_le(bytes, cube.min.y + half);
  append_le(bytes, cube.min.z + half);
  append_le(bytes, half);
  append_le(bytes, cube.side / kCopcGrid);
  append_le(bytes, hierarchy_at);
  append_le(bytes, hierarchy_bytes);
  append_le(bytes, first <= last ? first : 0.0);
  append_le(bytes, first <= last ? last : 0.0);
  bytes.resize(kInfoBytes, 0);
  return bytes;
}

/// One page with all nodes.
std::vector<std::uint8_t> hierarchy_record(const std::vector<CopcNode>& nodes,
                                           const std::vector<Place>& places) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(nodes.size() * kEntryBytes);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    append_le(bytes, nodes[i].level);
    append_le(bytes, nodes[i].key.x);
    append_le(bytes, nodes[i].key.y);
    append_le(bytes, nodes[i].key.z);
    append_le(bytes, places[i].offset);
    append_le(bytes, places[i].bytes);
    append_le(bytes, static_cast<std::int32_t>(nodes[i].points.size()));
  }
  return bytes;
}

/// The points' stored integers; those given, or those that `rounded` is filled with.
const std::vector<Vec3<std::int32_t>>& stored_points(const PointCloud& points,
                                                     const LasWriteOptions& options,
                                                     const std::string& name,
                                                     std::vector<Vec3<std::int32_t>>& rounded) {
  if (!points.exact.empty()) return points.exact;
  rounded.resize(points.size());
  parallel_for(points.size(), 100000, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      rounded[i] = stored_coordinates(points, i, options, name);
    }
  });
  return rounded;
}

/// Compresses the nodes on several threads and writes them in order.
struct NodeWriter {
  const PointCloud& points;
  const LasWriteOptions& options;
  OutputStream& file;
  Progress& progress;
  std::uint64_t position;
  LasTally tally;
  std::vector<Place> places;
  std::vector<LazChunk> chunks;

  void write(const std::vector<CopcNode>& nodes) {
    for (std::size_t first = 0; first < nodes.size(); first += kBatch) {
      check_cancelled(progress);
      const std::size_t count = std::min(kBatch, nodes.size() - first);
      std::vector<Chunk> batch(count);
      parallel_for(count, 1, options.threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          batch[k] = compress(points, nodes[first + k], options, file.name());
        }
      });
      for (std::size_t k = 0; k < count; ++k) append(batch[k], nodes[first + k].points.size());
    }
  }

  void append(const Chunk& chunk, std::size_t count) {
    if (count == 0) {
      places.push_back({});
      return;
    }
    const auto bytes = static_cast<std::uint32_t>(chunk.bytes.size());
    file.put({reinterpret_cast<const std::uint8_t*>(chunk.bytes.data()), chunk.bytes.size()});
    places.push_back({position, bytes});
    chunks.push_back({static_cast<std::uint32_t>(count), bytes});
    position += bytes;
    tally.add(chunk.tally);
    progress.advance(count);
  }
};

}  // namespace

void write_copc(const std::filesystem::path& path, const PointCloud& points,
                const LasWriteOptions& asked, Progress& progress,
                std::vector<std::uint64_t>* order) {
  const LasWriteOptions options = copc_options(asked);
  if (points.size() > std::numeric_limits<std::uint32_t>::max()) {
    throw InputError(path.string(), "more than 4294967295 points; write several files");
  }
  std::vector<Vec3<std::int32_t>> rounded;
  const std::string name = path.string();
  const auto& stored = stored_points(points, options, name, rounded);
  const CopcCube cube = copc_cube(stored, options.scale, options.offset);
  progress.begin("octree", 0);
  const std::vector<CopcNode> nodes = build_copc_octree(
      stored, options.scale, options.offset, cube, asked.chunk_points, options.threads, progress);
  progress.end();

  LasHead head(options,
               {{"copc", 1, "COPC info VLR", std::vector<std::uint8_t>(kInfoBytes), false}},
               {laszip_record(options)});
  OutputStream file(path);
  file.put(head.bytes({}, 0));
  std::vector<std::uint8_t> table_pointer(kChunkTablePointer);
  file.put(table_pointer);

  progress.begin("compress", points.size());
  NodeWriter writer{points, options, file, progress, head.size() + kChunkTablePointer, {}, {}, {}};
  writer.write(nodes);
  progress.end();

  const std::uint64_t table_at = writer.position;
  const std::vector<std::uint8_t> table = encode_chunk_table(writer.chunks, true);
  file.put(table);
  const std::uint64_t extended_at = table_at + table.size();
  head.prepend_extended(
      {"copc", 1000, "EPT hierarchy", hierarchy_record(nodes, writer.places), true});
  file.put(head.extended_bytes());

  const std::uint64_t hierarchy_bytes = nodes.size() * kEntryBytes;
  file.seek(0);
  file.put(head.bytes(
      writer.tally, extended_at,
      info_record(cube, extended_at + kEvlrHeaderBytes, hierarchy_bytes, points.gps_time_s)));
  table_pointer.clear();
  append_le(table_pointer, table_at);
  file.put(table_pointer);
  remove_stale_lax(file.target());
  file.commit();
  if (order == nullptr) return;
  order->clear();
  for (const CopcNode& node : nodes) {
    order->insert(order->end(), node.points.begin(), node.points.end());
  }
}

}  // namespace cornice
