// SPDX-License-Identifier: GPL-3.0-or-later
// What lies where in a .hlod file: shared by writer and reader. docs/formats/hlod.md.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "hlod/file.h"

namespace cornice::hlod {

/// The head's numbers beside Header, and where everything is.
struct Head {
  Header header;
  Box3d bounds;
  std::uint64_t file_bytes = 0;
  std::uint64_t node_count = 0;
  std::uint64_t table_offset = 0;
  std::uint64_t table_checksum = 0;
};

inline constexpr std::size_t kFixedHeadBytes = 192;
inline constexpr std::size_t kTextLimit = std::size_t{1} << 24;  ///< of CRS and provenance each

/// Bytes of the head: blocks begin there.
std::size_t head_bytes(const Header& header);
std::vector<std::uint8_t> pack_head(const Head& head);
/// Length of the head by its first kFixedHeadBytes bytes. Throws InputError, as unpack_head does,
/// for what is no .hlod file or another version's.
std::size_t head_length(const std::filesystem::path& path, std::span<const std::uint8_t> fixed);
Head unpack_head(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);

/// Why a header or a node makes no sense; empty where it does.
std::string fault_of(const Header& header);
std::string fault_of(const Node& node, const Header& header);

/// Nodes sorted by key and part, as bytes and back. Offsets are not stored: blocks lie one after
/// the other from `first_offset` on.
std::vector<std::byte> pack_nodes(std::span<const Node> nodes, const Lattice& lattice);
/// Throws InputError where the table is damaged or a node makes no sense.
std::vector<Node> unpack_nodes(const std::filesystem::path& path, std::span<const std::byte> bytes,
                               const Head& head);

Box3d bounds_of(std::span<const Node> nodes, const Lattice& lattice);
std::vector<LevelStatistics> statistics_of(std::span<const Node> nodes, int finest_level);

}  // namespace cornice::hlod
