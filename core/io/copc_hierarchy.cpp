// SPDX-License-Identifier: GPL-3.0-or-later
// Source: COPC specification 1.0 (copc.io), sections "info VLR" and "hierarchy VLR".
#include "core/io/copc_hierarchy.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <vector>

#include "core/io/las_header.h"
#include "core/io/little_endian.h"

namespace cornice {
namespace {

constexpr std::size_t kInfoBytes = 160;
constexpr std::size_t kEntryBytes = 32;

struct Page {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
};

/// The part of the info record that places the octree.
struct CopcInfo {
  Vec3d center;
  double half_size = 0.0;
  Page root;
};

struct Node {
  std::int32_t level = 0;
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
  std::uint64_t points = 0;
};

std::optional<CopcInfo> parse_copc_info(const LasInfo& info) {
  const LasVlr* vlr = find_vlr(info, "copc", 1);
  if (vlr == nullptr || vlr->data.size() < kInfoBytes) return std::nullopt;
  const std::span<const std::uint8_t> bytes(vlr->data);
  CopcInfo copc;
  copc.center = {load_le<double>(bytes, 0), load_le<double>(bytes, 8), load_le<double>(bytes, 16)};
  copc.half_size = load_le<double>(bytes, 24);
  copc.root = {load_le<std::uint64_t>(bytes, 40), load_le<std::uint64_t>(bytes, 48)};
  const bool usable = std::isfinite(copc.center.x + copc.center.y) &&
                      std::isfinite(copc.half_size) && copc.half_size > 0;
  return usable ? std::optional(copc) : std::nullopt;
}

/// All nodes with points; nothing where a page is not in the file. `most` bounds pages and nodes,
/// so that pages that name each other in a circle come to an end.
std::optional<std::vector<Node>> read_nodes(ByteSource& source, Page root, std::size_t most) {
  std::vector<Page> pages{root};
  std::vector<Node> nodes;
  std::size_t entries = 0;
  for (std::size_t p = 0; p < pages.size(); ++p) {
    const Page page = pages[p];
    if (page.bytes > source.size() || page.offset > source.size() - page.bytes) return std::nullopt;
    entries += static_cast<std::size_t>(page.bytes / kEntryBytes) + 1;
    if (entries > most) return std::nullopt;
    const std::vector<std::uint8_t> bytes =
        read_bytes(source, page.offset, static_cast<std::size_t>(page.bytes));
    for (std::size_t at = 0; at + kEntryBytes <= bytes.size(); at += kEntryBytes) {
      const auto offset = load_le<std::uint64_t>(bytes, at + 16);
      const auto size = load_le<std::int32_t>(bytes, at + 24);
      const auto count = load_le<std::int32_t>(bytes, at + 28);
      if (size < 0 || count < -1) return std::nullopt;
      if (count == -1) {  // the entry points to another page
        pages.push_back({offset, static_cast<std::uint64_t>(size)});
      } else if (count > 0) {
        nodes.push_back({load_le<std::int32_t>(bytes, at), load_le<std::int32_t>(bytes, at + 4),
                         load_le<std::int32_t>(bytes, at + 8), offset,
                         static_cast<std::uint64_t>(size), static_cast<std::uint64_t>(count)});
      }
    }
  }
  return nodes;
}

/// The node's square, grown by one step of the stored integers: rounding moves points that lie on
/// a node's face.
std::optional<Box2d> node_square(const Node& node, const CopcInfo& copc, const LasInfo& info) {
  if (node.level < 0 || node.level > 30) return std::nullopt;
  const double side = std::ldexp(2.0 * copc.half_size, -node.level);
  const double x = copc.center.x - copc.half_size + side * node.x;
  const double y = copc.center.y - copc.half_size + side * node.y;
  return Box2d{x, y, x + side, y + side}.grown(std::max(info.scale.x, info.scale.y));
}

}  // namespace

bool keep_copc_chunks_in(ByteSource& source, const LasInfo& info, const Box2d& window,
                         ChunkPlan& plan) {
  const std::optional<CopcInfo> copc = parse_copc_info(info);
  if (!copc) return false;
  const auto nodes = read_nodes(source, copc->root, 8 * plan.chunks.size() + 1024);
  if (!nodes || nodes->size() != plan.chunks.size()) return false;
  std::unordered_map<std::uint64_t, const Node*> by_offset;
  for (const Node& node : *nodes) by_offset.emplace(node.offset, &node);
  std::vector<PointChunk> inside;
  for (const PointChunk& chunk : plan.chunks) {
    const auto found = by_offset.find(chunk.offset);
    if (found == by_offset.end() || found->second->bytes != chunk.bytes ||
        found->second->points != chunk.points) {
      return false;
    }
    const std::optional<Box2d> square = node_square(*found->second, *copc, info);
    if (!square) return false;
    if (square->intersects(window)) inside.push_back(chunk);
  }
  plan.chunks = std::move(inside);
  return true;
}

}  // namespace cornice
