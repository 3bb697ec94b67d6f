// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/flightlines/flown_line.h"

#include <cmath>
#include <numbers>

#include "core/base/random.h"

namespace cornice::flightlines::test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRadians = kPi / 180.0;

double ground(const Flight& flight, double x, double y) {
  const double u = x - flight.start.x, v = y - flight.start.y;
  return flight.relief_m *
         (std::sin(u / 130.0) * std::cos(v / 170.0) + 0.4 * std::sin(u / 41.0 + v / 37.0) +
          0.1 * std::sin(u / 9.0) * std::sin(v / 7.0));
}

Vec3d body_beam(const Flight& flight, double time_s) {
  const double phase = std::fmod(time_s * flight.scans_per_s, 1.0);
  const double half = flight.half_view_deg * kRadians;
  Vec3d d;  // fore, right, down
  if (flight.pattern == Pattern::kPalmer) {
    d = {std::sin(half) * std::cos(2.0 * kPi * phase), std::sin(half) * std::sin(2.0 * kPi * phase),
         std::cos(half)};
  } else {
    const double angle = flight.pattern == Pattern::kPolygon ? half * (2.0 * phase - 1.0)
                                                             : half * std::sin(2.0 * kPi * phase);
    d = {0.0, std::sin(angle), std::cos(angle)};
  }
  const double s = std::sin(flight.tilt_deg * kRadians), c = std::cos(flight.tilt_deg * kRadians);
  return {c * d.x + s * d.z, d.y, c * d.z - s * d.x};
}

Vec3d to_world(const Pose& pose, Vec3d body) {
  const double h = pose.heading_deg * kRadians, p = pose.pitch_deg * kRadians,
               r = pose.roll_deg * kRadians;
  const Vec3d ahead{std::sin(h), std::cos(h), 0.0}, side{std::cos(h), -std::sin(h), 0.0},
      up{0.0, 0.0, 1.0};
  const Vec3d forward = std::cos(p) * ahead + std::sin(p) * up;
  const Vec3d level_down = std::sin(p) * ahead - std::cos(p) * up;
  const Vec3d right = std::cos(r) * side + std::sin(r) * level_down;
  const Vec3d down = std::cos(r) * level_down - std::sin(r) * side;
  return body.x * forward + body.y * right + body.z * down;
}

double to_grid(double metres) { return std::round(metres * 100.0) / 100.0; }

}  // namespace

Pose pose_at(const Flight& flight, double time_s) {
  const double t = time_s - flight.start_time_s;
  const double a = flight.azimuth_deg * kRadians;
  const double u = flight.unrest;
  Pose pose;
  pose.position = flight.start + Vec3d{std::sin(a), std::cos(a), 0.0} * (flight.speed_ms * t) +
                  Vec3d{u * 2.0 * std::sin(t / 3.1), u * 2.0 * std::sin(t / 3.7),
                        flight.height_m + u * 1.5 * std::sin(t / 2.9)};
  pose.roll_deg = u * (0.8 * std::sin(t / 0.9) + 0.3 * std::sin(t / 0.35));
  pose.pitch_deg = u * (0.7 * std::sin(t / 1.3 + 1.0) + 0.2 * std::sin(t / 0.5));
  pose.heading_deg = flight.azimuth_deg + flight.crab_deg + u * 0.6 * std::sin(t / 1.7);
  return pose;
}

PointCloud fly(const Flight& flight, const std::function<bool(Vec3d)>& keep) {
  PointCloud points;
  points.origin = flight.start;
  const auto pulses = static_cast<std::uint64_t>(flight.duration_s * flight.pulses_per_s);
  const auto add = [&](Vec3d p, double time_s, double angle_deg, int number, int count) {
    if (!keep(p)) return;
    const Vec3d stored{to_grid(p.x), to_grid(p.y), to_grid(p.z)};
    points.positions.push_back((stored - points.origin).cast<float>());
    points.gps_time_s.push_back(time_s);
    points.scan_angle_deg.push_back(static_cast<float>(angle_deg));
    points.return_number.push_back(static_cast<std::uint8_t>(number));
    points.return_count.push_back(static_cast<std::uint8_t>(count));
    points.classification.push_back(2);
    points.flags.push_back(0);
    points.point_source_id.push_back(flight.id);
    points.scanner_channel.push_back(flight.channel);
    points.user_data.push_back(flight.user_data);
  };
  for (std::uint64_t i = 0; i < pulses; ++i) {
    CounterRandom random(flight.seed, flight.channel, i);
    const double time_s = flight.start_time_s + static_cast<double>(i) / flight.pulses_per_s;
    const Pose pose = pose_at(flight, time_s);
    const Vec3d beam = to_world(pose, body_beam(flight, time_s - flight.start_time_s));
    double range = (pose.position.z - ground(flight, pose.position.x, pose.position.y)) / -beam.z;
    for (int step = 0; step < 60; ++step) {
      const Vec3d p = pose.position + beam * range;
      range += 0.7 * (p.z - ground(flight, p.x, p.y)) / -beam.z;
    }
    const double h = pose.heading_deg * kRadians;
    const double right = std::cos(h) * beam.x - std::sin(h) * beam.y;
    double angle = flight.angle_sign * std::atan2(right, -beam.z) / kRadians;
    angle = flight.whole_degrees ? std::round(angle) : std::round(angle / 0.006) * 0.006;
    const bool tree = random.uniform() < flight.tree_share;
    if (tree)
      add(pose.position + beam * (range - random.uniform(3.0, 15.0) + 0.03 * random.normal()),
          time_s, angle, 1, 2);
    add(pose.position + beam * (range + 0.03 * random.normal()), time_s, angle, tree ? 2 : 1,
        tree ? 2 : 1);
  }
  return points;
}

}  // namespace cornice::flightlines::test
