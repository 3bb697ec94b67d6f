// SPDX-License-Identifier: GPL-3.0-or-later
// Source: LASzip 3.4 (the item types are those of its public header); Isenburg, LASzip: lossless
// compression of LiDAR data, 2013.
#include "core/io/laz_vlr.h"

#include "core/base/error.h"
#include "core/io/las_header.h"
#include "core/io/little_endian.h"

namespace cornice {
namespace {

constexpr std::size_t kFixedBytes = 34;
constexpr std::size_t kItemBytes = 6;

enum ItemType : std::uint16_t {
  kByte = 0,
  kPoint10 = 6,
  kGpsTime11 = 7,
  kRgb12 = 8,
  kWavePacket13 = 9,
  kPoint14 = 10,
  kRgb14 = 11,
  kRgbNir14 = 12,
  kWavePacket14 = 13,
  kByte14 = 14,
};

/// Items of each point format, extra bytes aside.
std::vector<std::uint16_t> items_of_format(int point_format) {
  switch (point_format) {
    case 0:
      return {kPoint10};
    case 1:
      return {kPoint10, kGpsTime11};
    case 2:
      return {kPoint10, kRgb12};
    case 3:
      return {kPoint10, kGpsTime11, kRgb12};
    case 4:
      return {kPoint10, kGpsTime11, kWavePacket13};
    case 5:
      return {kPoint10, kGpsTime11, kRgb12, kWavePacket13};
    case 6:
      return {kPoint14};
    case 7:
      return {kPoint14, kRgb14};
    case 8:
      return {kPoint14, kRgbNir14};
    case 9:
      return {kPoint14, kWavePacket14};
    default:
      return {kPoint14, kRgbNir14, kWavePacket14};
  }
}

/// Bytes of an item; 0 for extra bytes, which have any length.
std::size_t item_bytes(std::uint16_t type) {
  switch (type) {
    case kPoint10:
      return 20;
    case kGpsTime11:
    case kRgbNir14:
      return 8;
    case kRgb12:
    case kRgb14:
      return 6;
    case kWavePacket13:
    case kWavePacket14:
      return 29;
    case kPoint14:
      return 30;
    default:
      return 0;
  }
}

/// Number of layers an item adds to a layered chunk.
std::size_t layers_of(const LazVlr::Item& item) {
  switch (item.type) {
    case kPoint14:
      return 9;
    case kRgbNir14:
      return 2;
    case kByte14:
      return item.size;
    default:
      return 1;
  }
}

[[noreturn]] void fail(const std::string& name, const std::string& what) {
  throw InputError(
      name, "has a LASzip record (22204) that " + what + "; download it again or make it anew");
}

void check_items(const LazVlr& record, const LasInfo& info, const std::string& name) {
  const std::vector<std::uint16_t> expected = items_of_format(info.point_format);
  const bool extra = info.extra_stride > 0;
  const std::size_t wanted = expected.size() + (extra ? 1 : 0);
  const std::uint16_t extra_type = info.point_format < 6 ? kByte : kByte14;
  bool matches = record.items.size() == wanted;
  for (std::size_t i = 0; matches && i < wanted; ++i) {
    const LazVlr::Item& item = record.items[i];
    matches = i < expected.size() ? item.type == expected[i] && item.size == item_bytes(expected[i])
                                  : item.type == extra_type && item.size == info.extra_stride;
  }
  if (!matches) {
    fail(name, "does not describe point format " + std::to_string(info.point_format) + " with " +
                   std::to_string(info.record_bytes) + " bytes a record");
  }
}

}  // namespace

LazVlr parse_laz_vlr(const LasInfo& info, const std::string& name) {
  const LasVlr* vlr = find_vlr(info, "laszip encoded", 22204);
  if (vlr == nullptr) fail(name, "is missing");
  const std::span<const std::uint8_t> bytes(vlr->data);
  if (bytes.size() < kFixedBytes) fail(name, "is cut short");
  LazVlr record;
  record.compressor = load_le<std::uint16_t>(bytes, 0);
  record.chunk_points = load_le<std::uint32_t>(bytes, 12);
  const std::size_t items = load_le<std::uint16_t>(bytes, 32);
  if (record.compressor > LazVlr::kLayered || load_le<std::uint16_t>(bytes, 2) != 0) {
    fail(name, "names the unknown compressor " + std::to_string(record.compressor));
  }
  if (bytes.size() < kFixedBytes + kItemBytes * items) fail(name, "is cut short");
  for (std::size_t i = 0; i < items; ++i) {
    const std::size_t at = kFixedBytes + kItemBytes * i;
    record.items.push_back({load_le<std::uint16_t>(bytes, at),
                            load_le<std::uint16_t>(bytes, at + 2),
                            load_le<std::uint16_t>(bytes, at + 4)});
  }
  check_items(record, info, name);
  const bool layered = record.compressor == LazVlr::kLayered;
  if (record.compressor != LazVlr::kNone && layered != (info.point_format >= 6)) {
    fail(name, "pairs compressor " + std::to_string(record.compressor) + " with point format " +
                   std::to_string(info.point_format));
  }
  // LASzip reads a chunk size of 0 as "variable" too.
  if (record.chunk_points == 0) record.chunk_points = LazVlr::kVariableChunks;
  return record;
}

std::vector<std::uint8_t> encode_laz_vlr(const LazVlr& record) {
  std::vector<std::uint8_t> bytes;
  append_le<std::uint16_t>(bytes, record.compressor);
  append_le<std::uint16_t>(bytes, 0);  // coder: arithmetic
  append_le<std::uint8_t>(bytes, 3);   // LASzip version 3.4 revision 3
  append_le<std::uint8_t>(bytes, 4);
  append_le<std::uint16_t>(bytes, 3);
  append_le<std::uint32_t>(bytes, 0);  // options
  append_le<std::uint32_t>(bytes, record.chunk_points);
  append_le<std::int64_t>(bytes, -1);  // special extended records: none
  append_le<std::int64_t>(bytes, -1);
  append_le<std::uint16_t>(bytes, static_cast<std::uint16_t>(record.items.size()));
  for (const LazVlr::Item& item : record.items) {
    append_le<std::uint16_t>(bytes, item.type);
    append_le<std::uint16_t>(bytes, item.size);
    append_le<std::uint16_t>(bytes, item.version);
  }
  return bytes;
}

std::size_t layered_head_bytes(const LazVlr& record) {
  std::size_t bytes = 4;
  for (const LazVlr::Item& item : record.items) bytes += item.size + 4 * layers_of(item);
  return bytes;
}

std::optional<LayeredHead> read_layered_head(const LazVlr& record,
                                             std::span<const std::uint8_t> chunk) {
  const std::size_t head_bytes = layered_head_bytes(record);
  if (chunk.size() < head_bytes) return std::nullopt;
  std::size_t at = 0;
  for (const LazVlr::Item& item : record.items) at += item.size;
  LayeredHead head{load_le<std::uint32_t>(chunk, at), head_bytes, {}};
  for (at += 4; at < head_bytes; at += 4) {
    const auto bytes = load_le<std::uint32_t>(chunk, at);
    if (bytes > 0) head.layer_offsets.push_back(head.chunk_bytes);
    head.chunk_bytes += bytes;
  }
  return head;
}

}  // namespace cornice
