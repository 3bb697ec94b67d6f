// SPDX-License-Identifier: GPL-3.0-or-later
// Cells on the GPU, in pages of packed vertices and indices, the least used cells making room.
// There are no more pages than what is there to be drawn takes up, and one until more are needed.
// A cell may come in parts, frame by frame; it is there once it is whole.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "terrain-viewer/render/cell_page.h"
#include "terrain-viewer/render/gl.h"
#include "terrain-viewer/render/range_allocator.h"
#include "terrain-viewer/stream/packed_cell.h"

namespace cornice::viewer {

/// A cell by layer and row of that layer's node table.
struct CellId {
  std::uint32_t layer = 0;
  std::uint32_t row = 0;
};

/// Where a cell lies.
struct GpuCell {
  std::uint32_t page = 0;
  std::uint32_t first_vertex = 0;  ///< vertices, then parents
  std::uint32_t vertex_count = 0;
  std::uint32_t stored_count = 0;  ///< with the parents
  std::uint32_t first_index = 0, index_count = 0;
};

/// Whether a cell may wait for its room to be made.
enum class Growth {
  kAtOnce,  ///< whatever it takes: for pictures
  kSoon,    ///< no more than a page is made in a frame, and none where a PageMaker makes them
};

class GpuCells {
 public:
  /// bytes: on the GPU, at most. page_bytes: of a page, but a cell at least; more where the budget
  /// would make more than 16 of them, less where shaders see less of a buffer.
  explicit GpuCells(std::uint64_t bytes, std::uint64_t page_bytes = 64u << 20)
      : budget_bytes_(bytes), page_bytes_(page_bytes) {}

  /// Has pages made before they are needed, by a thread that uses `context`. Ends before the
  /// context that shares with it.
  void make_ahead(std::unique_ptr<SecondContext> context);
  /// A cell of so many vertices, with their parents, and indices may want to be there: for each
  /// cell of a layer that is opened.
  void expect(std::uint64_t vertices, std::uint64_t indices);

  bool holds(CellId id) const {
    const std::uint32_t slot = slot_of(id);
    return slot != kNone && held_[slot].is_whole();
  }
  /// Empty where the cell is not there; counts as its use in frame `frame`, the first time there,
  /// also where it is not yet whole.
  std::optional<GpuCell> use(CellId id, std::uint64_t frame);
  /// Puts no more than so many bytes of a cell there, after those that are there already. Cells
  /// last used before frame `frame` make room and are appended to `dropped`. The same cell is to be
  /// given until it is whole; until then it makes room as others do. Returns the bytes: nothing
  /// where the cell is whole or there is no room. Throws RunError where the GPU has no room at all.
  std::uint64_t put_part(CellId id, const PackedCell& cell, std::uint64_t most_bytes,
                         std::uint64_t frame, std::vector<CellId>& dropped, Growth growth);

  std::size_t page_count() const { return pages_.size(); }
  GLuint vertices(std::uint32_t page) const { return pages_[page].buffers.vertices.id(); }
  GLuint indices(std::uint32_t page) const { return pages_[page].buffers.indices.id(); }
  std::uint64_t used_bytes() const;       ///< with the room of cells that are not yet whole
  std::uint64_t allocated_bytes() const;  ///< on the GPU, used or not, the page being made too
  /// Of pages that the thread that draws has made itself, while it waited.
  std::uint64_t waited_for_bytes() const { return waited_for_bytes_; }
  /// The budget, or less where the GPU does not have it.
  std::uint64_t capacity_bytes() const { return budget_bytes_; }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  /// A cell that has room, between the one used later and the one used before.
  struct Held {
    CellId id;
    GpuCell cell;
    std::uint64_t frame = 0;
    std::uint64_t written = 0;  ///< bytes of the vertices, then of the indices
    std::uint64_t vertex_bytes() const { return PageSize{cell.stored_count, 0}.bytes(); }
    bool is_whole() const {
      return written == PageSize{cell.stored_count, cell.index_count}.bytes();
    }
    std::uint32_t later = kNone, earlier = kNone;  ///< slots
  };
  struct Page {
    PageSize size;
    PageBuffers buffers;
    RangeAllocator vertices, indices;
  };
  struct Place {
    std::uint32_t page = 0;
    std::uint64_t first_vertex = 0, first_index = 0;
  };
  enum class Grown { kYes, kLater, kNoMore };
  /// Room on a page for so many stored vertices and indices, or none of either.
  std::optional<Place> take_on(std::uint32_t page, const PageSize& size);
  std::optional<Place> take(const PageSize& size);
  std::optional<Place> make_room(const PageSize& size, std::uint64_t frame, Growth growth,
                                 std::vector<CellId>& dropped);
  std::uint32_t slot_of(CellId id) const {
    return id.layer < slots_.size() && id.row < slots_[id.layer].size() ? slots_[id.layer][id.row]
                                                                        : kNone;
  }
  std::uint32_t add_cell(CellId id, const PackedCell& cell, const Place& place,
                         std::uint64_t frame);
  std::uint64_t write(Held& held, const PackedCell& cell, std::uint64_t most_bytes);
  void link_as_latest(std::uint32_t slot);
  void unlink(std::uint32_t slot);
  void drop(std::uint32_t slot);
  std::optional<PageSize> next_page() const;
  Grown grow(std::uint64_t frame, Growth growth);
  void add(const PageSize& size, PageBuffers buffers);
  void look_ahead();

  std::uint64_t budget_bytes_, page_bytes_;
  PageSize expected_, largest_;  ///< of all cells, of one
  std::vector<Page> pages_;
  std::unique_ptr<PageMaker> maker_;
  std::uint64_t waited_for_bytes_ = 0;
  std::optional<std::uint64_t> grown_in_;          ///< the frame that waited for a page last
  std::vector<std::vector<std::uint32_t>> slots_;  ///< by layer and row: index into held_
  std::vector<Held> held_;
  std::vector<std::uint32_t> free_slots_;
  std::uint32_t latest_ = kNone, earliest_ = kNone;
};

}  // namespace cornice::viewer
