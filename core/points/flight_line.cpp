// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/flight_line.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cornice {
namespace {

constexpr double kWeek = 604800.0;
constexpr double kRadians = std::numbers::pi / 180.0;
constexpr std::uint32_t kNoGroup = 0xffffffffu;

/// How far outside the line's span a time lies; 0 inside.
double time_outside(const FlightLine& line, double gps_time_s) {
  if (!line.has_time) return 0.0;
  const double t = time_on_line(line, gps_time_s);
  return std::max({line.first_time_s - t, t - line.last_time_s, 0.0});
}

bool is_channel_of(const FlightLine& line, std::uint8_t channel, std::uint8_t user_data) {
  return line.scanner_channel == (line.channel_in_user_data ? user_data : channel);
}

Vec3d beam_from_angle(const FlightLine& line, double scan_angle_deg) {
  const double across = line.across_azimuth_deg * kRadians;
  const double angle = line.scan_angle_sign * scan_angle_deg * kRadians;
  return {std::sin(across) * std::sin(angle), std::cos(across) * std::sin(angle), -std::cos(angle)};
}

}  // namespace

double time_on_line(const FlightLine& line, double gps_time_s) {
  const bool crosses = line.last_time_s > kWeek && line.first_time_s < kWeek;
  // Above 604800 a stored time is no second of the week, so a line that starts there never crosses.
  return crosses && gps_time_s < line.first_time_s - kWeek / 2 ? gps_time_s + kWeek : gps_time_s;
}

std::optional<std::size_t> FlightLines::find(std::uint16_t point_source_id, std::uint8_t channel,
                                             double gps_time_s, double slack_s) const {
  std::optional<std::size_t> best;
  double best_outside = slack_s;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const FlightLine& line = lines[i];
    if (line.point_source_id != point_source_id || line.scanner_channel != channel) continue;
    const double outside = time_outside(line, gps_time_s);
    if (outside < best_outside || (outside <= slack_s && !best)) {
      best = i;
      best_outside = outside;
    }
  }
  return best;
}

LineFinder::LineFinder(const FlightLines& lines, double slack_s)
    : lines_(lines), slack_s_(slack_s), group_of_id_(65536, kNoGroup) {
  for (std::size_t i = 0; i < lines.lines.size(); ++i) {
    const FlightLine& line = lines.lines[i];
    std::uint32_t group = group_of_id_[line.point_source_id];
    while (group != kNoGroup) {
      const FlightLine& other = lines.lines[groups_[group].front()];
      if (other.scanner_channel == line.scanner_channel &&
          other.channel_in_user_data == line.channel_in_user_data)
        break;
      group = next_group_[group];
    }
    if (group == kNoGroup) {
      group = static_cast<std::uint32_t>(groups_.size());
      groups_.emplace_back();
      next_group_.push_back(group_of_id_[line.point_source_id]);
      group_of_id_[line.point_source_id] = group;
    }
    groups_[group].push_back(static_cast<std::uint32_t>(i));
  }
}

std::optional<std::size_t> LineFinder::find(std::uint16_t point_source_id, std::uint8_t channel,
                                            double gps_time_s, std::uint8_t user_data) {
  if (last_) {
    const FlightLine& line = lines_.lines[*last_];
    if (line.point_source_id == point_source_id && is_channel_of(line, channel, user_data) &&
        time_outside(line, gps_time_s) == 0.0)
      return last_;
  }
  std::optional<std::size_t> best;
  double best_outside = slack_s_;
  for (std::uint32_t group = group_of_id_[point_source_id]; group != kNoGroup;
       group = next_group_[group]) {
    if (!is_channel_of(lines_.lines[groups_[group].front()], channel, user_data)) continue;
    for (const std::uint32_t i : groups_[group]) {
      const double outside = time_outside(lines_.lines[i], gps_time_s);
      if (outside < best_outside || (outside <= slack_s_ && !best)) {
        best = i;
        best_outside = outside;
      }
    }
  }
  if (best) last_ = best;
  return best;
}

std::optional<Vec3d> sensor_at(const FlightLine& line, double gps_time_s) {
  const auto& nodes = line.nodes;
  if (nodes.size() < 2) return std::nullopt;
  const double t = time_on_line(line, gps_time_s);
  auto after = std::upper_bound(
      nodes.begin(), nodes.end(), t,
      [](double time, const TrajectoryNode& node) { return time < node.gps_time_s; });
  if (after == nodes.begin()) ++after;
  if (after == nodes.end()) --after;
  const TrajectoryNode& a = *(after - 1);
  const TrajectoryNode& b = *after;
  const double step = b.gps_time_s - a.gps_time_s;
  const double at = (t - a.gps_time_s) / step;
  if (!(at >= -1.0 && at <= 2.0)) return std::nullopt;
  return a.position + (b.position - a.position) * at;
}

Vec3d beam_at(const FlightLine& line, double gps_time_s, Vec3d point, double scan_angle_deg,
              BeamSource* used) {
  BeamSource source = line.beam_source;
  Vec3d beam{0.0, 0.0, -1.0};
  if (source == BeamSource::kTrajectory) {
    if (const auto sensor = sensor_at(line, gps_time_s))
      beam = normalized(point - *sensor);
    else
      source = BeamSource::kAngles;
  }
  if (source == BeamSource::kAngles) {
    if (line.scan_angle_sign != 0)
      beam = beam_from_angle(line, scan_angle_deg);
    else
      source = BeamSource::kVertical;
  }
  if (used != nullptr) *used = source;
  return beam;
}

const char* beam_source_name(BeamSource source) {
  switch (source) {
    case BeamSource::kTrajectory:
      return "trajectory";
    case BeamSource::kAngles:
      return "angles";
    case BeamSource::kVertical:
      break;
  }
  return "vertical";
}

}  // namespace cornice
