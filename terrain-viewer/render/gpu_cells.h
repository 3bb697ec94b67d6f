// SPDX-License-Identifier: GPL-3.0-or-later
// Cells on the GPU: one buffer of packed vertices, one of indices, the least used cells making
// room.
#pragma once

#include <cstdint>
#include <list>
#include <optional>
#include <unordered_map>
#include <vector>

#include "terrain-viewer/render/gl.h"
#include "terrain-viewer/render/range_allocator.h"
#include "terrain-viewer/stream/packed_cell.h"

namespace cornice::viewer {

/// A cell by layer and row of that layer's node table.
struct CellId {
  std::uint32_t layer = 0;
  std::uint32_t row = 0;
  friend bool operator==(CellId, CellId) = default;
};
struct CellIdHash {
  std::size_t operator()(CellId id) const {
    return std::hash<std::uint64_t>{}((std::uint64_t{id.layer} << 32) | id.row);
  }
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
  /// Takes up bytes on the GPU at once. Throws RunError where it has no such room.
  explicit GpuCells(std::uint64_t bytes);

  bool holds(CellId id) const { return cells_.contains(id); }
  /// Empty where the cell is not there; counts as its use in frame `frame`.
  std::optional<GpuCell> use(CellId id, std::uint64_t frame);
  /// Puts a cell there; cells last used before frame `frame` make room and are appended to
  /// `dropped`. False where that is not enough.
  bool put(CellId id, const PackedCell& cell, std::uint64_t frame, std::vector<CellId>& dropped);

  GLuint vertices() const { return vertices_.id(); }
  GLuint indices() const { return indices_.id(); }
  std::uint64_t used_bytes() const;
  std::uint64_t capacity_bytes() const { return capacity_bytes_; }

 private:
  struct Held {
    GpuCell cell;
    std::uint64_t frame = 0;
    std::list<CellId>::iterator place;  ///< in used_
  };
  struct Place {
    std::uint64_t first_vertex = 0, first_index = 0;
  };
  /// Room for so many stored vertices and indices, or none of either.
  std::optional<Place> take(std::uint64_t vertices, std::uint64_t indices);
  void drop(CellId id);

  std::uint64_t capacity_bytes_;
  GlBuffer vertices_, indices_;
  RangeAllocator vertex_ranges_, index_ranges_;
  std::unordered_map<CellId, Held, CellIdHash> cells_;
  std::list<CellId> used_;  ///< the latest first
};

}  // namespace cornice::viewer
