// SPDX-License-Identifier: GPL-3.0-or-later
// The record "laszip encoded" 22204, which says how the points of a LAZ file are compressed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/io/las.h"

namespace cornice {

/// LASzip 3.4, the record's layout: 34 bytes and 6 for each item.
struct LazVlr {
  enum Compressor : std::uint16_t { kNone = 0, kPointwise = 1, kChunked = 2, kLayered = 3 };
  struct Item {
    std::uint16_t type = 0;
    std::uint16_t size = 0;  ///< bytes of this item in an uncompressed record
    std::uint16_t version = 0;
  };
  static constexpr std::uint32_t kVariableChunks = 0xffffffffu;

  std::uint16_t compressor = kNone;
  std::uint32_t chunk_points = 0;  ///< kVariableChunks: the chunk table has counts
  std::vector<Item> items;

  /// False where the points are one stream from first to last (LASzip 1).
  bool has_chunks() const { return compressor == kChunked || compressor == kLayered; }
};

/// Parses and checks the record against the header's point format and record length.
/// Throws InputError naming `name`.
LazVlr parse_laz_vlr(const LasInfo& info, const std::string& name);

/// The record's bytes.
std::vector<std::uint8_t> encode_laz_vlr(const LazVlr& record);

/// The head of a chunk of kLayered: first record as it is, number of points, size of each layer.
struct LayeredHead {
  std::uint32_t points = 0;
  std::uint64_t chunk_bytes = 0;             ///< head and layers together
  std::vector<std::uint64_t> layer_offsets;  ///< in the chunk, of layers that are not empty
};

/// Bytes of that head.
std::size_t layered_head_bytes(const LazVlr& record);

/// Reads it; nothing where `chunk` has fewer bytes. LASzip would allocate the layers' sizes as they
/// are, so they are to be compared with the bytes that are there first.
std::optional<LayeredHead> read_layered_head(const LazVlr& record,
                                             std::span<const std::uint8_t> chunk);

}  // namespace cornice
