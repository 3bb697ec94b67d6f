// SPDX-License-Identifier: GPL-3.0-or-later
// Everything that one pass over the points of a file tells.
#pragma once

#include <cstdint>
#include <vector>

#include "core/points/point_cloud.h"
#include "stages/info/copy_counter.h"
#include "stages/info/facts.h"
#include "stages/info/line_table.h"
#include "stages/info/occupancy.h"

namespace cornice::info {

/// Attributes that PointStatistics looks at.
inline constexpr Attribute kExamined =
    Attribute::kExact | Attribute::kGpsTime | Attribute::kScanAngle | Attribute::kReturns |
    Attribute::kClassification | Attribute::kFlags | Attribute::kPointSource | Attribute::kChannel |
    Attribute::kIntensity;

/// Gathers facts chunk by chunk, in file order. One thread at a time.
class PointStatistics {
 public:
  explicit PointStatistics(const LasInfo& header);
  void add(const PointCloud& chunk);
  /// Fills the facts that come from points.
  void finish(PointFacts& facts);

 private:
  void add_fields(const PointCloud& chunk, std::size_t i);
  void add_time(const PointCloud& chunk, std::size_t i);
  void add_place(const PointCloud& chunk, std::size_t i);
  void finish_angles(PointFacts& facts) const;
  void finish_density(PointFacts& facts) const;

  /// What a pulse and its place are told by.
  struct Pulse {
    double time_s = 0.0;
    std::uint16_t point_source_id = 0;
    std::uint8_t channel = 0;
    std::uint8_t return_number = 0;
    Vec3<std::int32_t> place;
  };

  LasInfo header_;
  bool has_time_;
  double angle_unit_deg_;
  PointFacts facts_;
  std::vector<std::uint8_t> angle_seen_;  ///< by stored angle + 32768
  std::int32_t ground_min_, ground_max_;
  bool any_point_ = false;
  Pulse previous_;
  double metres_x_, metres_y_;  ///< per unit at this latitude
  Occupancy occupancy_;
  CopyCounter copies_;
  LineTable lines_;
};

}  // namespace cornice::info
