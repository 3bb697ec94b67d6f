// SPDX-License-Identifier: GPL-3.0-or-later
// NMAD: Hoehle, Hoehle 2009, "Accuracy assessment of digital elevation models by means of robust
// statistical methods", ISPRS Journal 64(4).
#include "stages/compare/statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cornice::compare {
namespace {

constexpr std::size_t kHalfBins = 25000;
constexpr double kSlopeClassDeg = 15.0;
constexpr double kFlatDeg = 5.0;
constexpr float kEvenPerM = 0.1f;
/// Normal distribution: the standard deviation by the median of absolute deviations.
constexpr double kNmadFactor = 1.4826;

}  // namespace

const char* grouping_name(Grouping grouping) {
  constexpr std::array<const char*, 5> kNames{"all", "slope", "aspect", "curvature", "overhang"};
  return kNames[static_cast<std::size_t>(grouping)];
}

const std::vector<std::string>& group_names(Grouping grouping) {
  static const std::array<std::vector<std::string>, 5> names{
      {{"all"},
       {"0-15", "15-30", "30-45", "45-60", "60-75", "75-90", "over 90"},
       {"flat", "N", "NE", "E", "SE", "S", "SW", "W", "NW"},
       {"hollow", "even", "crest"},
       {"no", "yes"}}};
  return names[static_cast<std::size_t>(grouping)];
}

Place place_of(Vec3f normal, float curvature_per_m, bool overhang) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  const double across = std::hypot(static_cast<double>(normal.x), static_cast<double>(normal.y));
  const double slope_deg = std::atan2(across, static_cast<double>(normal.z)) * kDegrees;
  Place place;
  place.slope = static_cast<std::uint8_t>(std::min(6.0, slope_deg / kSlopeClassDeg));
  if (slope_deg >= kFlatDeg) {
    double azimuth_deg =
        std::atan2(static_cast<double>(normal.x), static_cast<double>(normal.y)) * kDegrees;
    if (azimuth_deg < 0.0) azimuth_deg += 360.0;
    place.aspect = static_cast<std::uint8_t>(1 + static_cast<int>((azimuth_deg + 22.5) / 45.0) % 8);
  }
  place.curvature = curvature_per_m < -kEvenPerM ? 0 : curvature_per_m > kEvenPerM ? 2 : 1;
  place.overhang = overhang ? 1 : 0;
  return place;
}

Distribution::Distribution(double range, const std::vector<double>& tolerances)
    : range_(range), tolerances_(tolerances), within_(tolerances.size(), 0) {}

void Distribution::add(double value) {
  if (bins_.empty()) bins_.assign(2 * kHalfBins + 1, 0);
  lowest_ = count_ == 0 ? value : std::min(lowest_, value);
  highest_ = count_ == 0 ? value : std::max(highest_, value);
  ++count_;
  sum_ += value;
  sum_sq_ += value * value;
  const double at = std::round(value / range_ * static_cast<double>(kHalfBins));
  const double half = static_cast<double>(kHalfBins);
  ++bins_[static_cast<std::size_t>(std::clamp(at, -half, half) + half)];
  for (std::size_t i = 0; i < tolerances_.size(); ++i) {
    if (std::abs(value) <= tolerances_[i]) ++within_[i];
  }
}

double Distribution::bin_value(std::size_t bin) const {
  return (static_cast<double>(bin) - static_cast<double>(kHalfBins)) * range_ /
         static_cast<double>(kHalfBins);
}

double Distribution::quantile(double share) const {
  if (count_ == 0) return 0.0;
  const double wanted = share * static_cast<double>(count_ - 1);
  std::uint64_t below = 0;
  for (std::size_t bin = 0; bin < bins_.size(); ++bin) {
    below += bins_[bin];
    if (static_cast<double>(below) > wanted) return std::clamp(bin_value(bin), lowest_, highest_);
  }
  return highest_;
}

Summary Distribution::summary() const {
  Summary s;
  s.count = count_;
  s.missing = missing_;
  const auto all = static_cast<double>(std::max<std::uint64_t>(1, count_ + missing_));
  for (const std::uint64_t n : within_) s.completeness.push_back(static_cast<double>(n) / all);
  s.percentiles.assign(kPercentiles.size(), 0.0);
  if (count_ == 0) return s;
  const auto n = static_cast<double>(count_);
  s.mean = sum_ / n;
  s.rms = std::sqrt(sum_sq_ / n);
  s.standard_deviation = std::sqrt(std::max(0.0, sum_sq_ / n - s.mean * s.mean));
  s.lowest = lowest_;
  s.highest = highest_;
  for (std::size_t i = 0; i < kPercentiles.size(); ++i) {
    s.percentiles[i] = quantile(kPercentiles[i] / 100.0);
  }
  s.median = quantile(0.5);
  Distribution deviations(2.0 * range_, {});
  deviations.bins_.assign(2 * kHalfBins + 1, 0);
  for (std::size_t bin = 0; bin < bins_.size(); ++bin) {
    if (bins_[bin] == 0) continue;
    const double deviation = std::abs(bin_value(bin) - s.median);
    const double at = std::round(deviation / (2.0 * range_) * static_cast<double>(kHalfBins));
    deviations.bins_[kHalfBins + static_cast<std::size_t>(at)] += bins_[bin];
    deviations.highest_ = std::max(deviations.highest_, deviation);
  }
  deviations.count_ = count_;
  s.nmad = kNmadFactor * deviations.quantile(0.5);
  return s;
}

std::vector<std::uint64_t> Distribution::histogram(double limit, int bars) const {
  std::vector<std::uint64_t> counts(static_cast<std::size_t>(bars), 0);
  for (std::size_t bin = 0; bin < bins_.size(); ++bin) {
    const double at = (bin_value(bin) + limit) / (2.0 * limit) * bars;
    counts[static_cast<std::size_t>(std::clamp(at, 0.0, bars - 1.0))] += bins_[bin];
  }
  return counts;
}

Statistics::Statistics(double range, const std::vector<double>& tolerances) {
  for (std::size_t g = 0; g < kGroupings.size(); ++g) {
    groups_[g].assign(group_names(kGroupings[g]).size(), Distribution(range, tolerances));
  }
}

std::array<std::uint8_t, 5> Statistics::codes(Place place) const {
  return {0, place.slope, place.aspect, place.curvature, place.overhang};
}

void Statistics::add(Place place, double value) {
  const std::array<std::uint8_t, 5> code = codes(place);
  for (std::size_t g = 0; g < code.size(); ++g) groups_[g][code[g]].add(value);
}

void Statistics::add_missing(Place place) {
  const std::array<std::uint8_t, 5> code = codes(place);
  for (std::size_t g = 0; g < code.size(); ++g) groups_[g][code[g]].add_missing();
}

const Distribution& Statistics::group(Grouping grouping, std::size_t index) const {
  return groups_[static_cast<std::size_t>(grouping)][index];
}

}  // namespace cornice::compare
