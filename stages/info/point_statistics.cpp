// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/info/point_statistics.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/base/random.h"

namespace cornice::info {
namespace {

constexpr double kExtendedAngleUnit = 0.006;    // degrees, formats 6 to 10
constexpr double kMetresPerDegree = 111'320.0;  // of latitude; 0.5 % at most off, for densities
constexpr double kSmallestCell_m = 0.5;
/// Points a cell on average from which a cell's own emptiness is no matter (Poisson: e^-8).
constexpr double kPointsPerCell = 8.0;
constexpr int kVirtualClass = 66;
constexpr int kGroundClass = 2;
constexpr int kAngleBias = 32768;
constexpr double kWeekSeconds = 604'800.0;
/// Adjusted time reaches this in 2043; unadjusted time passed it in 2011.
constexpr double kUnadjustedFrom_s = 1e9;

bool has_gps_time(int format) { return format != 0 && format != 2; }

/// Metres per unit along x and y: of a map the same, of degrees by latitude.
std::pair<double, double> metres_per_unit(const LasInfo& header) {
  const double unit = header.crs.empty() ? 1.0 : header.crs.metres_per_unit;
  if (unit > 0.0) return {unit, unit};
  const double latitude_deg =
      std::clamp((header.bounds.min.y + header.bounds.max.y) / 2, -89.0, 89.0);
  return {kMetresPerDegree * std::cos(latitude_deg * 3.14159265358979 / 180.0), kMetresPerDegree};
}

void widen(std::optional<double>& low, std::optional<double>& high, double value) {
  low = low ? std::min(*low, value) : value;
  high = high ? std::max(*high, value) : value;
}

TimeKind judged_kind(const TimeFacts& time) {
  if (!time.good_max_s) return TimeKind::kNone;
  if (*time.good_max_s <= kWeekSeconds) return TimeKind::kWeekSeconds;
  return *time.good_max_s < kUnadjustedFrom_s ? TimeKind::kAdjustedStandard : TimeKind::kStandard;
}

}  // namespace

PointStatistics::PointStatistics(const LasInfo& header)
    : header_(header),
      has_time_(has_gps_time(header.point_format)),
      angle_unit_deg_(header.point_format >= 6 ? kExtendedAngleUnit : 1.0),
      angle_seen_(2 * kAngleBias),
      ground_min_(std::numeric_limits<std::int32_t>::max()),
      ground_max_(std::numeric_limits<std::int32_t>::min()),
      metres_x_(metres_per_unit(header).first),
      metres_y_(metres_per_unit(header).second),
      occupancy_(kSmallestCell_m) {
  facts_.time.has_field = has_time_;
  facts_.time.header_type = header.gps_time_type;
  facts_.angle.unit_deg = angle_unit_deg_;
  facts_.intensity_min = std::numeric_limits<std::uint16_t>::max();
}

void PointStatistics::add(const PointCloud& chunk) {
  for (std::size_t i = 0; i < chunk.size(); ++i) {
    add_fields(chunk, i);
    add_time(chunk, i);
    add_place(chunk, i);
  }
}

void PointStatistics::add_fields(const PointCloud& chunk, std::size_t i) {
  const std::uint8_t number = chunk.return_number[i];
  const std::uint8_t count = chunk.return_count[i];
  const std::uint8_t code = chunk.classification[i];
  const std::uint8_t flags = chunk.flags[i];
  ++facts_.classes[code];
  ++facts_.by_return[number & 15u];
  ++facts_.by_return_count[count & 15u];
  ++facts_.by_channel[chunk.scanner_channel[i] & 3u];
  facts_.return_above_count += number > count ? 1 : 0;
  facts_.return_zero += number == 0 && code != kVirtualClass ? 1 : 0;
  facts_.withheld += (flags & kWithheld) != 0 ? 1 : 0;
  facts_.overlap += (flags & kOverlap) != 0 ? 1 : 0;
  facts_.synthetic += (flags & kSynthetic) != 0 ? 1 : 0;
  facts_.key_points += (flags & kKeyPoint) != 0 ? 1 : 0;
  facts_.intensity_min = std::min<int>(facts_.intensity_min, chunk.intensity[i]);
  facts_.intensity_max = std::max<int>(facts_.intensity_max, chunk.intensity[i]);
  const float angle = chunk.scan_angle_deg[i];
  const auto stored = static_cast<int>(std::lround(angle / angle_unit_deg_));
  angle_seen_[static_cast<std::size_t>(std::clamp(stored + kAngleBias, 0, 2 * kAngleBias - 1))] = 1;
  facts_.angle.not_representable += std::abs(angle) > 90.0f ? 1 : 0;
}

void PointStatistics::add_time(const PointCloud& chunk, std::size_t i) {
  TimeFacts& time = facts_.time;
  std::optional<double> good;
  if (has_time_) {
    const double t = chunk.gps_time_s[i];
    if (!std::isfinite(t)) {
      ++time.not_finite;
    } else {
      widen(time.min_s, time.max_s, t);
      if (t > 0.0) {
        good = t;
        ++time.good;
        widen(time.good_min_s, time.good_max_s, t);
      } else {
        ++(t == 0.0 ? time.zero : time.negative);
        const bool is_virtual = chunk.classification[i] == kVirtualClass;
        facts_.virtual_without_time += t == 0.0 && is_virtual ? 1 : 0;
      }
    }
  }
  lines_.add(chunk.point_source_id[i], chunk.scanner_channel[i], good);
}

void PointStatistics::add_place(const PointCloud& chunk, std::size_t i) {
  const Vec3<std::int32_t> place = chunk.exact[i];
  occupancy_.add((place.x * header_.scale.x + header_.offset.x) * metres_x_,
                 (place.y * header_.scale.y + header_.offset.y) * metres_y_);
  if (chunk.classification[i] == kGroundClass) {
    ground_min_ = std::min(ground_min_, place.z);
    ground_max_ = std::max(ground_max_, place.z);
  }
  const Pulse pulse{has_time_ ? chunk.gps_time_s[i] : 0.0, chunk.point_source_id[i],
                    chunk.scanner_channel[i], chunk.return_number[i], place};
  const auto bits = [](std::int32_t value) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(value));
  };
  std::uint64_t hash = mix64((bits(place.x) << 32 | bits(place.y)) + 0x9e3779b97f4a7c15ULL);
  hash = mix64(hash + bits(place.z) + (std::uint64_t{pulse.return_number} << 32) +
               (std::uint64_t{pulse.channel} << 40));
  copies_.add(mix64(hash + std::bit_cast<std::uint64_t>(pulse.time_s)));
  const bool same_pulse =
      any_point_ && has_time_ && pulse.time_s == previous_.time_s && pulse.time_s != 0.0 &&
      pulse.point_source_id == previous_.point_source_id && pulse.channel == previous_.channel;
  if (same_pulse && pulse.return_number == previous_.return_number &&
      !(pulse.place == previous_.place)) {
    ++facts_.repeated_return;
  }
  previous_ = pulse;
  any_point_ = true;
}

void PointStatistics::finish_angles(PointFacts& facts) const {
  AngleFacts& angle = facts.angle;
  bool all_whole = true;
  for (int at = 0; at < 2 * kAngleBias; ++at) {
    if (angle_seen_[static_cast<std::size_t>(at)] == 0) continue;
    const double degrees = (at - kAngleBias) * angle_unit_deg_;
    ++angle.distinct;
    widen(angle.min_deg, angle.max_deg, degrees);
    const double off = std::abs(degrees - std::round(degrees));
    all_whole = all_whole && off <= angle_unit_deg_ / 2.0 + 1e-9;
  }
  angle.all_zero = angle.distinct == 1 && *angle.min_deg == 0.0;
  angle.whole_degrees = angle.distinct > 0 && (angle_unit_deg_ == 1.0 || all_whole);
}

void PointStatistics::finish_density(PointFacts& facts) const {
  std::uint64_t points = 0;
  for (const std::uint64_t count : facts.classes) points += count;
  const Occupancy::Cover cover = occupancy_.cover(kPointsPerCell);
  if (static_cast<double>(points) < kPointsPerCell) return;
  facts.cell_m = cover.cell;
  facts.occupied_m2 = static_cast<double>(cover.cells) * cover.cell * cover.cell;
  facts.density_per_m2 = static_cast<double>(points) / facts.occupied_m2;
}

void PointStatistics::finish(PointFacts& facts) {
  // What the caller knows already stays.
  facts_.header = std::move(facts.header);
  facts_.readable = facts.readable;
  facts_.problem = std::move(facts.problem);
  facts_.bounds = facts.bounds;
  facts_.bounds_agree = facts.bounds_agree;
  facts = std::move(facts_);
  if (!any_point_) facts.intensity_min = 0;
  finish_angles(facts);
  finish_density(facts);
  if (ground_min_ <= ground_max_) {
    facts.ground_min_z = ground_min_ * header_.scale.z + header_.offset.z;
    facts.ground_max_z = ground_max_ * header_.scale.z + header_.offset.z;
  }
  const CopyCounter::Count copies = copies_.count();
  facts.copies = copies.copies;
  facts.copies_estimated = copies.estimated;
  facts.lines = lines_.lines();
  facts.lines_complete = lines_.complete();
  facts.time.steps_back = lines_.steps_back();
  facts.time.kind = judged_kind(facts.time);
}

}  // namespace cornice::info
