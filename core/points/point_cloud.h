// SPDX-License-Identifier: GPL-3.0-or-later
// Point clouds as structures of arrays: positions always, other attributes where asked for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/vec.h"

namespace cornice {

/// Attributes a reader fills besides the positions. Combine with |.
enum class Attribute : std::uint32_t {
  kNone = 0,
  kExact = 1u << 0,           ///< integer coordinates as stored
  kGpsTime = 1u << 1,         ///< seconds, of the type the header says
  kScanAngle = 1u << 2,       ///< degrees
  kReturns = 1u << 3,         ///< return number and number of returns
  kClassification = 1u << 4,  ///< class code
  kFlags = 1u << 5,           ///< PointFlag bits
  kPointSource = 1u << 6,     ///< point source id
  kChannel = 1u << 7,         ///< scanner channel
  kUserData = 1u << 8,
  kIntensity = 1u << 9,
  kColor = 1u << 10,       ///< red, green, blue (and nir where the format has it)
  kExtraBytes = 1u << 11,  ///< raw bytes behind each record, as described by the header
  kWaveform = 1u << 12,    ///< the 29 bytes of the wave packet descriptor
  kAll = (1u << 13) - 1,
};
constexpr Attribute operator|(Attribute a, Attribute b) {
  return static_cast<Attribute>(static_cast<std::uint32_t>(a) | static_cast<std::uint32_t>(b));
}
/// True where every attribute of `wanted` is in `set`.
constexpr bool has(Attribute set, Attribute wanted) {
  return (static_cast<std::uint32_t>(set) & static_cast<std::uint32_t>(wanted)) ==
         static_cast<std::uint32_t>(wanted);
}

/// Bits of PointCloud::flags; the same for old and new point formats.
enum PointFlag : std::uint8_t {
  kSynthetic = 1u << 0,
  kKeyPoint = 1u << 1,
  kWithheld = 1u << 2,
  kOverlap = 1u << 3,  ///< class 12 of formats 0-5 also sets it
  kScanDirection = 1u << 4,
  kEdgeOfFlightLine = 1u << 5,
};

/// N points. Every filled array has N entries (rgb, nir likewise); arrays not asked for are empty.
struct PointCloud {
  Vec3d origin;                  ///< projected CRS, metres; positions are relative to it
  std::vector<Vec3f> positions;  ///< metres, relative to origin
  std::vector<Vec3<std::int32_t>>
      exact;  ///< stored integers: coordinate = integer * scale + offset
  std::vector<double> gps_time_s;
  std::vector<float> scan_angle_deg;  ///< sign as stored, see DATA notes: not reliable
  std::vector<std::uint8_t> return_number;
  std::vector<std::uint8_t> return_count;
  std::vector<std::uint8_t> classification;
  std::vector<std::uint8_t> flags;  ///< PointFlag bits
  std::vector<std::uint16_t> point_source_id;
  std::vector<std::uint8_t> scanner_channel;
  std::vector<std::uint8_t> user_data;
  std::vector<std::uint16_t> intensity;
  std::vector<std::array<std::uint16_t, 3>> rgb;
  std::vector<std::uint16_t> nir;
  std::vector<std::array<std::uint8_t, 29>> wave_packet;
  std::size_t extra_stride = 0;           ///< extra bytes per point
  std::vector<std::uint8_t> extra_bytes;  ///< N * extra_stride bytes

  std::size_t size() const { return positions.size(); }
  bool empty() const { return positions.empty(); }
  Vec3d position(std::size_t i) const { return origin + positions[i].cast<double>(); }
  void clear();
  void reserve(std::size_t n, Attribute attributes);
  /// Appends all points of `other`, which must have the same origin and the same arrays filled.
  void append(const PointCloud& other);
  /// Keeps the points whose entry in `keep` is not 0, in order. keep.size() == size().
  void filter(const std::vector<std::uint8_t>& keep);
  /// Bytes held by the arrays.
  std::size_t memory_bytes() const;
};

}  // namespace cornice
