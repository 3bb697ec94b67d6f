// SPDX-License-Identifier: GPL-3.0-or-later
// The octree of a COPC file: which of its chunks can have points in a window.
#pragma once

#include "core/base/vec.h"
#include "core/io/byte_source.h"
#include "core/io/las.h"
#include "core/io/las_chunks.h"

namespace cornice {

/// Drops from the plan the chunks of nodes that lie outside `window`. Does nothing and returns
/// false where the hierarchy is damaged or does not name exactly the plan's chunks, so that a full
/// scan still gives the right points.
bool keep_copc_chunks_in(ByteSource& source, const LasInfo& info, const Box2d& window,
                         ChunkPlan& plan);

}  // namespace cornice
