// SPDX-License-Identifier: GPL-3.0-or-later
// Statistics of differences by the shape of the ground, at a fixed cost in memory.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/vec.h"

namespace cornice::compare {

/// Where a value was measured. Codes index the names of group_names().
struct Place {
  std::uint8_t slope = 0;
  std::uint8_t aspect = 0;
  std::uint8_t curvature = 0;
  std::uint8_t overhang = 0;
};

/// The ways to divide places.
enum class Grouping { kAll, kSlope, kAspect, kCurvature, kOverhang };
inline constexpr std::array<Grouping, 5> kGroupings{
    Grouping::kAll, Grouping::kSlope, Grouping::kAspect, Grouping::kCurvature, Grouping::kOverhang};
const char* grouping_name(Grouping grouping);
const std::vector<std::string>& group_names(Grouping grouping);

/// Slope by the normal's angle from the vertical, 15 degrees a class, beyond 90 the last; aspect by
/// eight directions where the slope is 5 degrees or more; curvature hollow, even or crest, even
/// within 0.1/m.
Place place_of(Vec3f normal, float curvature_per_m, bool overhang);

/// Values of one group.
struct Summary {
  std::uint64_t count = 0;    ///< with a counterpart
  std::uint64_t missing = 0;  ///< without: too far, or past an edge
  double mean = 0.0, rms = 0.0, standard_deviation = 0.0;
  double median = 0.0;
  double nmad = 0.0;  ///< 1.4826 times the median of |value - median|
  double lowest = 0.0, highest = 0.0;
  std::vector<double> percentiles;   ///< at kPercentiles
  std::vector<double> completeness;  ///< share of all, missing ones too, within each tolerance
};
inline constexpr std::array<double, 9> kPercentiles{1, 5, 10, 25, 50, 75, 90, 95, 99};

/// One group: sums, and how many values lie in each bin of a fixed width, so that quantiles need no
/// second pass. A quantile is right to half a bin.
class Distribution {
 public:
  /// Values within +-range; bins of range / 25,000.
  Distribution(double range, const std::vector<double>& tolerances);
  void add(double value);
  void add_missing() { ++missing_; }
  std::uint64_t count() const { return count_; }
  std::uint64_t missing() const { return missing_; }
  Summary summary() const;
  /// Counts over `bars` equal bars of [-limit, limit]; the last ones hold what is beyond.
  std::vector<std::uint64_t> histogram(double limit, int bars) const;
  /// The value below which `share` of all lie.
  double quantile(double share) const;

 private:
  double bin_value(std::size_t bin) const;

  double range_;
  std::vector<double> tolerances_;
  std::vector<std::uint64_t> within_;
  std::vector<std::uint64_t> bins_;
  std::uint64_t count_ = 0, missing_ = 0;
  double sum_ = 0.0, sum_sq_ = 0.0, lowest_ = 0.0, highest_ = 0.0;
};

/// All groups of one measurement.
class Statistics {
 public:
  Statistics(double range, const std::vector<double>& tolerances);
  void add(Place place, double value);
  void add_missing(Place place);
  const Distribution& group(Grouping grouping, std::size_t index) const;
  const Distribution& all() const { return group(Grouping::kAll, 0); }

 private:
  std::array<std::uint8_t, 5> codes(Place place) const;
  std::array<std::vector<Distribution>, 5> groups_;
};

}  // namespace cornice::compare
