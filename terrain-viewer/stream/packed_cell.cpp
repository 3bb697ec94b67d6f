// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/stream/packed_cell.h"

#include <string>

#include "core/base/error.h"

namespace cornice::viewer {
namespace {

constexpr std::int64_t kPositionLimit = std::int64_t{1} << 21;

void pack_vertex(const hlod::CellVertex& v, hlod::LatticePoint origin, std::uint32_t parent,
                 std::uint32_t* words) {
  const std::int64_t x = std::int64_t{v.position.x} - origin.x;
  const std::int64_t y = std::int64_t{v.position.y} - origin.y;
  const std::int64_t z = std::int64_t{v.position.z} - origin.z;
  for (const std::int64_t value : {x, y, z})
    if (value < 0 || value >= kPositionLimit)
      throw InputError("cell", "has a position outside of its box; the file is damaged");
  const auto bits = static_cast<std::uint64_t>(x | (y << 21) | (z << 42));
  const auto half = [](std::int16_t value) {
    return static_cast<std::uint32_t>(static_cast<std::uint16_t>(value));
  };
  words[0] = static_cast<std::uint32_t>(bits);
  words[1] = static_cast<std::uint32_t>(bits >> 32);
  words[2] = half(v.normal[0]) | (half(v.normal[1]) << 16);
  words[3] = parent | (std::uint32_t{v.support} << 16);
  words[4] = std::uint32_t{v.colour[0]} | (std::uint32_t{v.colour[1]} << 8) |
             (std::uint32_t{v.colour[2]} << 16) | (std::uint32_t{v.source} << 24);
  words[5] = std::uint32_t{v.texture[0]} | (std::uint32_t{v.texture[1]} << 16);
}

}  // namespace

PackedCell pack_cell(const hlod::CellMesh& mesh, const hlod::Node& node, std::uint32_t row) {
  PackedCell cell;
  cell.node = row;
  cell.vertex_count = static_cast<std::uint32_t>(mesh.vertices.size());
  const bool is_root = mesh.parent_of.empty();
  const auto& parents = is_root ? mesh.vertices : mesh.parents;
  cell.words.resize((mesh.vertices.size() + parents.size()) * kWordsPerVertex);
  std::uint32_t* words = cell.words.data();
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i, words += kWordsPerVertex) {
    const auto parent = static_cast<std::uint32_t>(is_root ? i : mesh.parent_of[i]);
    pack_vertex(mesh.vertices[i], node.lowest, parent, words);
  }
  const hlod::LatticePoint origin = is_root ? node.lowest : parent_origin(node.lowest);
  for (const hlod::CellVertex& parent : parents) {
    pack_vertex(parent, origin, 0, words);
    words += kWordsPerVertex;
  }
  cell.indices.reserve(mesh.triangles.size() * 3);
  for (const auto& triangle : mesh.triangles)
    cell.indices.insert(cell.indices.end(), triangle.begin(), triangle.end());
  return cell;
}

}  // namespace cornice::viewer
