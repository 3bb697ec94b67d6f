// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/render/gpu_cells.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/base/error.h"

namespace cornice::viewer {
namespace {

/// The first page, for which a first picture waits: the coarsest level and more.
constexpr std::uint64_t kFirstPageBytes = 32u << 20;
/// The fewer pages, the fewer calls to draw, and the more room is made in vain.
constexpr std::uint64_t kMostPages = 16;
/// Of a page whose use has the next one made.
constexpr double kAheadShare = 0.5;

/// What of `bytes` is for vertices and what for indices, as in `all`, but one `cell` at least.
PageSize parted(std::uint64_t bytes, const PageSize& all, const PageSize& cell) {
  constexpr std::uint64_t kVertexBytes = PageSize{1, 0}.bytes(), kIndexBytes = 2;
  const double share = static_cast<double>(all.vertices) / static_cast<double>(all.bytes());
  auto vertices = static_cast<std::uint64_t>(std::llround(share * static_cast<double>(bytes)));
  if (bytes >= cell.bytes())
    vertices =
        std::clamp(vertices, cell.vertices, (bytes - cell.indices * kIndexBytes) / kVertexBytes);
  vertices = std::min(vertices, bytes / kVertexBytes);
  return {vertices, (bytes - vertices * kVertexBytes) / kIndexBytes};
}

/// What a shader may see of a buffer; OpenGL promises 16 MB, Mesa's rasteriser has 128.
std::uint64_t most_page_bytes() {
  GLint64 most = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  return static_cast<std::uint64_t>(std::max<GLint64>(most, 16 << 20));
}

}  // namespace

void GpuCells::make_ahead(std::unique_ptr<SecondContext> context) {
  maker_ = std::make_unique<PageMaker>(std::move(context));
}

void GpuCells::expect(std::uint64_t vertices, std::uint64_t indices) {
  expected_.vertices += vertices;
  expected_.indices += indices;
  largest_.vertices = std::max(largest_.vertices, vertices);
  largest_.indices = std::max(largest_.indices, indices);
}

/// The page that would be made next; none where the budget has no room for a cell more.
std::optional<PageSize> GpuCells::next_page() const {
  const std::uint64_t there = allocated_bytes(), all = expected_.bytes();
  const std::uint64_t rest = budget_bytes_ - std::min(budget_bytes_, there);
  if (pages_.empty())
    return parted(
        std::min({rest, all, std::max(std::min(kFirstPageBytes, page_bytes_), largest_.bytes())}),
        expected_, largest_);
  if (rest < largest_.bytes()) return std::nullopt;
  // Cells leave gaps at the ends of pages, so all may take more than its bytes.
  const std::uint64_t wanted = (all > there ? all - there : 0) + 4 * largest_.bytes();
  const std::uint64_t usual =
      std::min(std::max(page_bytes_, budget_bytes_ / kMostPages), most_page_bytes());
  return parted(std::max(std::min({rest, wanted, usual}), largest_.bytes()), expected_, largest_);
}

void GpuCells::add(const PageSize& size, PageBuffers buffers) {
  pages_.push_back(
      {size, std::move(buffers), RangeAllocator(size.vertices), RangeAllocator(size.indices)});
}

GpuCells::Grown GpuCells::grow(std::uint64_t frame, Growth growth) {
  const bool waits = growth == Growth::kAtOnce || pages_.empty();
  if (maker_ != nullptr && !maker_->is_under_way()) {
    const auto next = next_page();
    if (!next) return Grown::kNoMore;
    maker_->want(*next);
  }
  if (maker_ != nullptr) {
    auto made = maker_->take(waits);
    if (!made) return Grown::kLater;
    if (made->buffers.indices.id() != 0) {
      add(made->size, std::move(made->buffers));
      return Grown::kYes;
    }
    maker_.reset();  // what the second context cannot do, this one tries itself
  }
  if (!waits && grown_in_ == frame) return Grown::kLater;
  const auto next = next_page();
  if (!next) return Grown::kNoMore;
  try {
    add(*next, make_page_buffers(*next));
  } catch (const RunError&) {
    if (pages_.empty()) throw;
    budget_bytes_ = allocated_bytes();
    return Grown::kNoMore;
  }
  grown_in_ = frame;
  waited_for_bytes_ += next->bytes();
  return Grown::kYes;
}

/// Has the next page made once the last one is in use, where more is likely to come.
void GpuCells::look_ahead() {
  if (maker_ == nullptr || maker_->is_under_way()) return;
  const Page& last = pages_.back();
  const PageSize used{last.vertices.used(), last.indices.used()};
  if (static_cast<double>(used.bytes()) < kAheadShare * static_cast<double>(last.size.bytes()) ||
      allocated_bytes() >= expected_.bytes())
    return;
  if (const auto next = next_page()) maker_->want(*next);
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
  Held& held = held_[slot];
  if (held.frame != frame) {
    held.frame = frame;
    unlink(slot);
    link_as_latest(slot);
  }
  if (!held.is_whole()) return std::nullopt;
  return held.cell;
}

std::optional<GpuCells::Place> GpuCells::take_on(std::uint32_t page, const PageSize& size) {
  Page& on = pages_[page];
  const auto first_vertex = on.vertices.take(size.vertices);
  if (!first_vertex) return std::nullopt;
  const auto first_index = on.indices.take(size.indices);
  if (first_index) return Place{page, *first_vertex, *first_index};
  on.vertices.give_back(*first_vertex, size.vertices);
  return std::nullopt;
}

std::optional<GpuCells::Place> GpuCells::take(const PageSize& size) {
  for (std::uint32_t page = 0; page < pages_.size(); ++page)
    if (const auto place = take_on(page, size)) return place;
  return std::nullopt;
}

/// On a new page while there may be more, then where others make room.
std::optional<GpuCells::Place> GpuCells::make_room(const PageSize& size, std::uint64_t frame,
                                                   Growth growth, std::vector<CellId>& dropped) {
  while (true) {
    const Grown grown = grow(frame, growth);
    if (grown == Grown::kLater) return std::nullopt;
    if (grown == Grown::kNoMore) break;
    if (const auto place = take_on(static_cast<std::uint32_t>(pages_.size() - 1), size))
      return place;
  }
  while (earliest_ != kNone && held_[earliest_].frame < frame) {
    const std::uint32_t page = held_[earliest_].cell.page;
    dropped.push_back(held_[earliest_].id);
    drop(earliest_);
    if (const auto place = take_on(page, size)) return place;
  }
  return std::nullopt;
}

std::uint64_t GpuCells::put_part(CellId id, const PackedCell& cell, std::uint64_t most_bytes,
                                 std::uint64_t frame, std::vector<CellId>& dropped, Growth growth) {
  std::uint32_t slot = slot_of(id);
  if (slot == kNone) {
    const PageSize size{cell.words.size() / kWordsPerVertex, cell.indices.size()};
    std::optional<Place> place = take(size);
    if (!place) place = make_room(size, frame, growth, dropped);
    if (!place) return 0;
    slot = add_cell(id, cell, *place, frame);
    look_ahead();
  } else {
    use(id, frame);
  }
  return write(held_[slot], cell, most_bytes);
}

std::uint32_t GpuCells::add_cell(CellId id, const PackedCell& cell, const Place& place,
                                 std::uint64_t frame) {
  if (free_slots_.empty()) {
    free_slots_.push_back(static_cast<std::uint32_t>(held_.size()));
    held_.emplace_back();
  }
  const std::uint32_t slot = free_slots_.back();
  free_slots_.pop_back();
  const auto small = [](std::uint64_t value) { return static_cast<std::uint32_t>(value); };
  held_[slot] = {id,
                 {place.page, small(place.first_vertex), cell.vertex_count,
                  small(cell.words.size() / kWordsPerVertex), small(place.first_index),
                  small(cell.indices.size())},
                 frame};
  if (id.layer >= slots_.size()) slots_.resize(id.layer + 1);
  if (id.row >= slots_[id.layer].size()) slots_[id.layer].resize(id.row + 1, kNone);
  slots_[id.layer][id.row] = slot;
  link_as_latest(slot);
  return slot;
}

/// Of the vertices, then of the indices, what comes after what was written before.
std::uint64_t GpuCells::write(Held& held, const PackedCell& cell, std::uint64_t most_bytes) {
  std::uint64_t sum = 0;
  const auto go_on = [&](GLuint buffer, std::uint64_t place, std::uint64_t from, std::uint64_t end,
                         const void* data) {
    const std::uint64_t bytes = std::min(end - from, most_bytes - sum);
    if (bytes == 0) return;
    glNamedBufferSubData(buffer, static_cast<GLintptr>(place + from),
                         static_cast<GLsizeiptr>(bytes),
                         static_cast<const std::byte*>(data) + from);
    held.written += bytes;
    sum += bytes;
  };
  const GpuCell& at = held.cell;
  const std::uint64_t vertex_bytes = held.vertex_bytes();
  if (held.written < vertex_bytes)
    go_on(vertices(at.page), PageSize{at.first_vertex, 0}.bytes(), held.written, vertex_bytes,
          cell.words.data());
  if (held.written >= vertex_bytes)
    go_on(indices(at.page), PageSize{0, at.first_index}.bytes(), held.written - vertex_bytes,
          PageSize{0, at.index_count}.bytes(), cell.indices.data());
  return sum;
}

void GpuCells::drop(std::uint32_t slot) {
  const Held& held = held_[slot];
  Page& page = pages_[held.cell.page];
  page.vertices.give_back(held.cell.first_vertex, held.cell.stored_count);
  page.indices.give_back(held.cell.first_index, held.cell.index_count);
  slots_[held.id.layer][held.id.row] = kNone;
  unlink(slot);
  free_slots_.push_back(slot);
}

std::uint64_t GpuCells::used_bytes() const {
  std::uint64_t bytes = 0;
  for (const Page& page : pages_)
    bytes += PageSize{page.vertices.used(), page.indices.used()}.bytes();
  return bytes;
}

std::uint64_t GpuCells::allocated_bytes() const {
  std::uint64_t bytes = maker_ != nullptr ? maker_->size().bytes() : 0;
  for (const Page& page : pages_) bytes += page.size.bytes();
  return bytes;
}

}  // namespace cornice::viewer
