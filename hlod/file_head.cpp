// SPDX-License-Identifier: GPL-3.0-or-later
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "core/base/error.h"
#include "core/io/little_endian.h"
#include "hlod/file_layout.h"

namespace cornice::hlod {
namespace {

using Bytes = std::span<const std::uint8_t>;

// As PNG's: a byte that is no text, the name, and line ends that careless copying would change.
constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'H', 'L', 'O', 'D', '\r', '\n', 0x1a};
constexpr std::uint32_t kVersion = 1;
constexpr std::uint32_t kByteOrder = 0x01020304;

/// Offsets in the head.
namespace at {
constexpr std::size_t kVersion = 8, kByteOrder = 12, kFileBytes = 16, kTableOffset = 24,
                      kNodeCount = 32, kOrigin = 40, kRootSide = 64, kFinestLevel = 72,
                      kCellBits = 76, kPartition = 80, kAttributes = 84, kNormalBits = 88,
                      kEdgeShare = 96, kBounds = 104, kCrsBytes = 152, kProvenanceBytes = 156,
                      kTableChecksum = 176, kHeadChecksum = 184;
}

/// Of the whole head, its own field taken for zero.
std::uint64_t head_checksum(Bytes head) {
  std::vector<std::uint8_t> copy(head.begin(), head.end());
  store_le(copy, at::kHeadChecksum, std::uint64_t{0});
  return XXH3_64bits(copy.data(), copy.size());
}

bool is_finite(Vec3d v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace

std::size_t head_bytes(const Header& header) {
  return kFixedHeadBytes + header.crs_text.size() + header.provenance.size();
}

std::vector<std::uint8_t> pack_head(const Head& head) {
  const Header& h = head.header;
  std::vector<std::uint8_t> bytes(head_bytes(h), 0);
  const auto put = [&](std::size_t offset, auto value) { store_le(bytes, offset, value); };
  std::copy(kMagic.begin(), kMagic.end(), bytes.begin());
  put(at::kVersion, kVersion);
  put(at::kByteOrder, kByteOrder);
  put(at::kFileBytes, head.file_bytes);
  put(at::kTableOffset, head.table_offset);
  put(at::kNodeCount, head.node_count);
  put(at::kOrigin, h.lattice.origin);
  put(at::kRootSide, h.lattice.root_side);
  put(at::kFinestLevel, static_cast<std::uint32_t>(h.lattice.finest_level));
  put(at::kCellBits, static_cast<std::uint32_t>(h.lattice.cell_bits));
  put(at::kPartition, static_cast<std::uint32_t>(h.partition));
  put(at::kAttributes, h.attributes);
  put(at::kNormalBits, static_cast<std::uint32_t>(h.normal_bits));
  put(at::kEdgeShare, h.edge_share);
  put(at::kBounds, head.bounds.min);
  put(at::kBounds + 24, head.bounds.max);
  put(at::kCrsBytes, static_cast<std::uint32_t>(h.crs_text.size()));
  put(at::kProvenanceBytes, static_cast<std::uint32_t>(h.provenance.size()));
  put(at::kTableChecksum, head.table_checksum);
  const auto texts = bytes.begin() + kFixedHeadBytes;
  std::copy(h.crs_text.begin(), h.crs_text.end(), texts);
  std::copy(h.provenance.begin(), h.provenance.end(),
            texts + static_cast<std::ptrdiff_t>(h.crs_text.size()));
  store_le(bytes, at::kHeadChecksum, head_checksum(bytes));
  return bytes;
}

std::size_t head_length(const std::filesystem::path& path, Bytes fixed) {
  if (fixed.size() < kMagic.size() || !std::equal(kMagic.begin(), kMagic.end(), fixed.begin())) {
    throw InputError(path.string(), "is no .hlod file: it does not begin as one");
  }
  if (fixed.size() < kFixedHeadBytes) {
    throw InputError(path.string(), "ends in its head; write it anew");
  }
  const auto order = load_le<std::uint32_t>(fixed, at::kByteOrder);
  if (order == __builtin_bswap32(kByteOrder)) {
    throw InputError(path.string(), "has its bytes in the other order");
  }
  if (order != kByteOrder) throw InputError(path.string(), "has a damaged head; write it anew");
  const auto version = load_le<std::uint32_t>(fixed, at::kVersion);
  if (version != kVersion) {
    throw InputError(path.string(), "is of version " + std::to_string(version) +
                                        " of the format; this program reads version " +
                                        std::to_string(kVersion));
  }
  const std::size_t crs = load_le<std::uint32_t>(fixed, at::kCrsBytes);
  const std::size_t provenance = load_le<std::uint32_t>(fixed, at::kProvenanceBytes);
  if (crs > kTextLimit || provenance > kTextLimit) {
    throw InputError(path.string(), "has a damaged head; write it anew");
  }
  return kFixedHeadBytes + crs + provenance;
}

Head unpack_head(const std::filesystem::path& path, Bytes bytes) {
  if (head_length(path, bytes) > bytes.size()) {
    throw InputError(path.string(), "ends in its head; write it anew");
  }
  if (load_le<std::uint64_t>(bytes, at::kHeadChecksum) != head_checksum(bytes)) {
    throw InputError(path.string(), "has a damaged head: its checksum does not fit; write it anew");
  }
  Head head;
  Header& h = head.header;
  head.file_bytes = load_le<std::uint64_t>(bytes, at::kFileBytes);
  head.table_offset = load_le<std::uint64_t>(bytes, at::kTableOffset);
  head.node_count = load_le<std::uint64_t>(bytes, at::kNodeCount);
  head.table_checksum = load_le<std::uint64_t>(bytes, at::kTableChecksum);
  h.lattice.origin = load_le<Vec3d>(bytes, at::kOrigin);
  h.lattice.root_side = load_le<double>(bytes, at::kRootSide);
  // Numbers that do not fit an int become negative, which fault_of refuses.
  h.lattice.finest_level = load_le<std::int32_t>(bytes, at::kFinestLevel);
  h.lattice.cell_bits = load_le<std::int32_t>(bytes, at::kCellBits);
  const auto partition = load_le<std::uint32_t>(bytes, at::kPartition);
  h.partition = partition == 1 ? Partition::kOctree : Partition::kQuadtree;
  h.attributes = load_le<std::uint32_t>(bytes, at::kAttributes);
  h.normal_bits = load_le<std::int32_t>(bytes, at::kNormalBits);
  h.edge_share = load_le<double>(bytes, at::kEdgeShare);
  head.bounds = {load_le<Vec3d>(bytes, at::kBounds), load_le<Vec3d>(bytes, at::kBounds + 24)};
  const std::size_t crs = load_le<std::uint32_t>(bytes, at::kCrsBytes);
  const auto* text = reinterpret_cast<const char*>(bytes.data()) + kFixedHeadBytes;
  h.crs_text.assign(text, crs);
  h.provenance.assign(text + crs, bytes.size() - kFixedHeadBytes - crs);
  const std::string fault = partition > 1 ? "names an unknown partition" : fault_of(h);
  if (!fault.empty()) throw InputError(path.string(), fault + "; write it anew");
  return head;
}

std::string fault_of(const Header& h) {
  const Lattice& lattice = h.lattice;
  if (!is_finite(lattice.origin) || !std::isfinite(lattice.root_side) || lattice.root_side <= 0) {
    return "has a lattice without place or size";
  }
  if (lattice.finest_level < 0 || lattice.finest_level > 16 || lattice.cell_bits < 8 ||
      lattice.cell_bits > 16 || lattice.finest_level + lattice.cell_bits > 29) {
    return "has a lattice of impossible depth";
  }
  if (!(h.edge_share > 0.0 && h.edge_share <= 0.5)) return "has edges of impossible length";
  if (h.normal_bits != 8 && h.normal_bits != 10) return "has normals of neither 8 nor 10 bits";
  if (h.attributes > (kHasSupport | kHasSource | kHasColour | kHasTexture)) {
    return "has attributes that this program does not know";
  }
  if (h.crs_text.size() > kTextLimit || h.provenance.size() > kTextLimit) {
    return "has texts beyond 16 MiB";
  }
  return "";
}

}  // namespace cornice::hlod
