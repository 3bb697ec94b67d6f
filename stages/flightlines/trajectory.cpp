// SPDX-License-Identifier: GPL-3.0-or-later
// D. Gatziolis, R. J. McGaughey, "Reconstructing Aircraft Trajectories from Multi-Return Airborne
// Laser-Scanning Data", Remote Sensing 11(19), 2019.
#include "stages/flightlines/trajectory.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "stages/flightlines/block_solver.h"

namespace cornice::flightlines {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;
/// First-last lines that make a path without the help of angles.
constexpr std::size_t kPairsSuffice = 200;
constexpr int kEarlyIterations = 4;
constexpr int kMiddleIterations = 3;
constexpr double kSoftestDeg = 0.2;
constexpr int kStepsPerSoftness = 3;  ///< iterations before the ends get half as soft
constexpr double kLargestCrab = 30.0 * kRadians;

// State of a node: 0-2 position, 3 heading, 4-5 axis of the scanner, 6-8 velocity. Observations
// touch the first six only.
constexpr int kState = 9;
constexpr int kSeen = 6;
constexpr int kHeading = 3;
constexpr int kAxisSide = 4;  // cone: lean to the right, tangent
constexpr int kAxisFore = 5;  // plane: pitch of its normal, radians; cone: lean fore, tangent
constexpr int kVelocity = 6;
// Common unknowns: half angle of the cone or yaw of the plane against the heading; angle offset.
constexpr int kCommon = 2;
constexpr int kShape = 0;
constexpr int kOffset = 1;

using System = BlockSystem<kState, kCommon>;
using State = Eigen::Matrix<double, kState, 1>;
using Seen = Eigen::Matrix<double, kSeen, 1>;
using Common = Eigen::Matrix<double, kCommon, 1>;
using Eigen::Vector3d;

struct Observation {
  std::size_t node = 0;  ///< interval [node, node + 1]
  double at = 0.0;       ///< 0..1 within it
  Vector3d p;            ///< a return of the pulse
  double angle = 0.0;    ///< recorded, sign applied, radians
  bool has_angle = false;
  bool has_pair = false;
  bool in_scan = false;
  Vector3d e1, e2;  ///< unit, square to the first-last line
  double pair_m = 0.0;
  double share = 1.0;  ///< of an angle's weight: less where rounding errors are alike
  double weight_angle = 1.0, weight_scan = 1.0, weight_pair = 1.0;
};

/// Robust scales of the three kinds of residuals.
struct Scales {
  double angle = 0.0;  ///< radians
  double scan = 0.0;   ///< radians
  double pair = 1.0;   ///< factor on the expected error
};

/// A residual with its derivatives.
struct Row {
  double value = 0.0;
  Seen by_state = Seen::Zero();
  Common by_common = Common::Zero();
};

Vector3d to_eigen(Vec3d v) { return {v.x, v.y, v.z}; }

/// Weight of Huber while the path is still far off, then of Geman and McClure: far outliers count
/// for nothing, but only once it is known what is far.
double robust_weight(double ratio, bool is_early) {
  if (is_early) return 1.0 / std::max(1.0, ratio);
  const double w = 1.0 / (1.0 + ratio * ratio / 9.0);
  return w * w;
}

double robust_cost(double ratio) { return ratio * ratio / (1.0 + ratio * ratio / 9.0); }

double median_of(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

class PathSolver {
 public:
  PathSolver(const LinePass& pass, const TrackFit& start, int sign, ScanModel model,
             const TrajectoryOptions& options);
  bool is_solvable() const { return pairs_ >= 12 || (angles_ >= 40 && sign_ != 0.0); }
  void start_from(const PathEstimate& warm);
  PathEstimate run();

 private:
  void collect(const LinePass& pass);
  void share_edges(std::size_t first);
  void add_pulse(const PulseBin& bin, const Pulse& pulse, bool pair_list);
  void start_states(const TrackFit& start);
  void start_cone();
  Row angle_row(const Observation& o, const State& x) const;
  Row scan_row(const Observation& o, const State& x) const;
  void pair_rows(const Observation& o, const State& x, Row rows[2]) const;
  State state_at(const Observation& o) const;
  void weigh(bool is_early);
  Row rounded_row(const Observation& o, const State& x) const;
  void add_observations(System& system) const;
  void add_priors(System& system) const;
  void add_motion(System& system) const;
  double apply(const BlockSolution<kState, kCommon>& solution);
  PathEstimate result(const BlockSolution<kState, kCommon>& solution) const;

  TrajectoryOptions options_;
  ScanModel model_;
  double sign_;  ///< +1, -1, or 0 where angles are not used
  bool whole_degrees_ = true;
  double softness_ =
      0.0;  ///< of the ends of whole degrees, radians; 0: residuals from their middle
  double start_time_ = 0.0;
  double step_ = 0.25;
  double course_ = 0.0;
  Vec3d origin_;
  Vector3d middle_;
  double ground_ = 0.0;
  std::vector<Observation> observations_;
  std::vector<State> states_;
  std::vector<bool> seen_;
  Common common_ = Common::Zero();
  Scales scales_;
  std::size_t angles_ = 0;
  std::size_t pairs_ = 0;
};

PathSolver::PathSolver(const LinePass& pass, const TrackFit& start, int sign, ScanModel model,
                       const TrajectoryOptions& options)
    : options_(options), model_(model), sign_(sign) {
  start_time_ = pass.bins.front()->first_time_s;
  const double duration = pass.bins.back()->last_time_s - start_time_;
  const auto intervals =
      static_cast<std::size_t>(std::max(1.0, std::ceil(duration / options.node_step_s)));
  step_ = std::max(duration / static_cast<double>(intervals), 1e-3);
  origin_ = pass.bins.front()->origin;
  states_.assign(intervals + 1, State::Zero());
  seen_.assign(intervals + 1, false);
  for (const PulseBin* bin : pass.bins) whole_degrees_ &= !bin->fractional_angles;
  collect(pass);
  if (is_solvable()) start_states(start);
}

void PathSolver::add_pulse(const PulseBin& bin, const Pulse& pulse, bool pair_list) {
  Observation o;
  const double at = (pulse.time_s - start_time_) / step_;
  const auto last = static_cast<double>(states_.size() - 2);
  o.node = static_cast<std::size_t>(std::clamp(std::floor(at), 0.0, last));
  o.at = at - static_cast<double>(o.node);
  o.p = to_eigen(bin.origin - origin_ + pulse.last.cast<double>());
  o.angle = sign_ * pulse.angle_deg * kRadians;
  const Vector3d up = to_eigen((pulse.first - pulse.last).cast<double>());
  o.pair_m = up.norm();
  if (pair_list) {
    if (pulse.conflicting || pulse.first_return >= pulse.last_return ||
        o.pair_m < options_.least_pair_m || up.z() < 0.3 * o.pair_m)
      return;
    o.has_pair = true;
    const Vector3d d = up / o.pair_m;
    o.p += 0.5 * up;
    o.e1 = d.cross(std::abs(d.x()) < 0.5 ? Vector3d::UnitX() : Vector3d::UnitY()).normalized();
    o.e2 = d.cross(o.e1);
    ++pairs_;
  } else {
    if (sign_ == 0.0 && model_ == ScanModel::kNone) return;
    o.has_angle = sign_ != 0.0;
    o.in_scan = model_ != ScanModel::kNone;
    angles_ += o.has_angle;
  }
  seen_[o.node] = seen_[o.node + 1] = true;
  observations_.push_back(o);
}

void PathSolver::collect(const LinePass& pass) {
  for (const bool pair_list : {false, true}) {
    std::size_t total = 0;
    for (const PulseBin* bin : pass.bins)
      total += pair_list ? bin->multiple.size() : bin->any.size();
    const double kept = static_cast<double>(options_.most_pulses) /
                        static_cast<double>(std::max(total, std::size_t{1}));
    for (const PulseBin* bin : pass.bins) {
      // The heaps' order depends on the order of points; sums must not.
      std::vector<Pulse> pulses = pair_list ? bin->multiple : bin->any;
      std::sort(pulses.begin(), pulses.end(), [](const Pulse& a, const Pulse& b) {
        return a.hash != b.hash ? a.hash < b.hash : a.time_s < b.time_s;
      });
      if (kept < 1.0)
        pulses.resize(
            static_cast<std::size_t>(std::ceil(kept * static_cast<double>(pulses.size()))));
      const std::size_t first = observations_.size();
      for (const Pulse& pulse : pulses) add_pulse(*bin, pulse, pair_list);
      if (!pair_list && whole_degrees_) share_edges(first);
    }
  }
}

/// Whole degrees err evenly to both sides where a swath covers them from end to end; the outermost
/// two are covered in part, and their pulses all err alike: together they count as one.
void PathSolver::share_edges(std::size_t first) {
  double low = 1e9, high = -1e9;
  for (std::size_t i = first; i < observations_.size(); ++i) {
    low = std::min(low, observations_[i].angle);
    high = std::max(high, observations_[i].angle);
  }
  for (const double edge : {low, high}) {
    double count = 0.0;
    const auto is_there = [&](const Observation& o) {
      return std::abs(o.angle - edge) < 0.5 * kRadians;
    };
    for (std::size_t i = first; i < observations_.size(); ++i) count += is_there(observations_[i]);
    for (std::size_t i = first; i < observations_.size(); ++i)
      if (is_there(observations_[i])) observations_[i].share = 1.0 / count;
  }
}

void PathSolver::start_states(const TrackFit& start) {
  middle_.setZero();
  for (const Observation& o : observations_) middle_ += o.p;
  middle_ /= static_cast<double>(observations_.size());
  ground_ = middle_.z();
  const double across = norm(start.across);
  const double height = std::clamp(across, 300.0, 4000.0);
  Vec3d velocity = start.velocity;
  const double speed = norm(velocity);
  if (!(speed > 1e-3)) velocity = {0.0, options_.speed_ms, 0.0};
  velocity = velocity * (std::clamp(speed, 30.0, 120.0) / std::max(speed, 1e-3));
  course_ = std::atan2(velocity.x, velocity.y);
  for (std::size_t k = 0; k < states_.size(); ++k) {
    const double t = start_time_ + static_cast<double>(k) * step_ - start.time_s;
    State& x = states_[k];
    const Vec3d s = start.start - origin_ + velocity * t;
    x.head<3>() = Vector3d(s.x, s.y, ground_ + height);
    x(kHeading) = course_;
    x.segment<3>(kVelocity) = to_eigen(velocity);
  }
  if (model_ == ScanModel::kCone) start_cone();
}

/// Half angle of the cone: the middle of the beams' leans.
void PathSolver::start_cone() {
  std::vector<double> leans;
  for (const Observation& o : observations_) {
    const Vector3d b = (o.p - state_at(o).head<3>()).normalized();
    leans.push_back(std::acos(std::clamp(-b.z(), -1.0, 1.0)));
  }
  common_(kShape) = std::clamp(median_of(leans), 4.0 * kRadians, 40.0 * kRadians);
}

/// Takes position, velocity and heading over; the cone's angle follows from them.
void PathSolver::start_from(const PathEstimate& warm) {
  if (warm.nodes.size() != states_.size()) return;
  for (std::size_t k = 0; k < states_.size(); ++k) {
    const PathNode& node = warm.nodes[k];
    states_[k].head<3>() = to_eigen(node.position - origin_);
    states_[k].segment<3>(kVelocity) = to_eigen(node.velocity);
    states_[k](kHeading) = node.heading_deg * kRadians;
  }
  if (model_ == ScanModel::kCone) start_cone();
  if (warm.model != model_) return;
  common_(kShape) = (model_ == ScanModel::kCone ? warm.cone_deg : warm.yaw_offset_deg) * kRadians;
  for (std::size_t k = 0; k < states_.size(); ++k) {
    const double lean = warm.nodes[k].lean_deg * kRadians;
    states_[k](kAxisFore) = model_ == ScanModel::kCone ? std::tan(lean) : lean;
  }
}

State PathSolver::state_at(const Observation& o) const {
  return (1.0 - o.at) * states_[o.node] + o.at * states_[o.node + 1];
}

/// Recorded angle: atan(lateral offset / height) square to the heading.
Row PathSolver::angle_row(const Observation& o, const State& x) const {
  const Vector3d d = o.p - x.head<3>();
  const double s = std::sin(x(kHeading)), c = std::cos(x(kHeading));
  const double u = c * d.x() - s * d.y();
  const double fore = s * d.x() + c * d.y();
  const double h = -d.z();
  const double square = std::max(u * u + h * h, 1.0);
  Row row;
  row.value = std::atan2(u, h) - o.angle - common_(kOffset);
  row.by_state(0) = -h * c / square;
  row.by_state(1) = h * s / square;
  row.by_state(2) = -u / square;
  row.by_state(kHeading) = -h * fore / square;
  row.by_common(kOffset) = -1.0;
  return row;
}

/// A whole degree says only that the angle lies within half a degree of it. Inside there is nothing
/// to gain; towards its ends the residual grows as a soft plus, beyond them as the distance. What
/// is known exactly are the places where one degree ends and the next begins.
Row PathSolver::rounded_row(const Observation& o, const State& x) const {
  Row row = angle_row(o, x);
  const double beyond = (std::abs(row.value) - 0.5 * kRadians) / softness_;
  const double slope = 1.0 / (1.0 + std::exp(-beyond));
  const double value = beyond > 30.0 ? beyond : std::log1p(std::exp(beyond));
  row.by_state *= slope;
  row.by_common *= slope;
  row.value = std::copysign(value * softness_, row.value);
  return row;
}

/// A plane's beams are square to its normal, a cone's make one angle with its axis.
Row PathSolver::scan_row(const Observation& o, const State& x) const {
  const Vector3d d = o.p - x.head<3>();
  const double range = std::max(d.norm(), 1.0);
  const Vector3d b = d / range;
  const bool is_plane = model_ == ScanModel::kPlane;
  const double yaw = x(kHeading) + (is_plane ? common_(kShape) : 0.0);
  const double s = std::sin(yaw), c = std::cos(yaw);
  Vector3d m, m_yaw, m_side = Vector3d::Zero(), m_fore;
  if (is_plane) {
    const double cp = std::cos(x(kAxisFore)), sp = std::sin(x(kAxisFore));
    m = Vector3d(s * cp, c * cp, sp);
    m_yaw = Vector3d(c * cp, -s * cp, 0.0);
    m_fore = Vector3d(-s * sp, -c * sp, cp);
  } else {
    const Vector3d right(c, -s, 0.0), fore(s, c, 0.0);
    const Vector3d axis = x(kAxisSide) * right + x(kAxisFore) * fore - Vector3d::UnitZ();
    const double length = axis.norm();
    m = axis / length;
    const auto turned = [&](const Vector3d& v) -> Vector3d { return (v - m * m.dot(v)) / length; };
    m_yaw = turned(x(kAxisSide) * -fore + x(kAxisFore) * right);
    m_side = turned(right);
    m_fore = turned(fore);
  }
  const double cosine = m.dot(b);
  Row row;
  double slope = 1.0;
  if (is_plane) {
    row.value = cosine;
    row.by_common(kShape) = m_yaw.dot(b);
  } else {
    const double angle = std::acos(std::clamp(cosine, -0.999999, 0.999999));
    slope = -1.0 / std::sin(angle);
    row.value = angle - common_(kShape);
    row.by_common(kShape) = -1.0;
  }
  row.by_state.head<3>() = slope * -(m - cosine * b) / range;
  row.by_state(kHeading) = slope * m_yaw.dot(b);
  row.by_state(kAxisSide) = slope * m_side.dot(b);
  row.by_state(kAxisFore) = slope * m_fore.dot(b);
  return row;
}

/// The first-last line misses the sensor by this, relative to what the coordinates allow.
void PathSolver::pair_rows(const Observation& o, const State& x, Row rows[2]) const {
  const Vector3d d = x.head<3>() - o.p;
  // Both returns err by sigma: at the sensor the line errs by sqrt(2) sigma range / length.
  const double expected =
      options_.coordinate_sigma_m * std::sqrt(0.5 + 2.0 * d.squaredNorm() / (o.pair_m * o.pair_m));
  for (const int i : {0, 1}) {
    const Vector3d& e = i == 0 ? o.e1 : o.e2;
    rows[i].value = e.dot(d) / expected;
    rows[i].by_state.head<3>() = e / expected;
  }
}

/// Residual scales from medians, then weights.
void PathSolver::weigh(bool is_early) {
  std::vector<double> angle, scan, pair;
  std::vector<std::array<double, 3>> values(observations_.size());
  for (std::size_t i = 0; i < observations_.size(); ++i) {
    const Observation& o = observations_[i];
    const State x = state_at(o);
    if (o.has_angle) angle.push_back(values[i][0] = std::abs(angle_row(o, x).value));
    if (o.in_scan) scan.push_back(values[i][1] = std::abs(scan_row(o, x).value));
    if (o.has_pair) {
      Row rows[2];
      pair_rows(o, x, rows);
      pair.push_back(values[i][2] = std::hypot(rows[0].value, rows[1].value));
    }
  }
  const double step = (whole_degrees_ ? 1.0 : 0.006) * kRadians / std::sqrt(12.0);
  scales_.angle = std::max(step, 1.4826 * median_of(angle));
  scales_.scan = std::max(2e-5, 1.4826 * median_of(scan));
  scales_.pair = std::max(options_.least_beam_scale, median_of(pair) / 1.177);
  for (std::size_t i = 0; i < observations_.size(); ++i) {
    Observation& o = observations_[i];
    if (softness_ > 0.0)  // Two degrees off is an outlier; near the ends all count alike.
      o.weight_angle =
          robust_weight(values[i][0] / (0.7 * kRadians), false) / (softness_ * softness_);
    else
      o.weight_angle = o.share * robust_weight(values[i][0] / scales_.angle, is_early) /
                       (scales_.angle * scales_.angle);
    o.weight_scan =
        robust_weight(values[i][1] / scales_.scan, is_early) / (scales_.scan * scales_.scan);
    o.weight_pair =
        robust_weight(values[i][2] / scales_.pair, is_early) / (scales_.pair * scales_.pair);
  }
}

void PathSolver::add_observations(System& system) const {
  for (const Observation& o : observations_) {
    const State x = state_at(o);
    Eigen::Matrix<double, kSeen, kSeen> square = Eigen::Matrix<double, kSeen, kSeen>::Zero();
    Seen right = Seen::Zero();
    Eigen::Matrix<double, kSeen, kCommon> border = Eigen::Matrix<double, kSeen, kCommon>::Zero();
    const auto add = [&](const Row& row, double weight) {
      square.noalias() += weight * row.by_state * row.by_state.transpose();
      right -= weight * row.value * row.by_state;
      border.noalias() += weight * row.by_state * row.by_common.transpose();
      system.corner += weight * row.by_common * row.by_common.transpose();
      system.corner_right -= weight * row.value * row.by_common;
    };
    if (o.has_angle) add(softness_ > 0.0 ? rounded_row(o, x) : angle_row(o, x), o.weight_angle);
    if (o.in_scan) add(scan_row(o, x), o.weight_scan);
    if (o.has_pair) {
      Row rows[2];
      pair_rows(o, x, rows);
      add(rows[0], o.weight_pair);
      add(rows[1], o.weight_pair);
    }
    const double w1 = o.at, w0 = 1.0 - o.at;
    const std::size_t k = o.node;
    system.diagonal[k].topLeftCorner<kSeen, kSeen>() += w0 * w0 * square;
    system.diagonal[k + 1].topLeftCorner<kSeen, kSeen>() += w1 * w1 * square;
    system.upper[k].topLeftCorner<kSeen, kSeen>() += w0 * w1 * square;
    system.right[k].head<kSeen>() += w0 * right;
    system.right[k + 1].head<kSeen>() += w1 * right;
    system.border[k].topRows<kSeen>() += w0 * border;
    system.border[k + 1].topRows<kSeen>() += w1 * border;
  }
}

/// Priors on means: each is one observation, shared by all nodes.
void PathSolver::add_priors(System& system) const {
  const double share = 1.0 / static_cast<double>(states_.size());
  const auto add = [&](std::size_t k, int i, double value, double sigma) {
    const double weight = share / (sigma * sigma);
    system.diagonal[k](i, i) += weight;
    system.right[k](i) -= weight * value;
  };
  for (std::size_t k = 0; k < states_.size(); ++k) {
    const State& x = states_[k];
    add(k, 0, x(0) - middle_.x(), 5000.0);
    add(k, 1, x(1) - middle_.y(), 5000.0);
    add(k, 2, x(2) - ground_ - 1500.0, 3000.0);
    const double course = std::atan2(x(kVelocity), x(kVelocity + 1));
    add(k, kHeading, std::remainder(x(kHeading) - course, 2.0 * std::numbers::pi),
        options_.crab_sigma_deg * kRadians);
    add(k, kAxisSide, x(kAxisSide), options_.attitude_sigma_deg * kRadians);
    add(k, kAxisFore, x(kAxisFore), options_.attitude_sigma_deg * kRadians);
    const double speed = std::hypot(x(kVelocity), x(kVelocity + 1));
    for (const int i : {0, 1}) {
      const double unit = x(kVelocity + i) / std::max(speed, 1.0);
      add(k, kVelocity + i, (speed - options_.speed_ms) * unit, options_.speed_sigma_ms);
    }
    add(k, kVelocity + 2, x(kVelocity + 2), options_.climb_sigma_ms);
  }
  const auto common = [&](int i, double value, double sigma) {
    system.corner(i, i) += 1.0 / (sigma * sigma);
    system.corner_right(i) -= value / (sigma * sigma);
  };
  common(kOffset, common_(kOffset), options_.angle_offset_sigma_deg * kRadians);
  if (model_ == ScanModel::kCone)
    common(kShape, common_(kShape) - 18.0 * kRadians, 20.0 * kRadians);
  else  // Only pairs and angles together can tell the plane's yaw from the heading.
    common(kShape, common_(kShape),
           (pairs_ >= kPairsSuffice && sign_ != 0.0 ? 20.0 : 0.02) * kRadians);
}

/// Smoothness: velocity, heading and axis walk randomly, position follows velocity.
void PathSolver::add_motion(System& system) const {
  const double root = std::sqrt(step_);
  const double velocity_sigma = options_.velocity_walk_ms * root;
  const double position_sigma = velocity_sigma * step_ / std::sqrt(12.0);
  const double heading_sigma = options_.heading_walk_deg * kRadians * root;
  const double axis_sigma = options_.attitude_walk_deg * kRadians * root;
  for (std::size_t k = 0; k + 1 < states_.size(); ++k) {
    const State step = states_[k + 1] - states_[k];
    const auto walk = [&](int i, double sigma) {
      const double weight = 1.0 / (sigma * sigma);
      system.diagonal[k](i, i) += weight;
      system.diagonal[k + 1](i, i) += weight;
      system.upper[k](i, i) -= weight;
      system.right[k](i) += weight * step(i);
      system.right[k + 1](i) -= weight * step(i);
    };
    walk(kHeading, heading_sigma);
    walk(kAxisSide, axis_sigma);
    walk(kAxisFore, axis_sigma);
    for (const int i : {0, 1, 2}) {
      walk(kVelocity + i, velocity_sigma);
      // e = p' - p - step (v + v') / 2
      const double weight = 1.0 / (position_sigma * position_sigma);
      const int v = kVelocity + i;
      const double half = 0.5 * step_;
      const double e = step(i) - half * (states_[k](v) + states_[k + 1](v));
      const Eigen::Vector2d before(-1.0, -half), after(1.0, -half);
      const int index[2] = {i, v};
      for (const int r : {0, 1}) {
        for (const int c : {0, 1}) {
          system.diagonal[k](index[r], index[c]) += weight * before(r) * before(c);
          system.diagonal[k + 1](index[r], index[c]) += weight * after(r) * after(c);
          system.upper[k](index[r], index[c]) += weight * before(r) * after(c);
        }
        system.right[k](index[r]) -= weight * e * before(r);
        system.right[k + 1](index[r]) -= weight * e * after(r);
      }
    }
  }
}

/// Takes the step; returns the largest move of a position in metres.
double PathSolver::apply(const BlockSolution<kState, kCommon>& solution) {
  double largest = 0.0;
  for (std::size_t k = 0; k < states_.size(); ++k) {
    largest = std::max(largest, solution.nodes[k].head<3>().norm());
    states_[k] += solution.nodes[k];
    // Below the ground nothing can be linearised.
    states_[k](2) = std::max(states_[k](2), ground_ + 30.0);
    // No aircraft flies sideways: without this a wrong sign is answered by flying backwards.
    const double course = std::atan2(states_[k](kVelocity), states_[k](kVelocity + 1));
    const double crab = std::remainder(states_[k](kHeading) - course, 2.0 * std::numbers::pi);
    states_[k](kHeading) = std::remainder(course + std::clamp(crab, -kLargestCrab, kLargestCrab),
                                          2.0 * std::numbers::pi);
    if (k > 0) {  // one branch along the path
      const double turn = states_[k](kHeading) - states_[k - 1](kHeading);
      states_[k](kHeading) -= turn - std::remainder(turn, 2.0 * std::numbers::pi);
    }
  }
  common_ += solution.common;
  if (model_ == ScanModel::kCone)
    common_(kShape) = std::clamp(common_(kShape), 1.0 * kRadians, 60.0 * kRadians);
  return largest;
}

PathEstimate PathSolver::result(const BlockSolution<kState, kCommon>& solution) const {
  PathEstimate estimate;
  estimate.is_valid = true;
  estimate.model = model_;
  estimate.cone_deg = model_ == ScanModel::kCone ? common_(kShape) / kRadians : 90.0;
  estimate.yaw_offset_deg = model_ == ScanModel::kPlane ? common_(kShape) / kRadians : 0.0;
  estimate.angle_offset_deg = common_(kOffset) / kRadians;
  estimate.angle_residual_deg = scales_.angle / kRadians;
  estimate.scan_residual_deg = model_ == ScanModel::kNone ? 0.0 : scales_.scan / kRadians;
  estimate.pair_residual = scales_.pair;
  estimate.pulses = angles_;
  estimate.pairs = pairs_;
  double cost = 0.0;
  for (const Observation& o : observations_) {
    const State x = state_at(o);
    if (o.has_angle) cost += robust_cost(angle_row(o, x).value / scales_.angle);
    if (!o.has_pair) continue;
    Row rows[2];
    pair_rows(o, x, rows);
    cost += robust_cost(std::hypot(rows[0].value, rows[1].value));
  }
  estimate.cost_per_pulse = cost / static_cast<double>(observations_.size());
  const auto reach = static_cast<std::ptrdiff_t>(std::ceil(0.5 / step_));
  const auto count = static_cast<std::ptrdiff_t>(states_.size());
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    const State& x = states_[static_cast<std::size_t>(k)];
    const State& variance = solution.variances[static_cast<std::size_t>(k)];
    PathNode node;
    node.time_s = start_time_ + static_cast<double>(k) * step_;
    node.position = origin_ + Vec3d{x(0), x(1), x(2)};
    node.velocity = {x(kVelocity), x(kVelocity + 1), x(kVelocity + 2)};
    node.standard_error_m = {std::sqrt(variance(0)), std::sqrt(variance(1)),
                             std::sqrt(variance(2))};
    node.heading_deg = x(kHeading) / kRadians + estimate.yaw_offset_deg;
    node.heading_error_deg = std::sqrt(variance(kHeading)) / kRadians;
    node.lean_deg =
        (model_ == ScanModel::kCone ? std::atan(x(kAxisFore)) : x(kAxisFore)) / kRadians;
    node.bridged = true;
    for (std::ptrdiff_t j = std::max<std::ptrdiff_t>(0, k - reach);
         j <= std::min(count - 1, k + reach); ++j)
      if (seen_[static_cast<std::size_t>(j)]) node.bridged = false;
    estimate.nodes.push_back(node);
  }
  return estimate;
}

PathEstimate PathSolver::run() {
  bool is_settled = false;
  // The ends of whole degrees say more than their middles, but only once the path is near.
  const bool rounds = whole_degrees_ && angles_ > 0;
  const int middle_iterations = rounds ? kEarlyIterations + kMiddleIterations : kEarlyIterations;
  for (int iteration = 0;; ++iteration) {
    if (rounds && iteration >= middle_iterations)
      softness_ =
          std::max(kSoftestDeg * std::pow(0.5, (iteration - middle_iterations) / kStepsPerSoftness),
                   options_.angle_noise_deg) *
          kRadians;
    weigh(iteration < kEarlyIterations);
    System system(states_.size());
    add_observations(system);
    add_priors(system);
    add_motion(system);
    const bool is_last = is_settled || iteration + 1 >= options_.iterations;
    const auto solution = solve_blocks(system, is_last);
    const double moved = apply(solution);
    if (is_last) {
      weigh(false);
      return result(solution);
    }
    is_settled =
        iteration > middle_iterations + (rounds ? 3 * kStepsPerSoftness : 0) && moved < 0.05;
  }
}

/// A point as the sensor on a path sees it, and its recorded angle.
struct BodyOffset {
  double right, fore, down;  ///< of the course, metres
  double angle_deg;
};

std::vector<BodyOffset> body_offsets(const LinePass& pass, const PathEstimate& path) {
  constexpr std::size_t kMost = 3000;
  std::size_t total = 0;
  for (const PulseBin* bin : pass.bins) total += bin->any.size();
  const auto each = static_cast<std::uint32_t>(1 + total / kMost);
  std::vector<BodyOffset> offsets;
  const double step = path.nodes[1].time_s - path.nodes[0].time_s;
  const auto last = static_cast<double>(path.nodes.size() - 2);
  for (const PulseBin* bin : pass.bins)
    for (const Pulse& pulse : bin->any) {
      if (pulse.hash % each != 0) continue;
      const double at = (pulse.time_s - path.nodes[0].time_s) / step;
      const auto k = static_cast<std::size_t>(std::clamp(std::floor(at), 0.0, last));
      const PathNode& a = path.nodes[k];
      const PathNode& b = path.nodes[k + 1];
      const double w = at - static_cast<double>(k);
      const Vec3d d =
          bin->origin + pulse.last.cast<double>() - a.position - (b.position - a.position) * w;
      const double course = std::atan2(a.velocity.x, a.velocity.y);
      const double s = std::sin(course), c = std::cos(course);
      offsets.push_back({d.x * c - d.y * s, d.x * s + d.y * c, -d.z, pulse.angle_deg});
    }
  return offsets;
}

/// Residual of recorded angles, were they measured square to a heading `crab` off the course.
AngleAgreement agreement_at(const std::vector<BodyOffset>& offsets, int sign, double crab) {
  std::vector<double> difference;
  difference.reserve(offsets.size());
  const double s = std::sin(crab), c = std::cos(crab);
  for (const BodyOffset& o : offsets)
    difference.push_back(std::atan2(o.right * c - o.fore * s, o.down) / kRadians -
                         sign * o.angle_deg);
  std::vector<double> work = difference;
  const double offset = median_of(work);
  for (double& value : difference) value = std::abs(value - offset);
  return {sign, 1.4826 * median_of(difference), offset};
}

/// The crab angle that recorded angles agree with best; a conical scanner shows it, a plane does
/// not care.
AngleAgreement best_crab(const std::vector<BodyOffset>& offsets, int sign) {
  AngleAgreement best = agreement_at(offsets, sign, 0.0);
  double at = 0.0;
  for (const double step : {4.0, 1.0, 0.25}) {
    const double middle = at;
    for (int i = -5; i <= 5; ++i) {
      const double crab = std::clamp(middle + i * step * kRadians, -kLargestCrab, kLargestCrab);
      const AngleAgreement trial = agreement_at(offsets, sign, crab);
      if (trial.residual_deg < best.residual_deg) {
        best = trial;
        at = crab;
      }
    }
  }
  return best;
}

}  // namespace

const char* scan_model_name(ScanModel model) {
  switch (model) {
    case ScanModel::kPlane:
      return "plane";
    case ScanModel::kCone:
      return "cone";
    case ScanModel::kNone:
      break;
  }
  return "none";
}

PathEstimate solve_path(const LinePass& pass, const TrackFit& start, int sign, ScanModel model,
                        const TrajectoryOptions& options, const PathEstimate* warm) {
  PathSolver solver(pass, start, sign, model, options);
  if (!solver.is_solvable()) return {};
  if (warm != nullptr && warm->is_valid) solver.start_from(*warm);
  return solver.run();
}

AngleAgreement compare_angles(const LinePass& pass, const PathEstimate& path) {
  const std::vector<BodyOffset> offsets = body_offsets(pass, path);
  if (offsets.size() < 20) return {};
  AngleAgreement best, other;
  best = best_crab(offsets, 1);
  other = best_crab(offsets, -1);
  // A wrong sign shows as spread in a wide swath and as an offset in a narrow one.
  const auto wrong = [](const AngleAgreement& a) {
    return a.residual_deg + std::abs(a.offset_deg);
  };
  if (wrong(other) < wrong(best)) std::swap(best, other);
  if (!(wrong(other) > 1.5 * wrong(best) + 0.1)) best.sign = 0;
  return best;
}

PathEstimate estimate_path(const LinePass& pass, const TrackFit& start, int sign,
                           const TrajectoryOptions& options) {
  // Beams of a plane or a cone keep to it within this; attitude between nodes takes most of it.
  constexpr double kScanFitsDeg = 0.3;
  // A scan model that first-last lines contradict is wrong, however well it fits single returns.
  constexpr double kPairsSuffer = 1.3;
  PathEstimate best = solve_path(pass, start, sign, ScanModel::kNone, options);
  if (!best.is_valid) return best;
  const bool paired = best.pairs >= kPairsSuffice;
  const PathEstimate* warm = paired ? &best : nullptr;
  const double most_pair = paired ? kPairsSuffer * best.pair_residual + 0.1 : 1e9;
  double least = kScanFitsDeg;
  PathEstimate chosen;
  for (const ScanModel model : {ScanModel::kPlane, ScanModel::kCone}) {
    PathEstimate path = solve_path(pass, start, sign, model, options, warm);
    if (!path.is_valid || path.scan_residual_deg >= least || path.pair_residual > most_pair)
      continue;
    least = path.scan_residual_deg;
    chosen = std::move(path);
  }
  return chosen.is_valid ? chosen : best;
}

}  // namespace cornice::flightlines
