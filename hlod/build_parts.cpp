// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/build_parts.h"

#include <algorithm>
#include <numeric>

namespace cornice::hlod {

void PartMaker::add_parts(const BuildCell& cell, std::span<const std::uint32_t> parents,
                          std::span<const CellVertex> parent_data,
                          std::vector<FinishedPart>& parts) {
  place_.resize(std::max(place_.size(), cell.vertices.size()));
  stamp_.resize(std::max(stamp_.size(), cell.vertices.size()), 0);
  parent_place_.resize(std::max(parent_place_.size(), parent_data.size()));
  parent_stamp_.resize(std::max(parent_stamp_.size(), parent_data.size()), 0);
  std::size_t begin = 0;
  std::uint16_t number = 0;
  while (begin < cell.triangles.size()) {
    FinishedPart part;
    part.mesh.key = cell.key;
    begin = take_part(cell, begin, part.mesh);
    if (!parents.empty()) add_parents(parents, parent_data, part.mesh);
    part.node = make_node(part.mesh, cell.error_m, cell.step_error_m);
    part.node.part = number++;
    parts.push_back(std::move(part));
  }
}

/// Takes a cell that is one part and has its vertices in the order of their first use, as most are.
/// False, and nothing said of what the mesh is then, where it is anything else.
bool PartMaker::take_whole(const BuildCell& cell, CellMesh& mesh) {
  const std::size_t count = cell.vertices.size();
  if (count + 3 > kCellVertexLimit || cell.triangles.size() > kCellTriangleLimit) return false;
  mesh.triangles.resize(cell.triangles.size());
  std::uint32_t used = 0;
  bool is_ordered = true;
  for (const Triangle& t : cell.triangles) {
    for (const std::uint32_t v : t) {
      is_ordered &= v <= used;
      used = std::max(used, v + 1);
    }
  }
  for (std::size_t t = 0; t < cell.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      mesh.triangles[t][k] = static_cast<std::uint16_t>(cell.triangles[t][k]);
    }
  }
  if (!is_ordered || used != count) return false;
  mesh.vertices = cell.vertices;
  vertex_.resize(count);
  std::iota(vertex_.begin(), vertex_.end(), 0u);
  return true;
}

/// Takes triangles from `begin` on until the part is full; returns where the next part begins.
std::size_t PartMaker::take_part(const BuildCell& cell, std::size_t begin, CellMesh& mesh) {
  ++part_;
  if (begin == 0 && take_whole(cell, mesh)) return cell.triangles.size();
  mesh.triangles.clear();
  vertex_.clear();
  const std::size_t last = std::min(cell.triangles.size(), begin + kCellTriangleLimit);
  mesh.triangles.reserve(last - begin);
  std::size_t t = begin;
  for (; t < last && vertex_.size() + 3 <= kCellVertexLimit; ++t) {
    std::array<std::uint16_t, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = cell.triangles[t][k];
      if (stamp_[v] != part_) {
        stamp_[v] = part_;
        place_[v] = static_cast<std::uint32_t>(vertex_.size());
        vertex_.push_back(v);
      }
      corners[k] = static_cast<std::uint16_t>(place_[v]);
    }
    mesh.triangles.push_back(corners);
  }
  mesh.vertices.reserve(vertex_.size());
  for (const std::uint32_t v : vertex_) mesh.vertices.push_back(cell.vertices[v]);
  return t;
}

void PartMaker::add_parents(std::span<const std::uint32_t> parents,
                            std::span<const CellVertex> parent_data, CellMesh& mesh) {
  mesh.parent_of.reserve(vertex_.size());
  for (const std::uint32_t v : vertex_) {
    const std::uint32_t parent = parents[v];
    if (parent_stamp_[parent] != part_) {
      parent_stamp_[parent] = part_;
      parent_place_[parent] = static_cast<std::uint32_t>(mesh.parents.size());
      mesh.parents.push_back(parent_data[parent]);
    }
    mesh.parent_of.push_back(static_cast<std::uint16_t>(parent_place_[parent]));
  }
}

}  // namespace cornice::hlod
