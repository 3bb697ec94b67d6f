// SPDX-License-Identifier: GPL-3.0-or-later
// How far normals agree with the truth.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/vec.h"

namespace cornice::bench {

/// Classes of the true slope; the last are overhang faces, whose normal points below the horizon.
constexpr std::array<const char*, 4> kSlopeNames{"0-30 deg", "30-60 deg", "60-90 deg", "overhang"};

struct ClassScore {
  std::size_t points = 0;
  std::size_t right = 0;      ///< settled, and on the same side as the truth
  std::size_t unsettled = 0;  ///< these count as not right
  /// Of settled points, between the lines along both normals, side aside; degrees at the median,
  /// 95 % and 99 %.
  std::array<double, 3> angle_deg{};

  double right_share() const {
    return points > 0 ? static_cast<double>(right) / static_cast<double>(points) : 1.0;
  }
  double unsettled_share() const {
    return points > 0 ? static_cast<double>(unsettled) / static_cast<double>(points) : 0.0;
  }
};

struct Score {
  std::string run, method;
  ClassScore all;
  std::array<ClassScore, 4> by_slope;
  const ClassScore& overhang() const { return by_slope.back(); }
};

/// Index in kSlopeNames.
std::size_t slope_class(Vec3f true_normal);

/// All arrays have N entries.
Score score(const std::string& run, const std::string& method, const std::vector<Vec3f>& truth,
            const std::vector<Vec3f>& normals, const std::vector<std::uint8_t>& settled);

/// One table of all runs and methods, as text.
std::string table(const std::vector<Score>& scores);

/// The same as a JSON array.
std::string table_json(const std::vector<Score>& scores);

}  // namespace cornice::bench
