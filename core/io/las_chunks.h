// SPDX-License-Identifier: GPL-3.0-or-later
// Where the points of a file lie: chunks that can be decoded independently of each other.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/io/byte_source.h"
#include "core/io/las.h"
#include "core/io/laz_vlr.h"

namespace cornice {

/// Consecutive points and the consecutive bytes that hold them.
struct PointChunk {
  std::uint64_t offset = 0;  ///< in the file
  std::uint64_t bytes = 0;
  std::uint64_t first = 0;  ///< index of its first point in the file
  std::uint64_t points = 0;
};

/// All chunks of a file in file order.
struct ChunkPlan {
  LazVlr laz;  ///< compressor kNone for LAS
  std::vector<PointChunk> chunks;
  /// The borders of the chunks are not known: `chunks` has one entry with everything in it, to be
  /// decoded from the start. Also the case for LASzip 1, which knew no chunks.
  bool one_stream = false;
  /// Why not all points can be read; `chunks` then holds what may be readable.
  std::string problem;
};

/// Plans the reading of a file, checking the chunk table against the file's size and point count.
/// Throws InputError where the LASzip record cannot be used.
ChunkPlan plan_chunks(ByteSource& source, const LasInfo& info);

}  // namespace cornice
