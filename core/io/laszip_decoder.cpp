// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/laszip_decoder.h"

#include <laszip/laszip_api.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <istream>
#include <optional>

#include "core/base/parallel.h"
#include "core/io/laszip_stream.h"

namespace cornice {
namespace {

std::uint32_t layers_for(Attribute attributes) {
  const auto layer = [&](Attribute attribute, std::uint32_t mask) {
    return has(attributes, attribute) ? mask : 0u;
  };
  return laszip_DECOMPRESS_SELECTIVE_Z |
         layer(Attribute::kClassification, laszip_DECOMPRESS_SELECTIVE_CLASSIFICATION) |
         layer(Attribute::kFlags, laszip_DECOMPRESS_SELECTIVE_FLAGS) |
         layer(Attribute::kIntensity, laszip_DECOMPRESS_SELECTIVE_INTENSITY) |
         layer(Attribute::kScanAngle, laszip_DECOMPRESS_SELECTIVE_SCAN_ANGLE) |
         layer(Attribute::kUserData, laszip_DECOMPRESS_SELECTIVE_USER_DATA) |
         layer(Attribute::kPointSource, laszip_DECOMPRESS_SELECTIVE_POINT_SOURCE) |
         layer(Attribute::kGpsTime, laszip_DECOMPRESS_SELECTIVE_GPS_TIME) |
         layer(Attribute::kColor,
               laszip_DECOMPRESS_SELECTIVE_RGB | laszip_DECOMPRESS_SELECTIVE_NIR) |
         layer(Attribute::kWaveform, laszip_DECOMPRESS_SELECTIVE_WAVEPACKET) |
         layer(Attribute::kExtraBytes, laszip_DECOMPRESS_SELECTIVE_EXTRA_BYTES);
}

std::uint8_t legacy_flags(const laszip_point_struct& p) {
  return static_cast<std::uint8_t>(
      (p.synthetic_flag ? kSynthetic : 0) | (p.keypoint_flag ? kKeyPoint : 0) |
      (p.withheld_flag ? kWithheld : 0) | (p.classification == 12 ? kOverlap : 0) |
      (p.scan_direction_flag ? kScanDirection : 0) |
      (p.edge_of_flight_line ? kEdgeOfFlightLine : 0));
}

std::uint8_t extended_flags(const laszip_point_struct& p) {
  // Bits 0 to 3 are synthetic, key point, withheld and overlap in both.
  return static_cast<std::uint8_t>(p.extended_classification_flags |
                                   (p.scan_direction_flag ? kScanDirection : 0) |
                                   (p.edge_of_flight_line ? kEdgeOfFlightLine : 0));
}

/// Writes decoded records to the arrays of a cloud.
class Scatter {
 public:
  Scatter(PointCloud& to, const LasInfo& info, Attribute attributes, Vec3d origin)
      : to_(to),
        scale_(info.scale),
        offset_(info.offset),
        origin_(origin),
        legacy_(info.point_format < 6),
        has_nir_(info.point_format == 8 || info.point_format == 10),
        attributes_(attributes) {}

  void put(std::size_t i, const laszip_point_struct& p) const {
    to_.positions[i] = {static_cast<float>(p.X * scale_.x + offset_.x - origin_.x),
                        static_cast<float>(p.Y * scale_.y + offset_.y - origin_.y),
                        static_cast<float>(p.Z * scale_.z + offset_.z - origin_.z)};
    if (has(attributes_, Attribute::kExact)) to_.exact[i] = {p.X, p.Y, p.Z};
    if (has(attributes_, Attribute::kGpsTime)) to_.gps_time_s[i] = p.gps_time;
    if (has(attributes_, Attribute::kPointSource)) to_.point_source_id[i] = p.point_source_ID;
    if (has(attributes_, Attribute::kUserData)) to_.user_data[i] = p.user_data;
    if (has(attributes_, Attribute::kIntensity)) to_.intensity[i] = p.intensity;
    legacy_ ? put_legacy(i, p) : put_extended(i, p);
    if (has(attributes_, Attribute::kColor)) {
      to_.rgb[i] = {p.rgb[0], p.rgb[1], p.rgb[2]};
      if (has_nir_) to_.nir[i] = p.rgb[3];
    }
    if (has(attributes_, Attribute::kWaveform)) {
      std::memcpy(to_.wave_packet[i].data(), p.wave_packet, 29);
    }
    if (has(attributes_, Attribute::kExtraBytes)) {
      std::memcpy(to_.extra_bytes.data() + i * to_.extra_stride, p.extra_bytes, to_.extra_stride);
    }
  }

 private:
  void put_legacy(std::size_t i, const laszip_point_struct& p) const {
    if (has(attributes_, Attribute::kScanAngle)) {
      to_.scan_angle_deg[i] = static_cast<float>(p.scan_angle_rank);
    }
    if (has(attributes_, Attribute::kReturns)) {
      to_.return_number[i] = p.return_number;
      to_.return_count[i] = p.number_of_returns;
    }
    if (has(attributes_, Attribute::kClassification)) to_.classification[i] = p.classification;
    if (has(attributes_, Attribute::kFlags)) to_.flags[i] = legacy_flags(p);
    if (has(attributes_, Attribute::kChannel)) to_.scanner_channel[i] = 0;
  }
  void put_extended(std::size_t i, const laszip_point_struct& p) const {
    if (has(attributes_, Attribute::kScanAngle)) {
      constexpr double kDegreesPerStep = 0.006;  // LAS 1.4 R15, table 13
      to_.scan_angle_deg[i] = static_cast<float>(p.extended_scan_angle * kDegreesPerStep);
    }
    if (has(attributes_, Attribute::kReturns)) {
      to_.return_number[i] = p.extended_return_number;
      to_.return_count[i] = p.extended_number_of_returns;
    }
    if (has(attributes_, Attribute::kClassification)) {
      to_.classification[i] = p.extended_classification;
    }
    if (has(attributes_, Attribute::kFlags)) to_.flags[i] = extended_flags(p);
    if (has(attributes_, Attribute::kChannel)) to_.scanner_channel[i] = p.extended_scanner_channel;
  }

  PointCloud& to_;
  Vec3d scale_;
  Vec3d offset_;
  Vec3d origin_;
  bool legacy_;
  bool has_nir_;
  Attribute attributes_;
};

std::string error_of(laszip_POINTER handle) {
  laszip_CHAR* message = nullptr;
  if (handle == nullptr || laszip_get_error(handle, &message) != 0 || message == nullptr) return "";
  std::string line(message);
  std::replace(line.begin(), line.end(), '\n', ' ');
  return line;
}

}  // namespace

/// One LASzip reader and the stream it reads.
struct LaszipDecoder::Session {
  Session(const PointChunk& c, std::vector<std::uint8_t> head, std::span<const std::uint8_t> body)
      : chunk(c), buffer(std::move(head), body), stream(&buffer) {
    buffer.set_stream(stream);
  }
  Session(const PointChunk& c, std::vector<std::uint8_t> head, ByteSource& source)
      : chunk(c), buffer(std::move(head), source, c.offset, c.bytes), stream(&buffer) {
    buffer.set_stream(stream);
  }
  ~Session() {
    if (handle == nullptr) return;
    if (opened) laszip_close_reader(handle);
    laszip_destroy(handle);
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  PointChunk chunk;
  SplicedBuffer buffer;
  std::istream stream;
  laszip_POINTER handle = nullptr;
  laszip_point_struct* point = nullptr;
  std::uint64_t done = 0;  ///< points decoded
  bool opened = false;
};

Attribute attributes_in(const LasInfo& info, Attribute attributes) {
  const int f = info.point_format;
  auto bits = static_cast<std::uint32_t>(attributes);
  const auto drop = [&](Attribute a) { bits &= ~static_cast<std::uint32_t>(a); };
  if (!(f == 2 || f == 3 || f == 5 || f == 7 || f == 8 || f == 10)) drop(Attribute::kColor);
  if (!(f == 4 || f == 5 || f == 9 || f == 10)) drop(Attribute::kWaveform);
  if (info.extra_stride == 0) drop(Attribute::kExtraBytes);
  return static_cast<Attribute>(bits);
}

void resize_points(PointCloud& points, std::size_t count, const LasInfo& info, Attribute attributes,
                   int threads) {
  std::vector<std::function<void()>> resizes;
  const auto resize = [&](Attribute attribute, auto& array) {
    if (has(attributes, attribute)) resizes.emplace_back([&array, count] { array.resize(count); });
  };
  resizes.emplace_back([&] { points.positions.resize(count); });
  resize(Attribute::kExact, points.exact);
  resize(Attribute::kGpsTime, points.gps_time_s);
  resize(Attribute::kScanAngle, points.scan_angle_deg);
  resize(Attribute::kReturns, points.return_number);
  resize(Attribute::kReturns, points.return_count);
  resize(Attribute::kClassification, points.classification);
  resize(Attribute::kFlags, points.flags);
  resize(Attribute::kPointSource, points.point_source_id);
  resize(Attribute::kChannel, points.scanner_channel);
  resize(Attribute::kUserData, points.user_data);
  resize(Attribute::kIntensity, points.intensity);
  resize(Attribute::kColor, points.rgb);
  if (info.point_format == 8 || info.point_format == 10) resize(Attribute::kColor, points.nir);
  resize(Attribute::kWaveform, points.wave_packet);
  if (has(attributes, Attribute::kExtraBytes)) {
    points.extra_stride = info.extra_stride;
    resizes.emplace_back([&] { points.extra_bytes.resize(count * info.extra_stride); });
  }
  // The first touch of fresh memory costs as much as a good part of the decoding.
  parallel_for(resizes.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) resizes[i]();
  });
}

LaszipDecoder::LaszipDecoder(const LasInfo& info, const LazVlr& laz, Attribute attributes,
                             Vec3d origin)
    : info_(info), laz_(laz), attributes_(attributes), origin_(origin) {}

LaszipDecoder::~LaszipDecoder() = default;

std::string LaszipDecoder::check(const PointChunk& chunk, ByteSource& source,
                                 std::uint64_t start) const {
  if (laz_.compressor == LazVlr::kNone) return "";
  std::vector<std::uint64_t> coded{info_.record_bytes};  // behind the first record
  if (laz_.compressor == LazVlr::kLayered) {
    const std::optional<LayeredHead> head =
        read_layered_head(laz_, read_bytes(source, start, layered_head_bytes(laz_)));
    if (!head) return "has " + std::to_string(chunk.bytes) + " bytes, too few for its head";
    if (head->points < chunk.points) {
      return "says it holds " + std::to_string(head->points) + " points";
    }
    if (head->chunk_bytes > chunk.bytes) {
      return "claims " + std::to_string(head->chunk_bytes) + " bytes, it has " +
             std::to_string(chunk.bytes);
    }
    coded = head->layer_offsets;
  }
  // Arithmetic coders start below 0xffffffff. LASzip relies on it: from there it would read tables
  // beyond their ends.
  const std::vector<std::uint8_t> impossible(4, 0xff);
  for (const std::uint64_t offset : coded) {
    if (read_bytes(source, start + offset, 4) == impossible) {
      return "is damaged " + std::to_string(offset) + " bytes behind its start";
    }
  }
  return "";
}

LazVlr LaszipDecoder::record_for(const PointChunk& chunk) const {
  LazVlr record = laz_;
  const bool is_one_chunk =
      laz_.chunk_points == LazVlr::kVariableChunks || chunk.points <= laz_.chunk_points;
  if (is_one_chunk) {
    record.chunk_points = static_cast<std::uint32_t>(
        std::clamp<std::uint64_t>(chunk.points, 1, LazVlr::kVariableChunks - 1));
  }
  return record;
}

std::string LaszipDecoder::open(const PointChunk& chunk, std::span<const std::uint8_t> bytes) {
  MemorySource memory(bytes);
  if (std::string wrong = check(chunk, memory, 0); !wrong.empty()) return wrong;
  return start(std::make_unique<Session>(
      chunk, laszip_header(info_, record_for(chunk), chunk.points), bytes));
}

std::string LaszipDecoder::open_stream(const PointChunk& chunk, ByteSource& source) {
  if (std::string wrong = check(chunk, source, chunk.offset); !wrong.empty()) return wrong;
  return start(std::make_unique<Session>(
      chunk, laszip_header(info_, record_for(chunk), chunk.points), source));
}

std::string LaszipDecoder::start(std::unique_ptr<Session> session) {
  session_ = std::move(session);
  problem_.clear();
  Session& s = *session_;
  laszip_BOOL compressed = 0;
  if (laszip_create(&s.handle) != 0) return "cannot be decoded: LASzip does not start";
  laszip_decompress_selective(s.handle, layers_for(attributes_));
  if (laszip_open_reader_stream(s.handle, s.stream, &compressed) != 0) {
    return "cannot be decoded (" + error_of(s.handle) + ")";
  }
  s.opened = true;
  laszip_get_point_pointer(s.handle, &s.point);
  return "";
}

std::size_t LaszipDecoder::decode(PointCloud& to, std::size_t at, std::size_t count,
                                  StoredBounds& bounds) {
  const Scatter scatter(to, info_, attributes_, origin_);
  Session& s = *session_;
  StoredBounds local = bounds;  // in registers while the loop runs
  std::size_t i = 0;
  for (; i < count; ++i) {
    if (laszip_read_point(s.handle) != 0) {
      problem_ = "cannot be decoded from point " + std::to_string(s.chunk.first + s.done + i) +
                 " on (" + error_of(s.handle) + ")";
      break;
    }
    local.add(Vec3<std::int32_t>{s.point->X, s.point->Y, s.point->Z});
    scatter.put(at + i, *s.point);
  }
  s.done += i;
  bounds = local;
  return i;
}

}  // namespace cornice
