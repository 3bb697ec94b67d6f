// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/render/gpu_cells.h"

namespace cornice::viewer {
namespace {

constexpr std::uint64_t kVertexBytes = kWordsPerVertex * 4;
/// A mesh has two triangles, that is six indices, for every vertex; parents are a quarter more.
constexpr std::uint64_t kIndexShareBytes = 10;

std::uint64_t vertex_capacity(std::uint64_t bytes) {
  return bytes / (kVertexBytes + kIndexShareBytes);
}
std::uint64_t index_capacity(std::uint64_t bytes) {
  return (bytes - vertex_capacity(bytes) * kVertexBytes) / 2;
}

}  // namespace

GpuCells::GpuCells(std::uint64_t bytes)
    : capacity_bytes_(bytes),
      vertices_(make_buffer(vertex_capacity(bytes) * kVertexBytes)),
      indices_(make_buffer(index_capacity(bytes) * 2)),
      vertex_ranges_(vertex_capacity(bytes)),
      index_ranges_(index_capacity(bytes)) {}

std::optional<GpuCell> GpuCells::use(CellId id, std::uint64_t frame) {
  const auto found = cells_.find(id);
  if (found == cells_.end()) return std::nullopt;
  found->second.frame = frame;
  used_.splice(used_.begin(), used_, found->second.place);
  return found->second.cell;
}

std::optional<GpuCells::Place> GpuCells::take(std::uint64_t vertices, std::uint64_t indices) {
  const auto first_vertex = vertex_ranges_.take(vertices);
  if (!first_vertex) return std::nullopt;
  const auto first_index = index_ranges_.take(indices);
  if (first_index) return Place{*first_vertex, *first_index};
  vertex_ranges_.give_back(*first_vertex, vertices);
  return std::nullopt;
}

bool GpuCells::put(CellId id, const PackedCell& cell, std::uint64_t frame,
                   std::vector<CellId>& dropped) {
  if (cells_.contains(id)) return true;
  const std::uint64_t stored = cell.words.size() / kWordsPerVertex;
  std::optional<Place> place = take(stored, cell.indices.size());
  while (!place) {
    if (used_.empty() || cells_.at(used_.back()).frame >= frame) return false;
    dropped.push_back(used_.back());
    drop(used_.back());
    place = take(stored, cell.indices.size());
  }
  glNamedBufferSubData(vertices_.id(), static_cast<GLintptr>(place->first_vertex * kVertexBytes),
                       static_cast<GLsizeiptr>(cell.words.size() * 4), cell.words.data());
  glNamedBufferSubData(indices_.id(), static_cast<GLintptr>(place->first_index * 2),
                       static_cast<GLsizeiptr>(cell.indices.size() * 2), cell.indices.data());
  used_.push_front(id);
  cells_[id] = {{static_cast<std::uint32_t>(place->first_vertex), cell.vertex_count,
                 static_cast<std::uint32_t>(stored), static_cast<std::uint32_t>(place->first_index),
                 static_cast<std::uint32_t>(cell.indices.size())},
                frame,
                used_.begin()};
  return true;
}

void GpuCells::drop(CellId id) {
  const auto found = cells_.find(id);
  vertex_ranges_.give_back(found->second.cell.first_vertex, found->second.cell.stored_count);
  index_ranges_.give_back(found->second.cell.first_index, found->second.cell.index_count);
  used_.erase(found->second.place);
  cells_.erase(found);
}

std::uint64_t GpuCells::used_bytes() const {
  return vertex_ranges_.used() * kVertexBytes + index_ranges_.used() * 2;
}

}  // namespace cornice::viewer
