// SPDX-License-Identifier: GPL-3.0-or-later
// Cells on the GPU: one buffer of packed vertices, one of indices, the least used cells making
// room. Buffers are no larger than what is there to be drawn, and small until that is needed:
// drivers that fill new memory take a second for a gigabyte.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "terrain-viewer/render/gl.h"
#include "terrain-viewer/render/range_allocator.h"
#include "terrain-viewer/stream/packed_cell.h"

namespace cornice::viewer {

/// A cell by layer and row of that layer's node table.
struct CellId {
  std::uint32_t layer = 0;
  std::uint32_t row = 0;
};

/// Where a cell lies in the buffers.
struct GpuCell {
  std::uint32_t first_vertex = 0;  ///< vertices, then parents
  std::uint32_t vertex_count = 0;
  std::uint32_t stored_count = 0;  ///< with the parents
  std::uint32_t first_index = 0, index_count = 0;
};

class GpuCells {
 public:
  /// bytes: on the GPU, at most.
  explicit GpuCells(std::uint64_t bytes) : budget_bytes_(bytes) {}

  /// So much more (vertices with their parents) may want to be there at a time: a layer was opened.
  void expect(std::uint64_t vertices, std::uint64_t indices);

  bool holds(CellId id) const { return slot_of(id) != kNone; }
  /// Empty where the cell is not there; counts as its use in frame `frame`.
  std::optional<GpuCell> use(CellId id, std::uint64_t frame);
  /// Puts a cell there; cells last used before frame `frame` make room and are appended to
  /// `dropped`. False where that is not enough. Throws RunError where the GPU has no room at all.
  bool put(CellId id, const PackedCell& cell, std::uint64_t frame, std::vector<CellId>& dropped);

  GLuint vertices() const { return vertices_.id(); }
  GLuint indices() const { return indices_.id(); }
  std::uint64_t used_bytes() const;
  std::uint64_t allocated_bytes() const;  ///< on the GPU, used or not
  /// The budget, or less where the GPU does not have it.
  std::uint64_t capacity_bytes() const { return budget_bytes_; }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  /// A cell that is there, between the one used later and the one used before.
  struct Held {
    CellId id;
    GpuCell cell;
    std::uint64_t frame = 0;
    std::uint32_t later = kNone, earlier = kNone;  ///< slots
  };
  struct Size {
    std::uint64_t vertices = 0, indices = 0;
    std::uint64_t bytes() const;
  };
  struct Place {
    std::uint64_t first_vertex = 0, first_index = 0;
  };
  /// Room for so many stored vertices and indices, or none of either.
  std::optional<Place> take(std::uint64_t vertices, std::uint64_t indices);
  std::uint32_t slot_of(CellId id) const {
    return id.layer < slots_.size() && id.row < slots_[id.layer].size() ? slots_[id.layer][id.row]
                                                                        : kNone;
  }
  void link_as_latest(std::uint32_t slot);
  void unlink(std::uint32_t slot);
  void drop(std::uint32_t slot);
  Size most() const;
  bool grow(std::uint64_t vertices, std::uint64_t indices);

  std::uint64_t budget_bytes_;
  Size expected_, size_;
  GlBuffer vertices_, indices_;
  RangeAllocator vertex_ranges_{0}, index_ranges_{0};
  std::vector<std::vector<std::uint32_t>> slots_;  ///< by layer and row: index into held_
  std::vector<Held> held_;
  std::vector<std::uint32_t> free_slots_;
  std::uint32_t latest_ = kNone, earliest_ = kNone;
};

}  // namespace cornice::viewer
