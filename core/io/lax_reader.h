// SPDX-License-Identifier: GPL-3.0-or-later
// The spatial index beside a LAS or LAZ file (FILE.lax): which chunks can have points in a window.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/vec.h"
#include "core/io/las.h"
#include "core/io/las_chunks.h"

namespace cornice {

/// Points first ... last of a file, both included.
struct PointInterval {
  std::uint32_t first = 0;
  std::uint32_t last = 0;
};

/// The intervals of all cells of the index that reach into `window`, in the order of the index.
/// Nothing where the bytes are no index, are damaged, or do not index `point_count` points.
std::optional<std::vector<PointInterval>> lax_intervals_in(std::span<const std::uint8_t> lax,
                                                           const Box2d& window,
                                                           std::uint64_t point_count);

/// Drops from the plan the chunks without points in `window` by the index beside the file or in it.
/// Does nothing and returns false where there is no usable index, or it is older than the file.
bool keep_lax_chunks_in(const LasInfo& info, const Box2d& window, ChunkPlan& plan);

}  // namespace cornice
