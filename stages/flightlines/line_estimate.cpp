// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/flightlines/line_estimate.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <optional>

#include "stages/flightlines/robust.h"

namespace cornice::flightlines {
namespace {

/// Across azimuth known worse than this is of no use for a beam.
constexpr double kMostAcrossErrorDeg = 10.0;
/// Both signs fit equally well below this gain in log likelihood a pulse.
constexpr double kSignGain = 0.02;
/// Swaths that tell the sign by the side their angles grow to: surely, and where nothing else does.
constexpr double kWideDeg = 10.0;
constexpr double kNarrowDeg = 4.0;
/// Recorded angles that keep to a path of first-last lines within this may help it.
constexpr double kAgreeFineDeg = 0.25;
constexpr double kAgreeWholeDeg = 0.6;
constexpr double kAgreeOffsetDeg = 0.8;

double wrapped_360(double degrees) {
  const double rest = std::fmod(degrees, 360.0);
  return rest < 0.0 ? rest + 360.0 : rest;
}

double azimuth_of(double east, double north) {
  return wrapped_360(std::atan2(east, north) / kRadians);
}

std::string format(const char* text, double a, double b = 0.0) {
  char buffer[240];
  std::snprintf(buffer, sizeof buffer, text, a, b);
  return buffer;
}

/// Mean height of the last returns of a pass.
double ground_of(const LinePass& pass) {
  std::vector<double> heights;
  for (const PulseBin* bin : pass.bins)
    for (const Pulse& pulse : bin->any)
      heights.push_back(bin->origin.z + static_cast<double>(pulse.last.z));
  return median_of(std::move(heights));
}

double pulse_rate_of(const LinePass& pass) {
  std::vector<double> steps;
  for (const PulseBin* bin : pass.bins)
    for (std::size_t i = 1; i < bin->burst_offset.size(); ++i)
      steps.push_back(static_cast<double>(bin->burst_offset[i]) -
                      static_cast<double>(bin->burst_offset[i - 1]));
  if (steps.size() < 20) return 0.0;
  const double step = median_of(std::move(steps));
  return step > 0.0 ? 1.0 / step : 0.0;
}

void fill_counts(const LinePass& pass, LineEstimate& estimate) {
  FlightLine& line = estimate.line;
  line.point_source_id = pass.key.id;
  line.scanner_channel = pass.key.channel;
  line.has_time = !pass.is_timeless;
  line.first_time_s = pass.bins.front()->first_time_s;
  line.last_time_s = pass.bins.front()->last_time_s;
  float low = 1e9f, high = -1e9f;
  bool fractional = false;
  for (const PulseBin* bin : pass.bins) {
    estimate.points += bin->points;
    line.last_time_s = std::max(line.last_time_s, bin->last_time_s);
    low = std::min(low, bin->min_angle_deg);
    high = std::max(high, bin->max_angle_deg);
    fractional |= bin->fractional_angles;
  }
  estimate.min_angle_deg = low;
  estimate.max_angle_deg = high;
  estimate.angle_step_deg = fractional ? 0.0 : 1.0;
  estimate.pulse_rate_hz = pulse_rate_of(pass);
}

/// Direction towards which the recorded angle grows on the ground, without any time.
struct Gradient {
  double azimuth_deg = 0.0;
  double error_deg = 180.0;
};

Gradient angle_gradient(const LinePass& pass) {
  const Vec3d origin = pass.bins.front()->origin;
  std::vector<Eigen::Vector3d> rows;
  std::vector<double> values;
  for (const PulseBin* bin : pass.bins)
    for (const Pulse& pulse : bin->any) {
      const Vec3d p = bin->origin - origin + pulse.last.cast<double>();
      rows.emplace_back(1.0, p.x, p.y);
      values.push_back(std::tan(pulse.angle_deg * kRadians));
    }
  if (rows.size() < 20) return {};
  std::vector<double> weights(rows.size(), 1.0);
  Eigen::Vector3d solution = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();
  double scale = 0.0;
  for (int iteration = 0; iteration < 4; ++iteration) {
    Eigen::Matrix3d normal = Eigen::Vector3d(1e-9, 1e-6, 1e-6).asDiagonal();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < rows.size(); ++i) {
      normal += weights[i] * rows[i] * rows[i].transpose();
      right += weights[i] * values[i] * rows[i];
    }
    inverse = normal.inverse();
    solution = inverse * right;
    std::vector<double> residuals(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i)
      residuals[i] = std::abs(values[i] - rows[i].dot(solution));
    scale = std::max(1e-5, 1.4826 * median_of(residuals));
    for (std::size_t i = 0; i < rows.size(); ++i)
      weights[i] = 1.0 / (1.0 + std::pow(residuals[i] / (3.0 * scale), 2.0));
  }
  const double slope = std::hypot(solution(1), solution(2));
  // A slope that no sensor between 80 and 6000 m makes is chance.
  if (!(slope > 1.0 / 8000.0 && slope < 1.0 / 60.0)) return {};
  const Eigen::Vector2d side(-solution(2) / slope, solution(1) / slope);
  const double across = std::sqrt(side.dot(inverse.bottomRightCorner<2, 2>() * side));
  // Whole degrees come in stripes: pulses of one stripe err together.
  const double effective = std::sqrt(std::max(1.0, static_cast<double>(rows.size()) / 200.0));
  return {azimuth_of(solution(1), solution(2)), effective * scale * across / slope / kRadians};
}

/// Log likelihood a pulse, up to a constant, from the residual scales that a fit ended with.
double badness(const PathEstimate& path) {
  const auto angles = static_cast<double>(path.pulses);
  const auto pairs = 2.0 * static_cast<double>(path.pairs);
  return (angles * std::log(std::max(path.angle_residual_deg, 1e-4)) +
          pairs * std::log(std::max(path.pair_residual, 1e-2))) /
         std::max(1.0, angles + pairs);
}

/// What is known of the recorded angles before the path is estimated with them.
struct AngleUse {
  int sign = 0;        ///< 0: not known
  bool usable = true;  ///< false: they would do harm to the path
};

/// Sign and use of the angles by a path that was found without them.
AngleUse angles_against(const LinePass& pass, const PathEstimate& path, LineEstimate& estimate) {
  const AngleAgreement agreement = compare_angles(pass, path);
  if (agreement.sign != 0) estimate.sign_from = "pairs";
  const double bound = estimate.angle_step_deg > 0.0 ? kAgreeWholeDeg : kAgreeFineDeg;
  const bool agrees =
      agreement.residual_deg < bound && std::abs(agreement.offset_deg) < kAgreeOffsetDeg;
  if (agreement.sign != 0 && !agrees)
    estimate.remarks.push_back(
        format("recorded angles spread by %.2f degrees about the path (offset %.2f), so the path "
               "does without them: probably they leave out the roll",
               agreement.residual_deg, agreement.offset_deg));
  return AngleUse{agreement.sign, agreement.sign != 0 && agrees};
}

/// Sign of the recorded angle: the one that puts the sensor where beams meet, above the ground.
AngleUse find_sign(const LinePass& pass, const TrackFit& track, const TrajectoryOptions& options,
                   LineEstimate& estimate) {
  // A reliable track with a wide swath needs no trial: positive angles lie on one side of it.
  const Vec3d right{track.velocity.y, -track.velocity.x, 0.0};
  const double side = dot(track.across, normalized(right));
  const double width = static_cast<double>(estimate.max_angle_deg - estimate.min_angle_deg);
  const bool tells = track.is_reliable() && std::abs(side) > 100.0 && std::abs(side) < 8000.0 &&
                     std::abs(side) > 0.8 * norm(track.across);
  const AngleUse by_track{side > 0.0 ? 1 : -1, true};
  if (tells && width > kWideDeg) {
    estimate.sign_from = "track";
    return by_track;
  }
  const PathEstimate plus = solve_path(pass, track, 1, ScanModel::kNone, options);
  const PathEstimate minus = solve_path(pass, track, -1, ScanModel::kNone, options);
  if (!plus.is_valid || !minus.is_valid) return {0, false};
  const double gain = badness(minus) - badness(plus);
  if (std::abs(gain) > kSignGain) {
    estimate.sign_from = plus.pairs >= 12 ? "pairs and angles" : "angles";
    return {gain > 0.0 ? 1 : -1, true};
  }
  if (!tells || width < kNarrowDeg) return {0, false};
  estimate.sign_from = "track";
  return by_track;
}

/// The path by all that agrees with each other; fills the sign.
PathEstimate best_path(const LinePass& pass, const TrackFit& track,
                       const TrajectoryOptions& options, const AcceptOptions& accept,
                       LineEstimate& estimate) {
  const bool zero = estimate.min_angle_deg == 0.0 && estimate.max_angle_deg == 0.0;
  if (zero) estimate.remarks.push_back("all recorded angles are 0");
  PathEstimate path = estimate_path(pass, track, 0, options);
  if (path.is_valid && (zero || path.pairs >= accept.enough_pairs)) {
    if (zero) return path;
    const AngleUse angles = angles_against(pass, path, estimate);
    estimate.line.scan_angle_sign = angles.sign;
    if (!angles.usable) return path;
    PathEstimate joint = solve_path(pass, track, angles.sign, path.model, options, &path);
    return joint.is_valid ? joint : path;
  }
  const AngleUse angles = zero ? AngleUse{0, false} : find_sign(pass, track, options, estimate);
  estimate.line.scan_angle_sign = angles.sign;
  return estimate_path(pass, track, angles.usable ? angles.sign : 0, options);
}

/// Course and speed of a path: least squares of its positions over time.
void fill_course(const PathEstimate& path, LineEstimate& estimate) {
  double t_mean = 0.0;
  Vec3d mean;
  const auto n = static_cast<double>(path.nodes.size());
  const Vec3d origin = path.nodes.front().position;
  const double start = path.nodes.front().time_s;
  for (const PathNode& node : path.nodes) {
    t_mean += (node.time_s - start) / n;
    mean += (node.position - origin) / n;
  }
  double square = 0.0;
  Vec3d slope;
  std::vector<double> errors;
  for (const PathNode& node : path.nodes) {
    const double t = node.time_s - start - t_mean;
    square += t * t;
    slope += (node.position - origin - mean) * t;
    errors.push_back(std::hypot(node.standard_error_m.x, node.standard_error_m.y));
  }
  slope = slope / std::max(square, 1e-12);
  estimate.line.along_azimuth_deg = azimuth_of(slope.x, slope.y);
  estimate.speed_ms = std::hypot(slope.x, slope.y);
  const double length = estimate.speed_ms * (path.nodes.back().time_s - start);
  estimate.along_standard_error_deg =
      std::min(180.0, std::atan2(median_of(errors), 0.5 * length) / kRadians);
}

/// Across azimuth: the mean over the line of the direction that angles are measured in.
void fill_across(const PathEstimate& path, LineEstimate& estimate) {
  double east = 0.0, north = 0.0, error = 0.0, count = 0.0;
  for (const PathNode& node : path.nodes) {
    if (node.bridged) continue;
    east += std::sin((node.heading_deg + 90.0) * kRadians);
    north += std::cos((node.heading_deg + 90.0) * kRadians);
    error += node.heading_error_deg;
    count += 1.0;
  }
  estimate.line.across_azimuth_deg = azimuth_of(east, north);
  // A plane's direction is known by how straight its lines are over their width, a heading by the
  // solver. Errors are alike over some seconds; that many count as one.
  const double seconds = path.nodes.back().time_s - path.nodes.front().time_s;
  const double windows = std::sqrt(std::max(1.0, seconds / 4.0));
  const double width = std::max(0.2, estimate.max_angle_deg - estimate.min_angle_deg) / 3.5;
  const double node_error = path.model == ScanModel::kPlane
                                ? path.scan_residual_deg / width / kRadians / 10.0
                                : error / std::max(1.0, count);
  // The heading itself wanders about its mean.
  double wander = 0.0;
  for (const PathNode& node : path.nodes)
    if (!node.bridged)
      wander += std::pow(
          std::remainder(node.heading_deg + 90.0 - estimate.line.across_azimuth_deg, 360.0), 2.0);
  estimate.line.across_standard_error_deg =
      std::hypot(node_error, std::sqrt(wander / std::max(1.0, count))) / windows;
}

/// Lean of the beams along the flight, and whether it comes in two looks.
void fill_looks(const LinePass& pass, const PathEstimate& path, LineEstimate& estimate) {
  std::vector<double> leans;
  for (const PulseBin* bin : pass.bins)
    for (const Pulse& pulse : bin->any) {
      const double step = path.nodes[1].time_s - path.nodes[0].time_s;
      const double at = std::clamp((pulse.time_s - path.nodes[0].time_s) / step, 0.0,
                                   static_cast<double>(path.nodes.size() - 1));
      const PathNode& node = path.nodes[static_cast<std::size_t>(at)];
      const Vec3d s = node.position + node.velocity * (pulse.time_s - node.time_s);
      const Vec3d d = bin->origin + pulse.last.cast<double>() - s;
      const double h = node.heading_deg * kRadians;
      leans.push_back(std::atan2(d.x * std::sin(h) + d.y * std::cos(h), -d.z) / kRadians);
    }
  if (leans.empty()) return;
  estimate.lean_deg = median_of(leans);
  std::size_t fore = 0, aft = 0;
  std::vector<double> spread;
  for (const double lean : leans) {
    fore += lean > 3.0;
    aft += lean < -3.0;
    spread.push_back(std::abs(lean));
  }
  const std::size_t least = leans.size() / 10;
  if (fore > least && aft > least) {
    estimate.looks = 2;
    estimate.lean_deg = median_of(spread);
    estimate.remarks.push_back(
        format("looks fore and aft by about %.1f degrees: a conical or two-way scanner",
               estimate.lean_deg));
  } else if (std::abs(estimate.lean_deg) > 3.0) {
    estimate.remarks.push_back(format(
        "leans %.1f degrees along the flight, which no recorded angle shows", estimate.lean_deg));
  }
}

void fill_path(const LinePass& pass, const PathEstimate& path, LineEstimate& estimate) {
  estimate.scan_model = path.model;
  estimate.method = path.pairs >= 12 ? "pairs" : "";
  if (path.pulses > 0) estimate.method += estimate.method.empty() ? "angles" : "+angles";
  if (path.model != ScanModel::kNone)
    estimate.method += std::string("+") + scan_model_name(path.model);
  estimate.pulses_used = path.pulses;
  estimate.pairs_used = path.pairs;
  estimate.cone_deg = path.model == ScanModel::kCone ? path.cone_deg : 0.0;
  estimate.cone_error_deg = path.cone_error_deg;
  estimate.angle_offset_deg = path.angle_offset_deg;
  estimate.angle_residual_deg = path.angle_residual_deg;
  estimate.scan_residual_deg = path.scan_residual_deg;
  estimate.pair_residual = path.pair_residual;
  fill_course(path, estimate);
  fill_across(path, estimate);
  fill_looks(pass, path, estimate);
  std::vector<double> heights, horizontal, vertical;
  const double step = path.nodes[1].time_s - path.nodes[0].time_s;
  for (const PathNode& node : path.nodes) {
    if (node.bridged) {
      estimate.bridged_s += step;
      continue;
    }
    heights.push_back(node.position.z);
    horizontal.push_back(std::hypot(node.standard_error_m.x, node.standard_error_m.y));
    vertical.push_back(node.standard_error_m.z);
  }
  estimate.height_m = median_of(heights) - ground_of(pass);
  estimate.position_error_m = median_of(horizontal);
  estimate.height_error_m = median_of(vertical);
}

/// The accept test. True where every check passes.
bool accept_path(const PathEstimate& path, const AcceptOptions& accept, LineEstimate& estimate) {
  const auto check = [&](const char* name, double value, double low, double high) {
    estimate.checks.push_back({name, value, low, high, value >= low && value <= high});
  };
  check("height_m", estimate.height_m, accept.least_height_m, accept.most_height_m);
  check("speed_ms", estimate.speed_ms, accept.least_speed_ms, accept.most_speed_ms);
  check("position_error_m", estimate.position_error_m, 0.0,
        accept.most_error_share * std::max(estimate.height_m, 1.0));
  // A clip of a second whose angles are whole degrees: errors that its pulses share are far greater
  // than those that their scatter shows.
  const bool is_clip = estimate.angle_step_deg > 0.0 &&
                       estimate.line.last_time_s - estimate.line.first_time_s < accept.clip_s;
  check("height_error_m", (is_clip ? accept.clip_error_factor : 1.0) * estimate.height_error_m, 0.0,
        accept.most_height_share * std::max(estimate.height_m, 1.0));
  if (path.pulses > 0) {
    check("angle_residual_deg", path.angle_residual_deg, 0.0, accept.most_angle_residual_deg);
    check("angle_offset_deg", path.angle_offset_deg, -accept.most_angle_offset_deg,
          accept.most_angle_offset_deg);
  }
  if (path.pairs >= 12) check("pair_residual", path.pair_residual, 0.0, accept.most_pair_residual);
  return std::all_of(estimate.checks.begin(), estimate.checks.end(),
                     [](const AcceptCheck& c) { return c.passed; });
}

/// A number as people write it: 1140, 17.3, 0.6.
std::string plain(double value) {
  return std::abs(value) >= 100.0 ? format("%.0f", value) : format("%.3g", value);
}

/// A check that failed, for whoever reads the warning.
std::string failure_text(const AcceptCheck& c) {
  struct Words {
    const char* name;
    const char* before;
    const char* unit;
  };
  static constexpr Words kWords[] = {
      {"height_m", "height above ground ", " m"},
      {"speed_ms", "speed ", " m/s"},
      {"position_error_m", "place uncertain by ", " m"},
      {"height_error_m", "height uncertain by ", " m"},
      {"angle_residual_deg", "recorded angles off it by ", " degrees"},
      {"angle_offset_deg", "recorded angles shifted by ", " degrees"},
      {"pair_residual", "returns of one pulse off it by ", " times what their coordinates allow"}};
  const auto* const words = std::find_if(std::begin(kWords), std::end(kWords),
                                         [&](const Words& w) { return c.name == w.name; });
  assert(words != std::end(kWords) && "every check has its words");
  return words->before + plain(c.value) + words->unit + ", allowed " +
         (c.low == 0.0 ? "up to " : plain(c.low) + " to ") + plain(c.high);
}

std::string failed_checks(const LineEstimate& estimate) {
  std::string text = "the path found is not good enough: ";
  const char* between = "";
  for (const AcceptCheck& c : estimate.checks) {
    if (c.passed) continue;
    text += between + failure_text(c);
    between = "; ";
  }
  const FlightLine& line = estimate.line;
  constexpr double kShortS = 5.0;
  const double lasts = line.last_time_s - line.first_time_s;
  if (lasts < kShortS)
    text += format("; the line lasts %.1f s here, more tiles along it would tell more", lasts);
  return text;
}

/// What is left where no path can be had: the direction in which recorded angles grow.
void use_angles(const LinePass& pass, const TrackFit& track, const std::string& reason,
                LineEstimate& estimate) {
  FlightLine& line = estimate.line;
  line.beam_reason = reason;
  line.beam_source = BeamSource::kVertical;
  if (estimate.min_angle_deg == 0.0 && estimate.max_angle_deg == 0.0) {
    line.beam_reason += "; all recorded angles are 0";
    line.scan_angle_sign = 0;
    return;
  }
  const bool flown = !pass.is_timeless && track.is_reliable();
  // A path that is too loose to be used may still know its directions well.
  if (line.scan_angle_sign != 0 && estimate.scan_model != ScanModel::kNone &&
      line.across_standard_error_deg < 1.0 && estimate.along_standard_error_deg < 10.0) {
    line.beam_source = BeamSource::kAngles;
    return;
  }
  const Gradient gradient = angle_gradient(pass);
  if (gradient.error_deg > kMostAcrossErrorDeg) {
    line.beam_reason += "; the recorded angles show no direction on the ground";
    line.scan_angle_sign = 0;
    return;
  }
  line.beam_source = BeamSource::kAngles;
  line.across_standard_error_deg = gradient.error_deg;
  line.across_azimuth_deg = gradient.azimuth_deg;
  line.scan_angle_sign = 1;
  if (!flown) {
    line.along_azimuth_deg = wrapped_360(gradient.azimuth_deg - 90.0);
    estimate.remarks.push_back(
        "direction of flight is not known: across azimuth is that of recorded positive angles");
    return;
  }
  line.along_azimuth_deg = track.course_deg;
  estimate.along_standard_error_deg = track.course_error_deg;
  estimate.speed_ms = norm(track.velocity);
  // True positive angles lie to the right of flight.
  const double left = std::remainder(gradient.azimuth_deg - track.course_deg, 360.0);
  if (left < 0.0) {
    line.scan_angle_sign = -1;
    line.across_azimuth_deg = wrapped_360(gradient.azimuth_deg + 180.0);
  }
}

void fill_perpendicular(LineEstimate& estimate) {
  const FlightLine& line = estimate.line;
  estimate.perpendicular_deg =
      std::remainder(line.across_azimuth_deg - line.along_azimuth_deg - 90.0, 360.0);
  if (line.beam_source == BeamSource::kVertical || std::abs(estimate.perpendicular_deg) <= 3.0)
    return;
  const double known = 2.0 * (line.across_standard_error_deg + estimate.along_standard_error_deg);
  estimate.remarks.push_back(
      std::abs(estimate.perpendicular_deg) <= known + 3.0
          ? format("across and along azimuth are %.1f degrees off square, within twice their "
                   "standard errors (%.1f)",
                   estimate.perpendicular_deg, known)
          : format("across and along azimuth are %.1f degrees off square: the aircraft flies with "
                   "a crab angle or the scanner is mounted turned",
                   estimate.perpendicular_deg));
}

void store_nodes(const PathEstimate& path, FlightLine& line) {
  constexpr double kStoredStepS = 0.5;
  const double step = path.nodes[1].time_s - path.nodes[0].time_s;
  const auto each = static_cast<std::size_t>(std::max(1.0, std::round(kStoredStepS / step)));
  for (std::size_t i = 0; i < path.nodes.size(); ++i) {
    // Half a second apart: attitude needs the finer step, the path does not.
    if (i % each != 0 && i + 1 != path.nodes.size()) continue;
    const PathNode& from = path.nodes[i];
    TrajectoryNode node;
    node.gps_time_s = from.time_s;
    node.position = from.position;
    node.standard_error_m = from.standard_error_m.cast<float>();
    node.bridged = from.bridged;
    line.nodes.push_back(node);
  }
}

}  // namespace

LineEstimate estimate_line(const LinePass& pass, const TrajectoryOptions& options,
                           const AcceptOptions& accept) {
  LineEstimate estimate;
  fill_counts(pass, estimate);
  if (pass.is_timeless) {
    use_angles(pass, {}, "its points carry no usable GPS time", estimate);
    return estimate;
  }
  const TrackFit track = fit_track(pass.bins, 0, pass.bins.size());
  PathEstimate path = best_path(pass, track, options, accept, estimate);
  if (path.is_valid)
    path = refine_path(pass, track, path.pulses > 0 ? estimate.line.scan_angle_sign : 0, path,
                       options);
  if (!path.is_valid) {
    use_angles(pass, track, "too few pulses for a path", estimate);
    fill_perpendicular(estimate);
    return estimate;
  }
  fill_path(pass, path, estimate);
  if (accept_path(path, accept, estimate)) {
    estimate.line.beam_source = BeamSource::kTrajectory;
    store_nodes(path, estimate.line);
  } else {
    use_angles(pass, track, failed_checks(estimate), estimate);
  }
  fill_perpendicular(estimate);
  return estimate;
}

SharedCone shared_cone(const std::vector<LineEstimate>& lines) {
  // Systematic errors of one line; what standard errors below it say is not believed.
  constexpr double kLeastErrorDeg = 0.003;
  constexpr double kMostErrorDeg = 0.05;
  constexpr double kMostSpreadDeg = 0.1;
  SharedCone shared;
  double low = 1e9, high = -1e9, sum = 0.0, weights = 0.0;
  for (const LineEstimate& line : lines) {
    if (line.line.beam_source != BeamSource::kTrajectory || line.scan_model != ScanModel::kCone ||
        line.cone_error_deg > kMostErrorDeg)
      continue;
    const double error = std::max(line.cone_error_deg, kLeastErrorDeg);
    low = std::min(low, line.cone_deg);
    high = std::max(high, line.cone_deg);
    sum += line.cone_deg / (error * error);
    weights += 1.0 / (error * error);
    ++shared.lines;
  }
  if (shared.lines == 0 || high - low > kMostSpreadDeg) return {};
  shared.cone_deg = sum / weights;
  shared.sigma_deg = kLeastErrorDeg;
  return shared;
}

bool needs_cone(const LineEstimate& line, const SharedCone& cone) {
  constexpr double kPoorHeightShare = 0.005;
  if (cone.lines == 0 || !line.line.has_time || line.method.empty()) return false;
  const bool is_poor = line.line.beam_source != BeamSource::kTrajectory ||
                       line.height_error_m > kPoorHeightShare * line.height_m;
  return is_poor && (line.scan_model != ScanModel::kCone ||
                     std::abs(line.cone_deg - cone.cone_deg) < 10.0 * line.cone_error_deg + 0.5);
}

std::size_t settle_unknown_signs(std::vector<LineEstimate>& lines) {
  bool plus = false, minus = false;
  for (const LineEstimate& estimate : lines) {
    if (estimate.sign_from.empty()) continue;
    plus |= estimate.line.scan_angle_sign > 0;
    minus |= estimate.line.scan_angle_sign < 0;
  }
  if (plus == minus) return 0;
  std::size_t settled = 0;
  for (LineEstimate& estimate : lines) {
    FlightLine& line = estimate.line;
    if (line.scan_angle_sign != 0 || line.beam_source != BeamSource::kTrajectory) continue;
    if (estimate.min_angle_deg == 0.0 && estimate.max_angle_deg == 0.0) continue;
    line.scan_angle_sign = plus ? 1 : -1;
    estimate.sign_from = "other lines of the survey";
    ++settled;
  }
  return settled;
}

}  // namespace cornice::flightlines
