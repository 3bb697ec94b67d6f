// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/render/gpu_cells.h"

#include <algorithm>

#include "core/base/error.h"

namespace cornice::viewer {
namespace {

constexpr std::uint64_t kVertexBytes = kWordsPerVertex * 4;
constexpr std::uint64_t kIndexBytes = 2;
/// What the first buffers take up: enough for the coarsest level and more.
constexpr std::uint64_t kFirstBytes = 48u << 20;

/// A buffer of `bytes` that begins with what the old one holds.
GlBuffer longer(const GlBuffer& old, std::uint64_t old_bytes, std::uint64_t bytes) {
  GlBuffer buffer = make_buffer(std::max<std::uint64_t>(bytes, 4));
  if (old_bytes > 0)
    glCopyNamedBufferSubData(old.id(), buffer.id(), 0, 0, static_cast<GLsizeiptr>(old_bytes));
  return buffer;
}

}  // namespace

std::uint64_t GpuCells::Size::bytes() const {
  return vertices * kVertexBytes + indices * kIndexBytes;
}

void GpuCells::expect(std::uint64_t vertices, std::uint64_t indices) {
  expected_.vertices += vertices;
  expected_.indices += indices;
}

/// What the buffers may grow to: all that is expected, or its like within the budget.
GpuCells::Size GpuCells::most() const {
  Size most = expected_;
  if (most.bytes() > budget_bytes_) {
    const double share =
        static_cast<double>(budget_bytes_) / static_cast<double>(expected_.bytes());
    most.vertices = static_cast<std::uint64_t>(share * static_cast<double>(expected_.vertices));
    most.indices = (budget_bytes_ - most.vertices * kVertexBytes) / kIndexBytes;
  }
  // Layers that came later may have other proportions: what is there stays.
  most.vertices = std::max(most.vertices, size_.vertices);
  const std::uint64_t rest = budget_bytes_ - std::min(budget_bytes_, most.vertices * kVertexBytes);
  most.indices = std::max(std::min(most.indices, rest / kIndexBytes), size_.indices);
  return most;
}

/// Makes the buffers longer so that so much more is likely to fit; false where they are as long as
/// they may be.
bool GpuCells::grow(std::uint64_t vertices, std::uint64_t indices) {
  const Size most = this->most();
  Size size = most;
  if (size_.bytes() == 0 && most.bytes() > kFirstBytes) {
    const double share = static_cast<double>(kFirstBytes) / static_cast<double>(most.bytes());
    const auto part = [&](std::uint64_t whole, std::uint64_t least) {
      return std::clamp(static_cast<std::uint64_t>(share * static_cast<double>(whole)),
                        std::min(least, whole), whole);
    };
    size = {part(most.vertices, vertices), part(most.indices, indices)};
  }
  if (size.vertices == size_.vertices && size.indices == size_.indices) return false;
  try {
    GlBuffer more_vertices =
        longer(vertices_, size_.vertices * kVertexBytes, size.vertices * kVertexBytes);
    indices_ = longer(indices_, size_.indices * kIndexBytes, size.indices * kIndexBytes);
    vertices_ = std::move(more_vertices);
  } catch (const RunError&) {
    if (size_.bytes() == 0) throw;
    budget_bytes_ = size_.bytes();
    return false;
  }
  vertex_ranges_.extend(size.vertices - size_.vertices);
  index_ranges_.extend(size.indices - size_.indices);
  size_ = size;
  return true;
}

void GpuCells::link_as_latest(std::uint32_t slot) {
  held_[slot].earlier = latest_;
  held_[slot].later = kNone;
  if (latest_ != kNone) held_[latest_].later = slot;
  latest_ = slot;
  if (earliest_ == kNone) earliest_ = slot;
}

void GpuCells::unlink(std::uint32_t slot) {
  const Held& held = held_[slot];
  (held.later != kNone ? held_[held.later].earlier : latest_) = held.earlier;
  (held.earlier != kNone ? held_[held.earlier].later : earliest_) = held.later;
}

std::optional<GpuCell> GpuCells::use(CellId id, std::uint64_t frame) {
  const std::uint32_t slot = slot_of(id);
  if (slot == kNone) return std::nullopt;
  held_[slot].frame = frame;
  unlink(slot);
  link_as_latest(slot);
  return held_[slot].cell;
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
  if (holds(id)) return true;
  const std::uint64_t stored = cell.words.size() / kWordsPerVertex;
  std::optional<Place> place = take(stored, cell.indices.size());
  while (!place) {
    if (!grow(stored, cell.indices.size())) {
      if (earliest_ == kNone || held_[earliest_].frame >= frame) return false;
      dropped.push_back(held_[earliest_].id);
      drop(earliest_);
    }
    place = take(stored, cell.indices.size());
  }
  glNamedBufferSubData(vertices_.id(), static_cast<GLintptr>(place->first_vertex * kVertexBytes),
                       static_cast<GLsizeiptr>(cell.words.size() * 4), cell.words.data());
  glNamedBufferSubData(indices_.id(), static_cast<GLintptr>(place->first_index * kIndexBytes),
                       static_cast<GLsizeiptr>(cell.indices.size() * kIndexBytes),
                       cell.indices.data());
  if (free_slots_.empty()) {
    free_slots_.push_back(static_cast<std::uint32_t>(held_.size()));
    held_.emplace_back();
  }
  const std::uint32_t slot = free_slots_.back();
  free_slots_.pop_back();
  const auto small = [](std::uint64_t value) { return static_cast<std::uint32_t>(value); };
  held_[slot] = {id,
                 {small(place->first_vertex), cell.vertex_count, small(stored),
                  small(place->first_index), small(cell.indices.size())},
                 frame};
  if (id.layer >= slots_.size()) slots_.resize(id.layer + 1);
  if (id.row >= slots_[id.layer].size()) slots_[id.layer].resize(id.row + 1, kNone);
  slots_[id.layer][id.row] = slot;
  link_as_latest(slot);
  return true;
}

void GpuCells::drop(std::uint32_t slot) {
  const Held& held = held_[slot];
  vertex_ranges_.give_back(held.cell.first_vertex, held.cell.stored_count);
  index_ranges_.give_back(held.cell.first_index, held.cell.index_count);
  slots_[held.id.layer][held.id.row] = kNone;
  unlink(slot);
  free_slots_.push_back(slot);
}

std::uint64_t GpuCells::used_bytes() const {
  return Size{vertex_ranges_.used(), index_ranges_.used()}.bytes();
}

std::uint64_t GpuCells::allocated_bytes() const { return size_.bytes(); }

}  // namespace cornice::viewer
