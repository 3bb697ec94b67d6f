// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/survey_block.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/points/point_cloud.h"

namespace cornice::simulate {
namespace {

/// Noise can move a point across the border by this much, the offset of its strip by so many
/// standard deviations. Beams that stay further away are not followed.
constexpr double kNoiseReachM = 1.0;
constexpr double kOffsetReach = 5.0;

/// What is needed of the scene to tell which beams matter.
struct Reach {
  Box2d extent;
  double lowest_m;
  double highest_m;
};

/// True where the beam is over the extent somewhere between the highest and the lowest ground.
bool meets(const Reach& reach, const Ray& ray) {
  if (ray.direction.z >= -1e-3) return false;
  const double high = (reach.highest_m - ray.origin.z) / ray.direction.z;
  const double low = (reach.lowest_m - ray.origin.z) / ray.direction.z;
  const double x0 = ray.origin.x + high * ray.direction.x;
  const double x1 = ray.origin.x + low * ray.direction.x;
  const double y0 = ray.origin.y + high * ray.direction.y;
  const double y1 = ray.origin.y + low * ray.direction.y;
  return std::max(x0, x1) >= reach.extent.min_x && std::min(x0, x1) <= reach.extent.max_x &&
         std::max(y0, y1) >= reach.extent.min_y && std::min(y0, y1) <= reach.extent.max_y;
}

/// Pulses that are skipped together where none of them can meet the extent.
constexpr std::uint64_t kGroupPulses = 32;
/// Faster than any sensor here moves and turns.
constexpr double kMostSpeedMs = 250.0;
constexpr double kMostTurnRadS = 0.3;

/// True where no beam within `margin_m` of this one at the same height can meet anything within the
/// extent, by the heights there square by square. False where that is not certain.
bool passes_over_or_under(const HeightBounds& heights, const Reach& reach, const Ray& ray,
                          double margin_m) {
  const double across = std::hypot(ray.direction.x, ray.direction.y);
  const double half = 0.5 * heights.step_m;
  const double near = margin_m + half;
  double t = (reach.highest_m - ray.origin.z) / ray.direction.z;
  const double end = (reach.lowest_m - ray.origin.z) / ray.direction.z;
  const double step = across > 1e-6 ? heights.step_m / across : end - t;
  for (; t < end; t += step) {
    const double middle = std::min(t + 0.5 * step, end);
    const double x = ray.origin.x + middle * ray.direction.x;
    const double y = ray.origin.y + middle * ray.direction.y;
    if (!reach.extent.grown(near).contains(x, y)) continue;
    const auto above = static_cast<float>(ray.origin.z + t * ray.direction.z);
    const auto below = static_cast<float>(ray.origin.z + (t + step) * ray.direction.z);
    for (double v = y - near;; v = std::min(v + heights.step_m, y + near)) {
      for (double u = x - near;; u = std::min(u + heights.step_m, x + near)) {
        const HeightBounds::Range& range = heights.at(u, v);
        if (below <= range.high && above >= range.low) return false;
        if (u >= x + near) break;
      }
      if (v >= y + near) break;
    }
  }
  return true;
}

/// True where none of the pulses [first, first + count) of a pass comes near the extent, by what
/// the beam of the first and the scanner's largest step say. False where that is not certain.
bool misses_all(const SurveySetup& setup, const Reach& reach, std::size_t pass, std::uint64_t first,
                std::uint64_t count) {
  if (setup.scanner->jumps_within(first, count)) return false;
  const double lasting_s = static_cast<double>(count) / setup.pulse_rate;
  const double swing = static_cast<double>(count) * setup.scanner->largest_step_rad();
  constexpr double kSmallAngle = 0.2;
  if (swing > kSmallAngle) return false;
  const SensorFrame frame =
      setup.trajectory->at(pass, setup.trajectory->passes()[pass].first_time_s +
                                     static_cast<double>(first) / setup.pulse_rate);
  for (int channel = 0; channel < setup.channels; ++channel) {
    const Ray ray{frame.position,
                  normalized(frame.to_world(setup.scanner->beam(first, channel).direction))};
    if (ray.direction.z >= -kSmallAngle) return false;
    // A turn by an angle moves the foot of a slanting beam by height / cos^2 of it; half as much
    // again for what is not small.
    const double height = frame.position.z - reach.lowest_m;
    const double turn = swing + lasting_s * kMostTurnRadS;
    const double margin =
        1.0 + lasting_s * kMostSpeedMs + 1.5 * turn * height / (ray.direction.z * ray.direction.z);
    if (meets({reach.extent.grown(margin), reach.lowest_m, reach.highest_m}, ray) &&
        !passes_over_or_under(setup.heights, reach, ray, margin))
      return false;
  }
  return true;
}

/// Two independent normal deviates (Marsaglia's polar method, Marsaglia and Bray 1964).
struct NormalPair {
  explicit NormalPair(CounterRandom& random) {
    double size = 0.0;
    do {
      x = random.uniform(-1.0, 1.0);
      y = random.uniform(-1.0, 1.0);
      size = x * x + y * y;
    } while (size >= 1.0 || size == 0.0);
    const double scale = std::sqrt(-2.0 * std::log(size) / size);
    x *= scale;
    y *= scale;
  }
  double x, y;
};

/// The beam as measured: the true one turned by the angular noise.
Vec3d measured_direction(const NoiseOptions& noise, const SensorFrame& frame, Vec3d direction,
                         CounterRandom& random) {
  const NormalPair pair(random);
  const Vec3d side = normalized(cross(direction, frame.forward));
  const Vec3d along = cross(side, direction);
  const double size = noise.across_rad();
  return normalized(direction + (size * pair.x) * side + (size * pair.y) * along);
}

struct Pulse {
  const SurveyLine* line;
  std::uint64_t key;
  double true_time_s;
  double recorded_time_s;
  Ray ray;
  SensorFrame frame;
  double angle_deg;  ///< across the track, positive to the right
  std::uint8_t flags;
};

SurveyPoint point_of(const SurveySetup& setup, const Pulse& pulse, const EchoList& echoes,
                     int index, Vec3d measured, CounterRandom& random) {
  const Echo& echo = echoes.echoes[static_cast<std::size_t>(index)];
  SurveyPoint point;
  Vec3d truth = pulse.ray.origin + echo.range_m * pulse.ray.direction;
  double range = echo.range_m + setup.noise.along_m(echo.range_m) * random.normal();
  point.intensity = intensity_of(echo, setup.noise.nominal_range_m, random);
  point.surface = static_cast<std::uint8_t>(echo.surface);
  point.classification = class_of(setup.product, echo.surface, echo.above_ground_m);
  point.normal = echo.normal.cast<float>();
  const double shift = outlier_shift_m(setup.defects, setup.seed, pulse.key, index);
  if (shift != 0.0) {
    truth += shift * pulse.ray.direction;
    range += shift;
    point.surface = kNoSurface;
    point.normal = (-pulse.ray.direction).cast<float>();
    // Producers find about every other one; Lidar HD has a class for them.
    const bool is_found = std::fmod(std::abs(shift), 1.0) < 0.5;
    if (is_found)
      point.classification =
          setup.product == SurveyProduct::kLidarHd ? kClassArtefact : kClassUnclassified;
  }
  const Vec3d recorded = pulse.ray.origin + range * measured + pulse.line->offset;
  point.at = {to_steps(recorded.x), to_steps(recorded.y), to_steps(recorded.z)};
  point.true_offset = (truth - point.recorded()).cast<float>();
  point.beam = pulse.ray.direction.cast<float>();
  point.gps_time_s = pulse.recorded_time_s;
  point.point_source_id = pulse.line->point_source_id;
  point.line = pulse.line->id;
  point.return_number = static_cast<std::uint8_t>(index + 1);
  point.return_count = static_cast<std::uint8_t>(echoes.count);
  point.flags = pulse.flags;
  point.channel = pulse.line->recorded_channel;
  point.user_data = pulse.line->user_data;
  point.scan_angle_deg = static_cast<float>(pulse.line->angle_sign * pulse.angle_deg);
  return point;
}

void add_pulse(const SurveySetup& setup, Pulse& pulse, const Hit& hit,
               std::vector<SurveyPoint>& points) {
  CounterRandom random = random_of(setup.seed, Stream::kPulse, pulse.key);
  const EchoList echoes = follow_pulse(*setup.scene, pulse.ray, hit, setup.most_returns, random);
  if (echoes.count == 0) return;
  pulse.angle_deg = across_track_angle_deg(pulse.frame, pulse.ray.direction);
  const Vec3d measured = measured_direction(setup.noise, pulse.frame, pulse.ray.direction, random);
  const std::size_t first = points.size();
  for (int i = 0; i < echoes.count; ++i)
    points.push_back(point_of(setup, pulse, echoes, i, measured, random));
  apply_defects(setup.defects, setup.seed, pulse.key, first, points);
  std::size_t kept = first;
  for (std::size_t i = first; i < points.size(); ++i)
    if (setup.grid.find(points[i].at.x, points[i].at.y)) points[kept++] = points[i];
  points.resize(kept);
}

/// Tally of the points of one pulse.
LineTally tally_of(const Pulse& pulse, std::size_t points) {
  LineTally tally;
  tally.points = points;
  tally.first_time_s = tally.last_time_s = pulse.recorded_time_s;
  tally.true_first_time_s = tally.true_last_time_s = pulse.true_time_s;
  tally.lowest_angle_deg = tally.highest_angle_deg = pulse.angle_deg;
  return tally;
}

/// Pulses on their way, whose rays are cast together.
class PulseBatch {
 public:
  PulseBatch(const SurveySetup& setup, BlockPoints& result) : setup_(setup), result_(result) {}

  void add(const Pulse& pulse) {
    pulses_[count_] = pulse;
    rays_[count_] = pulse.ray;
    if (++count_ == kMost) flush();
  }

  void flush() {
    setup_.scene->cast_all({rays_.data(), count_}, {hits_.data(), count_}, {met_.data(), count_});
    for (std::size_t i = 0; i < count_; ++i) {
      if (met_[i] == 0) continue;
      Pulse& pulse = pulses_[i];
      const std::size_t before = result_.points.size();
      add_pulse(setup_, pulse, hits_[i], result_.points);
      if (result_.points.size() == before) continue;
      result_.tallies[static_cast<std::size_t>(pulse.line->channel)].add(
          tally_of(pulse, result_.points.size() - before));
    }
    count_ = 0;
  }

 private:
  static constexpr std::size_t kMost = 64;
  const SurveySetup& setup_;
  BlockPoints& result_;
  std::array<Pulse, kMost> pulses_;
  std::array<Ray, kMost> rays_;
  std::array<Hit, kMost> hits_;
  std::array<std::uint8_t, kMost> met_{};
  std::size_t count_ = 0;
};

/// One pulse of every channel.
void fire(const SurveySetup& setup, const Reach& reach, std::size_t pass_index, std::uint64_t k,
          PulseBatch& batch) {
  const Pass& pass = setup.trajectory->passes()[pass_index];
  const double time = pass.first_time_s + static_cast<double>(k) / setup.pulse_rate;
  Pulse pulse{};
  pulse.true_time_s = time;
  pulse.frame = setup.trajectory->at(pass_index, time);
  pulse.ray.origin = pulse.frame.position;
  for (int channel = 0; channel < setup.channels; ++channel) {
    const BodyBeam beam = setup.scanner->beam(k, channel);
    pulse.ray.direction = normalized(pulse.frame.to_world(beam.direction));
    if (!meets(reach, pulse.ray)) continue;
    pulse.line = &setup.lines[pass_index * static_cast<std::size_t>(setup.channels) +
                              static_cast<std::size_t>(channel)];
    pulse.key = (static_cast<std::uint64_t>(pulse.line->id) << 40) | k;
    pulse.recorded_time_s = recorded_time(setup.defects, time);
    pulse.flags = static_cast<std::uint8_t>((beam.scans_to_the_right ? kScanDirection : 0) |
                                            (beam.is_last_of_line ? kEdgeOfFlightLine : 0));
    batch.add(pulse);
  }
}

}  // namespace

void LineTally::add(const LineTally& later) {
  if (later.points == 0) return;
  if (points == 0) {
    *this = later;
    return;
  }
  points += later.points;
  last_time_s = later.last_time_s;
  true_last_time_s = later.true_last_time_s;
  lowest_angle_deg = std::min(lowest_angle_deg, later.lowest_angle_deg);
  highest_angle_deg = std::max(highest_angle_deg, later.highest_angle_deg);
}

std::uint64_t pulses_of_pass(const SurveySetup& setup, std::size_t pass) {
  const Pass& p = setup.trajectory->passes()[pass];
  return static_cast<std::uint64_t>((p.last_time_s - p.first_time_s) * setup.pulse_rate);
}

BlockPoints simulate_block(const SurveySetup& setup, const PulseBlock& block) {
  const Box3d bounds = setup.scene->bounds();
  const double margin = kNoiseReachM + kOffsetReach * setup.defects.strip_offset_m;
  const Reach reach{setup.grid.extent().grown(margin), bounds.min.z, bounds.max.z};
  BlockPoints result;
  result.tallies.resize(static_cast<std::size_t>(setup.channels));
  result.points.reserve(block.count * static_cast<std::size_t>(setup.channels));
  PulseBatch batch(setup, result);
  const std::uint64_t end = block.first + block.count;
  for (std::uint64_t k = block.first; k < end; k += kGroupPulses) {
    const std::uint64_t count = std::min(kGroupPulses, end - k);
    if (misses_all(setup, reach, block.pass, k, count)) continue;
    for (std::uint64_t pulse = k; pulse < k + count; ++pulse)
      fire(setup, reach, block.pass, pulse, batch);
  }
  batch.flush();
  return result;
}

std::vector<SurveyPoint> virtual_points(const SurveySetup& setup, int tile) {
  std::vector<SurveyPoint> points;
  if (!setup.defects.virtual_on_water && !setup.defects.virtual_everywhere) return points;
  const Box2d box = setup.grid.tile(tile);
  const double top = setup.scene->bounds().max.z + 1.0;
  for (double y = box.min_y + 0.5 * kVirtualStepM; y < box.max_y; y += kVirtualStepM) {
    for (double x = box.min_x + 0.5 * kVirtualStepM; x < box.max_x; x += kVirtualStepM) {
      Hit hit;
      if (!setup.scene->cast({{x, y, top}, {0.0, 0.0, -1.0}}, hit)) continue;
      if (hit.surface != SurfaceId::kWater && !setup.defects.virtual_everywhere) continue;
      SurveyPoint point;
      point.at = {to_steps(x), to_steps(y), to_steps(hit.point.z)};
      point.true_offset = (hit.point - point.recorded()).cast<float>();
      point.normal = hit.normal.cast<float>();
      point.classification = kClassVirtual;
      point.surface = static_cast<std::uint8_t>(hit.surface);
      points.push_back(point);
    }
  }
  return points;
}

}  // namespace cornice::simulate
