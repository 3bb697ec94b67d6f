// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/flightlines/lines_fields.h"

#include <cstdint>
#include <string>

namespace cornice::flightlines {
namespace {

std::int64_t whole(std::uint64_t value) { return static_cast<std::int64_t>(value); }

}  // namespace

Fields line_fields(const LineEstimate& e) {
  const FlightLine& line = e.line;
  return {{"id", std::int64_t(line.id)},
          {"point_source_id", std::int64_t{line.point_source_id}},
          {"scanner_channel", std::int64_t{line.scanner_channel}},
          {"channel_in_user_data", line.channel_in_user_data ? std::int64_t{1} : std::int64_t{0}},
          {"has_time", line.has_time ? std::int64_t{1} : std::int64_t{0}},
          {"first_time_s", line.first_time_s},
          {"last_time_s", line.last_time_s},
          {"along_azimuth_deg", line.along_azimuth_deg},
          {"along_standard_error_deg", e.along_standard_error_deg},
          {"across_azimuth_deg", line.across_azimuth_deg},
          {"across_standard_error_deg", line.across_standard_error_deg},
          {"perpendicular_deg", e.perpendicular_deg},
          {"scan_angle_sign", std::int64_t{line.scan_angle_sign}},
          {"sign_from", e.sign_from},
          {"beam_source", std::string(beam_source_name(line.beam_source))},
          {"beam_reason", line.beam_reason},
          {"method", e.method},
          {"points", whole(e.points)},
          {"pulses_used", whole(e.pulses_used)},
          {"pairs_used", whole(e.pairs_used)},
          {"height_m", e.height_m},
          {"speed_ms", e.speed_ms},
          {"min_angle_deg", e.min_angle_deg},
          {"max_angle_deg", e.max_angle_deg},
          {"pulse_rate_hz", e.pulse_rate_hz},
          {"lean_deg", e.lean_deg},
          {"cone_deg", e.cone_deg},
          {"looks", std::int64_t{e.looks}},
          {"angle_offset_deg", e.angle_offset_deg},
          {"angle_residual_deg", e.angle_residual_deg},
          {"scan_residual_deg", e.scan_residual_deg},
          {"pair_residual", e.pair_residual},
          {"position_error_m", e.position_error_m},
          {"height_error_m", e.height_error_m},
          {"bridged_s", e.bridged_s}};
}

Fields overlap_fields(const OverlapPair& pair) {
  return {{"first_line", std::int64_t(pair.first_line)},
          {"second_line", std::int64_t(pair.second_line)},
          {"median_dz_m", pair.median_dz_m},
          {"spread_m", pair.spread_m},
          {"cells", whole(pair.cells)}};
}

}  // namespace cornice::flightlines
