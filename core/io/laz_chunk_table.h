// SPDX-License-Identifier: GPL-3.0-or-later
// The chunk table of a LAZ file: how many bytes (and, where chunks vary, points) each chunk has.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace cornice {

/// One chunk. `points` is 0 in a table of fixed-size chunks, which stores no counts.
struct LazChunk {
  std::uint32_t points = 0;
  std::uint32_t bytes = 0;

  friend bool operator==(const LazChunk&, const LazChunk&) = default;
};

/// The table's bytes as they stand in the file: version 0, number of chunks, coded sizes.
/// `with_counts`: chunks of varying size (COPC); else only their bytes are stored.
std::vector<std::uint8_t> encode_chunk_table(std::span<const LazChunk> chunks, bool with_counts);

/// The inverse; `bytes` may run on behind the table. Nothing where the version is not 0, where
/// there are more than `most_chunks`, or where the bytes end inside the table.
std::optional<std::vector<LazChunk>> decode_chunk_table(std::span<const std::uint8_t> bytes,
                                                        bool with_counts, std::size_t most_chunks);

}  // namespace cornice
