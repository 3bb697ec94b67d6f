// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "terrain-viewer/render/gpu_cells.h"

namespace cornice::viewer {

/// Puts all of a cell on the GPU in one step; true where it is there then.
inline bool put_whole(GpuCells& cells, CellId id, const PackedCell& cell, std::uint64_t frame,
                      std::vector<CellId>& dropped, Growth growth = Growth::kAtOnce) {
  cells.put_part(id, cell, cell.bytes(), frame, dropped, growth);
  return cells.holds(id);
}

}  // namespace cornice::viewer
