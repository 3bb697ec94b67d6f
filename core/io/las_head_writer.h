// SPDX-License-Identifier: GPL-3.0-or-later
// The bytes of a LAS file before its points: header and variable length records. Format: ASPRS,
// LAS Specification 1.4 R15 (2019), and its predecessors 1.0 to 1.3.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/base/vec.h"
#include "core/io/las.h"

namespace cornice {

/// What a header says of its points; gathered while they are written.
struct LasTally {
  std::uint64_t points = 0;
  std::array<std::uint64_t, 16> by_return{};  ///< index: return number; [0] is not in the header
  Vec3<std::int32_t> min{std::numeric_limits<std::int32_t>::max(),
                         std::numeric_limits<std::int32_t>::max(),
                         std::numeric_limits<std::int32_t>::max()};
  Vec3<std::int32_t> max{std::numeric_limits<std::int32_t>::min(),
                         std::numeric_limits<std::int32_t>::min(),
                         std::numeric_limits<std::int32_t>::min()};

  void add(Vec3<std::int32_t> p, unsigned return_number) {
    ++points;
    ++by_return[return_number & 15u];
    min = {std::min(min.x, p.x), std::min(min.y, p.y), std::min(min.z, p.z)};
    max = {std::max(max.x, p.x), std::max(max.y, p.y), std::max(max.z, p.z)};
  }
  void add(const LasTally& other) {
    points += other.points;
    for (std::size_t i = 0; i < by_return.size(); ++i) by_return[i] += other.by_return[i];
    min = {std::min(min.x, other.min.x), std::min(min.y, other.min.y),
           std::min(min.z, other.min.z)};
    max = {std::max(max.x, other.max.x), std::max(max.y, other.max.y),
           std::max(max.z, other.max.z)};
  }
};

/// Throws UsageError for a version, format, scale, chunk size or extra-byte layout that does not
/// exist, naming it and what would.
void check_las_write_options(const LasWriteOptions& options);

/// Bytes of one extra attribute: those of its type, or its own size for raw bytes.
std::size_t extra_byte_size(const ExtraByte& attribute);

/// Bytes of all extra attributes.
std::size_t extra_stride_of(const std::vector<ExtraByte>& extra_bytes);

/// Header and records of one file, in two goes: the size is fixed from the start, the numbers that
/// only the points tell are filled in at the end.
class LasHead {
 public:
  /// `leading` records come first (COPC), `trailing` last (LASzip). Throws UsageError where a
  /// record does not fit.
  LasHead(const LasWriteOptions& options, std::vector<LasVlr> leading,
          std::vector<LasVlr> trailing);

  std::size_t size() const { return size_; }
  /// Records for the end of the file, after the points.
  const std::vector<LasVlr>& extended() const { return extended_; }
  /// Bytes of the extended records as they stand in the file.
  std::vector<std::uint8_t> extended_bytes() const;
  /// The whole head. `extended_at`: offset in the file of the first extended record, if any.
  std::vector<std::uint8_t> bytes(const LasTally& tally, std::uint64_t extended_at) const;
  /// As above, with `replaced` in place of the first leading record's data; of the same size, or
  /// empty to keep it.
  std::vector<std::uint8_t> bytes(const LasTally& tally, std::uint64_t extended_at,
                                  const std::vector<std::uint8_t>& replaced) const;
  /// Puts a record before all other extended ones.
  void prepend_extended(LasVlr record) { extended_.insert(extended_.begin(), std::move(record)); }

 private:
  LasWriteOptions options_;
  std::vector<LasVlr> records_;
  std::vector<LasVlr> extended_;
  std::size_t size_ = 0;
};

}  // namespace cornice
