// SPDX-License-Identifier: GPL-3.0-or-later
// Variable length records: LAS 1.4 R15, sections 2.5 to 2.7 and table 24 (extra bytes).
#include <algorithm>

#include "core/base/error.h"
#include "core/io/las_header.h"
#include "core/io/little_endian.h"

namespace cornice {
namespace {

constexpr std::size_t kExtraByteRecord = 192;
/// Extended records beyond this (waveforms) are listed without their data.
constexpr std::uint64_t kLargestEvlrData = 64ull << 20;

std::string record_text(std::size_t index, const LasVlr& record) {
  // User ids come from the file: anything but plain text would tear a one-line message.
  std::string user = record.user_id;
  std::replace_if(
      user.begin(), user.end(), [](unsigned char c) { return c < 32 || c > 126; }, '?');
  return "record " + std::to_string(index + 1) + " ('" + user + "' " +
         std::to_string(record.record_id) + ")";
}

/// Bytes per value of the data types 1-10; 11-30 are pairs and triples of them (withdrawn in 1.4
/// R13 but still met).
std::size_t extra_byte_size(std::uint8_t data_type, std::uint8_t options) {
  constexpr std::size_t kBytes[10] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  if (data_type == 0) return options;
  if (data_type > 30) return 0;
  return kBytes[(data_type - 1) % 10] * ((data_type - 1u) / 10u + 1u);
}

/// The 8 bytes of "any type" as the field's own type.
double load_any(std::span<const std::uint8_t> bytes, std::size_t offset, std::uint8_t data_type) {
  switch ((data_type - 1) % 10) {
    case 8:
    case 9:
      return load_le<double>(bytes, offset);
    case 1:
    case 3:
    case 5:
    case 7:
      return static_cast<double>(load_le<std::int64_t>(bytes, offset));
    default:
      return static_cast<double>(load_le<std::uint64_t>(bytes, offset));
  }
}

ExtraByte load_extra_byte(std::span<const std::uint8_t> bytes) {
  constexpr std::uint8_t kHasNoData = 1u << 0;
  constexpr std::uint8_t kHasScale = 1u << 3;
  constexpr std::uint8_t kHasOffset = 1u << 4;
  ExtraByte field;
  field.data_type = bytes[2];
  const std::uint8_t options = bytes[3];
  field.name = load_text(bytes, 4, 32);
  field.description = load_text(bytes, 160, 32);
  field.size = extra_byte_size(field.data_type, options);
  if (field.data_type == 0) return field;
  if ((options & kHasNoData) != 0) field.no_data = load_any(bytes, 40, field.data_type);
  if ((options & kHasScale) != 0) field.scale = load_le<double>(bytes, 112);
  if ((options & kHasOffset) != 0) field.offset_value = load_le<double>(bytes, 136);
  return field;
}

}  // namespace

void parse_vlrs(ByteSource& source, const std::string& name, std::size_t header_bytes,
                std::uint32_t claimed, LasInfo& info) {
  const std::uint64_t end = info.point_data_offset;
  std::uint64_t at = header_bytes;
  for (std::uint32_t i = 0; i < claimed; ++i) {
    const std::vector<std::uint8_t> head = at + kVlrHeaderBytes <= end
                                               ? read_bytes(source, at, kVlrHeaderBytes)
                                               : std::vector<std::uint8_t>{};
    if (head.size() < kVlrHeaderBytes) {
      info.warnings.push_back("the header announces " + std::to_string(claimed) +
                              " records, only " + std::to_string(i) + " fit before the points");
      return;
    }
    LasVlr record;
    record.user_id = load_text(head, 2, 16);
    record.record_id = load_le<std::uint16_t>(head, 18);
    const std::size_t length = load_le<std::uint16_t>(head, 20);
    record.description = load_text(head, 22, 32);
    at += kVlrHeaderBytes;
    if (at + length > end) {
      info.warnings.push_back(record_text(i, record) + " claims " + std::to_string(length) +
                              " bytes, " + std::to_string(end - at) +
                              " are left before the points; it and what follows is ignored");
      return;
    }
    record.data = read_bytes(source, at, length);
    if (record.data.size() < length) {
      throw InputError(name, "ends inside " + record_text(i, record) + " at byte " +
                                 std::to_string(at) + "; download or copy it again");
    }
    at += length;
    info.vlrs.push_back(std::move(record));
  }
}

void parse_evlrs(ByteSource& source, std::uint64_t start, std::uint32_t claimed, LasInfo& info) {
  if (claimed == 0) return;
  if (start < info.point_data_offset ||
      start > source.size() - std::min<std::uint64_t>(source.size(), kEvlrHeaderBytes)) {
    info.warnings.push_back("the header announces " + std::to_string(claimed) +
                            " extended records at byte " + std::to_string(start) +
                            " where the file has none; they are ignored");
    return;
  }
  info.point_data_end = start;
  std::uint64_t at = start;
  for (std::uint32_t i = 0; i < claimed; ++i) {
    const std::vector<std::uint8_t> head = read_bytes(source, at, kEvlrHeaderBytes);
    if (head.size() < kEvlrHeaderBytes) {
      info.warnings.push_back("the header announces " + std::to_string(claimed) +
                              " extended records, the file ends after " + std::to_string(i));
      return;
    }
    LasVlr record;
    record.extended = true;
    record.user_id = load_text(head, 2, 16);
    record.record_id = load_le<std::uint16_t>(head, 18);
    const auto length = load_le<std::uint64_t>(head, 20);
    record.description = load_text(head, 28, 32);
    at += kEvlrHeaderBytes;
    if (length > source.size() - at) {
      info.warnings.push_back("extended " + record_text(i, record) + " claims " +
                              std::to_string(length) + " bytes, the file has " +
                              std::to_string(source.size() - at) + "; it is ignored");
      return;
    }
    if (length <= kLargestEvlrData) {
      record.data = read_bytes(source, at, static_cast<std::size_t>(length));
    } else {
      info.warnings.push_back("extended " + record_text(i, record) + " of " +
                              std::to_string(length >> 20) + " MiB is listed without its data");
    }
    at += length;
    info.vlrs.push_back(std::move(record));
  }
}

void parse_extra_bytes(LasInfo& info) {
  std::size_t offset = 0;
  for (const LasVlr& record : info.vlrs) {
    if (record.user_id != "LASF_Spec" || record.record_id != 4) continue;
    if (record.data.size() % kExtraByteRecord != 0) {
      info.warnings.push_back("the record of extra bytes has " +
                              std::to_string(record.data.size()) +
                              " bytes, no multiple of 192; its end is ignored");
    }
    const std::span<const std::uint8_t> all(record.data);
    for (std::size_t at = 0; at + kExtraByteRecord <= all.size(); at += kExtraByteRecord) {
      ExtraByte field = load_extra_byte(all.subspan(at, kExtraByteRecord));
      if (field.size == 0 || offset + field.size > info.extra_stride) {
        info.warnings.push_back("extra bytes are described that the records of " +
                                std::to_string(info.record_bytes) +
                                " bytes have no room for; they are ignored");
        return;
      }
      field.offset = offset;
      offset += field.size;
      info.extra_bytes.push_back(std::move(field));
    }
  }
}

const LasVlr* find_vlr(const LasInfo& info, const std::string& user_id, std::uint16_t record_id) {
  for (const LasVlr& record : info.vlrs) {
    if (record.user_id == user_id && record.record_id == record_id && !record.data.empty()) {
      return &record;
    }
  }
  return nullptr;
}

}  // namespace cornice
