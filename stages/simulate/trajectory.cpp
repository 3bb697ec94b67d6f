// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/trajectory.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "core/base/error.h"
#include "core/base/random.h"

namespace cornice::simulate {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kGravity = 9.81;

/// Least distance of the aircraft to any ground: below it a swath is too narrow to plan with.
constexpr double kLeastClearanceM = 100.0;
/// Beyond the extent a pass goes on by this much more than the lean of the beams asks for, so that
/// pitch and wander leave no gap.
constexpr double kRunOutM = 40.0;
constexpr double kLargestPitchDeg = 3.0;
/// Step between poses in turns, where nothing is measured.
constexpr double kTurnStepS = 0.1;
/// Gaps longer than this are no turn but a landing: no poses.
constexpr double kLongestTurnS = 3600.0;

/// Unrest of a survey aircraft in calm air, greatest values.
constexpr double kRollDeg = 1.5;
constexpr double kPitchDeg = 1.0;
constexpr double kYawDeg = 1.0;
constexpr double kWanderM = 8.0;
constexpr double kHeaveM = 4.0;
constexpr double kWindMs = 5.0;

double radians(double degrees) { return degrees * (kPi / 180.0); }
double degrees(double radians) { return radians * (180.0 / kPi); }
double wrapped_360(double degrees) { return degrees - 360.0 * std::floor(degrees / 360.0); }
double wrapped_180(double degrees) { return wrapped_360(degrees + 180.0) - 180.0; }

Vec3d azimuth_direction(double azimuth_deg) {
  return {std::sin(radians(azimuth_deg)), std::cos(radians(azimuth_deg)), 0.0};
}

/// A sum of sines with random phases: smooth, never above its amplitude, a function of time alone.
class SmoothNoise {
 public:
  SmoothNoise(std::uint64_t seed, std::uint64_t stream, double amplitude, double shortest_s,
              double longest_s) {
    CounterRandom random(seed, stream, 0);
    for (std::size_t i = 0; i < kTerms; ++i) {
      const double share = (static_cast<double>(i) + random.uniform()) / kTerms;
      frequency_[i] = 2.0 * kPi / (longest_s * std::pow(shortest_s / longest_s, share));
      phase_[i] = 2.0 * kPi * random.uniform();
      amplitude_[i] = amplitude / kTerms;
    }
  }
  double at(double t) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < kTerms; ++i)
      sum += amplitude_[i] * std::sin(frequency_[i] * t + phase_[i]);
    return sum;
  }

 private:
  static constexpr std::size_t kTerms = 5;
  std::array<double, kTerms> frequency_{}, phase_{}, amplitude_{};
};

/// The unrest of one survey flight, as functions of the time since its start.
struct Unrest {
  Unrest(std::uint64_t seed, double scale)
      : roll(seed, 1, scale * kRollDeg, 2.0, 25.0),
        pitch(seed, 2, scale * kPitchDeg, 3.0, 30.0),
        yaw(seed, 3, scale * kYawDeg, 4.0, 40.0),
        east(seed, 4, scale * kWanderM, 15.0, 60.0),
        north(seed, 5, scale * kWanderM, 15.0, 60.0),
        up(seed, 6, scale * kHeaveM, 8.0, 60.0) {}
  Vec3d wander(double t) const { return {east.at(t), north.at(t), up.at(t)}; }
  SmoothNoise roll, pitch, yaw, east, north, up;
};

SensorFrame frame_of(const TrajectoryPose& pose) {
  const double h = radians(pose.heading_deg), p = radians(pose.pitch_deg),
               r = radians(pose.roll_deg);
  const Vec3d ahead{std::sin(h), std::cos(h), 0.0}, side{std::cos(h), -std::sin(h), 0.0},
      up{0.0, 0.0, 1.0};
  // Yaw, then pitch about the right wing, then roll about the nose.
  const Vec3d forward = std::cos(p) * ahead + std::sin(p) * up;
  const Vec3d level_down = std::sin(p) * ahead - std::cos(p) * up;
  return {pose.position, forward, std::cos(r) * side + std::sin(r) * level_down,
          std::cos(r) * level_down - std::sin(r) * side};
}

/// Position, velocity and acceleration on the quintic from (a, va) to (b, vb) in `duration` with
/// no acceleration at either end.
struct TurnPoint {
  Vec3d position, velocity, acceleration;
};
TurnPoint turn_point(Vec3d a, Vec3d va, Vec3d b, Vec3d vb, double duration, double t) {
  const Vec3d chord = b - a - duration * va, dv = duration * (vb - va);
  // q(u) = a + duration va u + c3 u^3 + c4 u^4 + c5 u^5 with q, q', q'' given at u = 1.
  const Vec3d c3 = 10.0 * chord - 4.0 * dv, c4 = -15.0 * chord + 7.0 * dv,
              c5 = 6.0 * chord - 3.0 * dv;
  const double u = t / duration;
  TurnPoint q;
  q.position = a + duration * u * va + u * u * u * (c3 + u * (c4 + u * c5));
  q.velocity = va + (u * u / duration) * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5));
  q.acceleration = (u / (duration * duration)) * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5));
  return q;
}

void check_flight(const FlightOptions& flight) {
  const auto in = [](const char* option, double value, double low, double high) {
    if (value >= low && value <= high) return;
    char text[160];
    std::snprintf(text, sizeof text, "is %g, must be in %g .. %g", value, low, high);
    throw UsageError(option, text);
  };
  in("--azimuth", flight.azimuth_deg, -360.0, 360.0);
  in("--height", flight.height_m, 50.0, 20000.0);
  in("--speed", flight.speed_ms, 10.0, 200.0);
  in("--overlap", 100.0 * flight.overlap, 0.0, 80.0);
  in("--motion", flight.motion, 0.0, 3.0);
  in("--turn", flight.turn_s, 10.0, 3000.0);
  in("--trajectory-step", flight.node_step_s, 0.001, 1.0);
}

}  // namespace

double across_track_angle_deg(const SensorFrame& frame, Vec3d beam) {
  const double length =
      std::sqrt(frame.forward.x * frame.forward.x + frame.forward.y * frame.forward.y);
  const double right = (beam.x * frame.forward.y - beam.y * frame.forward.x) / length;
  return degrees(std::atan2(right, -beam.z));
}

Trajectory Trajectory::plan(const FlightOptions& flight, const ScannerOptions& scanner,
                            const Box2d& extent, const GroundRange& ground, std::uint64_t seed) {
  check_flight(flight);
  check(scanner);
  Trajectory trajectory;
  trajectory.altitude_m_ = ground.mean_m + flight.height_m;
  const double clearance = trajectory.altitude_m_ - ground.highest_m;
  if (clearance < kLeastClearanceM) {
    char text[200];
    std::snprintf(text, sizeof text,
                  "%.0f m above the mean ground passes the highest ground at %.0f m; at least %.0f "
                  "m are needed over this scene",
                  flight.height_m, clearance,
                  std::ceil(ground.highest_m - ground.mean_m + kLeastClearanceM));
    throw UsageError("--height", text);
  }
  trajectory.node_step_s_ = flight.node_step_s;
  trajectory.tan_half_view_ = std::tan(radians(0.5 * scanner.field_of_view_deg()));
  trajectory.pass_spacing_m_ = trajectory.swath_m(ground.highest_m) * (1.0 - flight.overlap);
  trajectory.place_passes(flight, scanner, extent, ground, seed);
  trajectory.fill_poses(flight, seed);
  return trajectory;
}

double Trajectory::swath_m(double ground_m) const {
  return 2.0 * tan_half_view_ * (altitude_m_ - ground_m);
}

double Trajectory::measuring_s() const {
  double sum = 0.0;
  for (const Pass& pass : passes_) sum += pass.last_time_s - pass.first_time_s;
  return sum;
}

/// Passes are members of an endless block: those whose swath on the lowest ground meets the extent
/// are flown. The centre of the extent lies midway between two of them, so that even a small
/// extent sees the overlap.
void Trajectory::place_passes(const FlightOptions& flight, const ScannerOptions& scanner,
                              const Box2d& extent, const GroundRange& ground, std::uint64_t seed) {
  const Vec3d centre{0.5 * (extent.min_x + extent.max_x), 0.5 * (extent.min_y + extent.max_y),
                     altitude_m_};
  const double run_out =
      kRunOutM +
      (altitude_m_ - ground.lowest_m) *
          std::tan(radians(scanner.largest_lean_deg() + kLargestPitchDeg * flight.motion));
  CounterRandom random(seed, 7, 0);
  const double wind_from = random.uniform(0.0, 360.0);
  const double wind = flight.motion * kWindMs * random.uniform(0.4, 1.0);
  const auto half_size = [&](Vec3d direction) {
    return 0.5 * (extent.width() * std::abs(direction.x) + extent.height() * std::abs(direction.y));
  };
  const auto add = [&](double azimuth, double offset, bool is_cross_line) {
    const Vec3d along = azimuth_direction(azimuth), across = azimuth_direction(azimuth + 90.0);
    const double half_length = half_size(along) + run_out;
    Pass pass;
    pass.is_cross_line = is_cross_line;
    pass.azimuth_deg = wrapped_360(azimuth);
    pass.start = centre + offset * across - half_length * along;
    pass.end = centre + offset * across + half_length * along;
    pass.crab_deg =
        degrees(std::asin(wind / flight.speed_ms * std::sin(radians(wind_from - azimuth))));
    passes_.push_back(pass);
  };
  const double reach =
      half_size(azimuth_direction(flight.azimuth_deg + 90.0)) + 0.5 * swath_m(ground.lowest_m);
  const int most = static_cast<int>(std::floor(reach / pass_spacing_m_ + 0.5));
  for (int k = -most; k < most; ++k) {
    const bool back = (k + most) % 2 == 1;
    // Of a returning pass "right" is the other side of the block.
    const double offset = (k + 0.5) * pass_spacing_m_ * (back ? -1.0 : 1.0);
    add(flight.azimuth_deg + (back ? 180.0 : 0.0), offset, false);
  }
  if (flight.cross_line) add(flight.azimuth_deg + 90.0, 0.0, true);
  double time = flight.start_time_s;
  for (std::size_t i = 0; i < passes_.size(); ++i) {
    Pass& pass = passes_[i];
    pass.survey = flight.survey_break_s > 0.0 && i >= (passes_.size() + 1) / 2 ? 1 : 0;
    if (i > 0) time += flight.turn_s;
    if (i > 0 && pass.survey != passes_[i - 1].survey) time += flight.survey_break_s;
    pass.first_time_s = time;
    time += norm(pass.end - pass.start) / flight.speed_ms;
    pass.last_time_s = time;
  }
}

void Trajectory::fill_poses(const FlightOptions& flight, std::uint64_t seed) {
  const Unrest unrest(seed, flight.motion);
  const auto push = [&](TrajectoryPose pose, double bank_deg, double crab_deg, double course_deg) {
    const double t = pose.gps_time_s - flight.start_time_s;
    pose.position += unrest.wander(t);
    pose.roll_deg = unrest.roll.at(t) + bank_deg;
    pose.pitch_deg = unrest.pitch.at(t);
    pose.heading_deg = wrapped_360(course_deg + crab_deg + unrest.yaw.at(t));
    frames_.push_back(frame_of(pose));
    poses_.push_back(pose);
  };
  for (std::size_t i = 0; i < passes_.size(); ++i) {
    Pass& pass = passes_[i];
    const Vec3d velocity = flight.speed_ms * azimuth_direction(pass.azimuth_deg);
    const double duration = pass.last_time_s - pass.first_time_s;
    pass.first_node = poses_.size();
    pass.node_count = static_cast<std::size_t>(std::ceil(duration / node_step_s_)) + 1;
    for (std::size_t n = 0; n < pass.node_count; ++n) {
      const double t = static_cast<double>(n) * node_step_s_;
      push({pass.first_time_s + t, static_cast<int>(i), pass.start + t * velocity, 0, 0, 0}, 0.0,
           pass.crab_deg, pass.azimuth_deg);
    }
    if (i + 1 == passes_.size()) break;
    const Pass& next = passes_[i + 1];
    const double turn = next.first_time_s - pass.last_time_s;
    if (turn > kLongestTurnS) continue;
    const Vec3d next_velocity = flight.speed_ms * azimuth_direction(next.azimuth_deg);
    const double last = poses_.back().gps_time_s - pass.last_time_s;
    for (double t = last + kTurnStepS; t < turn - 0.5 * kTurnStepS; t += kTurnStepS) {
      const TurnPoint q = turn_point(pass.end, velocity, next.start, next_velocity, turn, t);
      const double ground_speed = std::max(1.0, std::hypot(q.velocity.x, q.velocity.y));
      const double to_the_right =
          (q.acceleration.x * q.velocity.y - q.acceleration.y * q.velocity.x) / ground_speed;
      push({pass.last_time_s + t, -1, q.position, 0, 0, 0},
           degrees(std::atan(to_the_right / kGravity)),
           pass.crab_deg + (t / turn) * wrapped_180(next.crab_deg - pass.crab_deg),
           degrees(std::atan2(q.velocity.x, q.velocity.y)));
    }
  }
}

SensorFrame Trajectory::at(std::size_t pass_index, double gps_time_s) const {
  const Pass& pass = passes_[pass_index];
  const double place = (gps_time_s - pass.first_time_s) / node_step_s_;
  assert(place >= 0.0 && place <= static_cast<double>(pass.node_count));
  const std::size_t n = std::min(static_cast<std::size_t>(place), pass.node_count - 2);
  const double u = place - static_cast<double>(n);
  const SensorFrame &a = frames_[pass.first_node + n], &b = frames_[pass.first_node + n + 1];
  // Between nodes the axes turn by hundredths of a degree: their mean is a rotation to 1e-8.
  return {a.position + u * (b.position - a.position), a.forward + u * (b.forward - a.forward),
          a.right + u * (b.right - a.right), a.down + u * (b.down - a.down)};
}

}  // namespace cornice::simulate
