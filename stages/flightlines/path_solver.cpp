// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/flightlines/path_solver.h"

#include <algorithm>
#include <cmath>

#include "stages/flightlines/robust.h"

namespace cornice::flightlines {
namespace {

using Eigen::Vector3d;

/// First-last lines that make a path without the help of angles.
constexpr std::size_t kPairsSuffice = 200;
constexpr int kEarlyIterations = 4;
/// Whole degrees count by their middles before they count by their ends.
constexpr int kMiddleIterations = 3;
/// What remains of the weight of the middles once the ends count: where a swath holds one degree.
constexpr double kMiddleShare = 0.0005;
constexpr double kHalfDegree = 0.5 * kRadians;
constexpr double kMostEndSigma = 0.3 * kRadians;
constexpr double kLargestCrab = 30.0 * kRadians;
constexpr double kSettledM = 0.05;

/// Standard normal density over its integral up to z.
double inverse_mills(double z) {
  if (z < -8.0) return -z;
  return std::exp(-0.5 * z * z) /
         (std::sqrt(0.5 * std::numbers::pi) * std::erfc(-z * std::sqrt(0.5)));
}

}  // namespace

PathSolver::PathSolver(const LinePass& pass, const TrackFit& start, int sign, ScanModel model,
                       const TrajectoryOptions& options)
    : options_(options),
      model_(model),
      sign_(sign),
      grid_(pass, options.node_step_s),
      pulses_(collect_pulses(pass, grid_, sign, model, options)),
      states_(grid_.nodes, State::Zero()) {
  if (is_solvable()) start_states(start);
}

void PathSolver::start_states(const TrackFit& start) {
  Vector3d middle = Vector3d::Zero();
  for (const Observation& o : pulses_.observations) middle += o.p;
  middle /= static_cast<double>(pulses_.observations.size());
  // Only pairs and angles together can tell the plane's yaw from the heading.
  prior_ = {middle, model_, pulses_.pairs >= kPairsSuffice && sign_ != 0 ? 20.0 : 0.02};
  const double height = std::clamp(norm(start.across), 300.0, 4000.0);
  Vec3d velocity = start.velocity;
  const double speed = norm(velocity);
  if (!(speed > 1e-3)) velocity = {0.0, options_.speed_ms, 0.0};
  velocity = velocity * (std::clamp(speed, 30.0, 120.0) / std::max(speed, 1e-3));
  for (std::size_t k = 0; k < states_.size(); ++k) {
    State& x = states_[k];
    const Vec3d s = start.start - grid_.origin + velocity * (grid_.time_s(k) - start.time_s);
    x.head<3>() = Vector3d(s.x, s.y, middle.z() + height);
    x(kHeading) = std::atan2(velocity.x, velocity.y);
    x.segment<3>(kVelocity) = to_eigen(velocity);
  }
  if (model_ == ScanModel::kCone) start_cone();
}

/// Half angle of the cone: the middle of the beams' leans.
void PathSolver::start_cone() {
  std::vector<double> leans;
  for (const Observation& o : pulses_.observations) {
    const Vector3d b = (o.p - seen_at(o).head<3>()).normalized();
    leans.push_back(std::acos(std::clamp(-b.z(), -1.0, 1.0)));
  }
  common_(kShape) = std::clamp(median_in_place(leans), 4.0 * kRadians, 40.0 * kRadians);
}

void PathSolver::start_from(const PathEstimate& warm) {
  const std::vector<PathNode>& nodes = warm.nodes;
  if (nodes.size() < 2) return;
  const bool same = warm.model == model_;
  const double step = nodes[1].time_s - nodes[0].time_s;
  const auto last = static_cast<double>(nodes.size() - 2);
  for (std::size_t k = 0; k < states_.size(); ++k) {
    const double at = (grid_.time_s(k) - nodes[0].time_s) / step;
    const auto i = static_cast<std::size_t>(std::clamp(std::floor(at), 0.0, last));
    const PathNode& a = nodes[i];
    const PathNode& b = nodes[i + 1];
    const double w = at - static_cast<double>(i);
    State& x = states_[k];
    x.head<3>() = to_eigen(a.position + (b.position - a.position) * w - grid_.origin);
    x.segment<3>(kVelocity) = to_eigen(a.velocity + (b.velocity - a.velocity) * w);
    x(kHeading) = (a.heading_deg + (b.heading_deg - a.heading_deg) * w) * kRadians;
    if (!same) continue;
    x(kHeading) -= warm.yaw_offset_deg * kRadians;
    x(kAxisSide) = a.axis_side + (b.axis_side - a.axis_side) * w;
    x(kAxisFore) = a.axis_fore + (b.axis_fore - a.axis_fore) * w;
  }
  if (same) {
    is_warm_ = true;
    common_(kOffset) = warm.angle_offset_deg * kRadians;
    if (model_ != ScanModel::kNone)
      common_(kShape) =
          (model_ == ScanModel::kCone ? warm.cone_deg : warm.yaw_offset_deg) * kRadians;
  } else if (model_ == ScanModel::kCone) {
    start_cone();
  }
}

Seen PathSolver::seen_at(const Observation& o) const {
  return (1.0 - o.at) * states_[o.node].head<kSeen>() + o.at * states_[o.node + 1].head<kSeen>();
}

/// Residual scales from medians, then weights.
void PathSolver::weigh(bool is_early) {
  std::vector<Observation>& observations = pulses_.observations;
  std::vector<double> angle, scan, pair;  // of those that have one
  std::vector<double> off(observations.size()), scan_off(observations.size()),
      pair_off(observations.size());
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const Observation& o = observations[i];
    const Seen x = seen_at(o);
    if (o.has_angle) angle.push_back(std::abs(off[i] = angle_value(o, x, common_)));
    if (o.in_scan) scan.push_back(scan_off[i] = std::abs(scan_value(o, x, common_, model_)));
    if (o.has_pair) pair.push_back(pair_off[i] = pair_value(o, x, options_.coordinate_sigma_m));
  }
  const double step = (pulses_.whole_degrees ? 1.0 : 0.006) * kRadians / std::sqrt(12.0);
  scales_.angle = std::max(step, 1.4826 * median_in_place(angle));
  scales_.scan = std::max(options_.least_scan_rad, 1.4826 * median_in_place(scan));
  scales_.pair = std::max(options_.least_beam_scale, median_in_place(pair) / 1.177);
  for (std::size_t i = 0; i < observations.size(); ++i) {
    Observation& o = observations[i];
    o.angle_step = off[i];
    o.weight_angle = o.share * robust_weight(std::abs(off[i]) / scales_.angle, is_early) /
                     (scales_.angle * scales_.angle);
    o.weight_scan =
        robust_weight(scan_off[i] / scales_.scan, is_early) / (scales_.scan * scales_.scan);
    o.weight_pair =
        robust_weight(pair_off[i] / scales_.pair, is_early) / (scales_.pair * scales_.pair);
  }
  if (by_ends_) weigh_ends(off);
}

/// A whole degree says that the angle lies within half a degree of it, give or take some noise: an
/// ordinal probit. Its pull and its information come from pulses near the ends of their degree
/// alone, evenly from both sides wherever a swath ends.
void PathSolver::weigh_ends(const std::vector<double>& off) {
  std::size_t outside = 0;
  for (const double value : off) outside += std::abs(value) > kHalfDegree;
  // Of angles spread evenly, noise sigma puts 2 sigma / sqrt(2 pi) of a degree's share outside.
  const double share =
      static_cast<double>(outside) / static_cast<double>(std::max<std::size_t>(pulses_.angles, 1));
  const double sigma =
      std::clamp(share * std::sqrt(0.5 * std::numbers::pi) * kRadians,
                 std::min(options_.angle_noise_deg * kRadians, kMostEndSigma), kMostEndSigma);
  const double reach = std::max(sigma, 0.1 * kRadians);
  for (std::size_t i = 0; i < off.size(); ++i) {
    Observation& o = pulses_.observations[i];
    if (!o.has_angle) continue;
    double weight = o.weight_angle * kMiddleShare;
    double pull = weight * off[i];
    for (const double side : {-1.0, 1.0}) {
      const double z = (kHalfDegree - side * off[i]) / sigma;
      if (z > 5.0) continue;
      const double mills = inverse_mills(z);
      const double trust = z < 0.0 ? robust_weight(-z * sigma / reach, false) : 1.0;
      pull += trust * side * mills / sigma;
      weight += trust * mills * (mills + z) / (sigma * sigma);
    }
    o.weight_angle = weight;
    o.angle_step = pull / weight;
  }
}

void PathSolver::add_observations(PathSystem& system) const {
  for (const Observation& o : pulses_.observations) {
    const Seen x = seen_at(o);
    Eigen::Matrix<double, kSeen, kSeen> square = Eigen::Matrix<double, kSeen, kSeen>::Zero();
    Seen right = Seen::Zero();
    Eigen::Matrix<double, kSeen, kCommon> border = Eigen::Matrix<double, kSeen, kCommon>::Zero();
    const auto add = [&](const Row& row, double value, double weight) {
      square.noalias() += weight * row.by_state * row.by_state.transpose();
      right -= weight * value * row.by_state;
      border.noalias() += weight * row.by_state * row.by_common.transpose();
      system.corner += weight * row.by_common * row.by_common.transpose();
      system.corner_right -= weight * value * row.by_common;
    };
    if (o.has_angle) add(angle_row(o, x, common_), o.angle_step, o.weight_angle);
    if (o.in_scan) {
      const Row row = scan_row(o, x, common_, model_);
      add(row, row.value, o.weight_scan);
    }
    if (o.has_pair) {
      Row rows[2];
      pair_rows(o, x, options_.coordinate_sigma_m, rows);
      for (const Row& row : rows) add(row, row.value, o.weight_pair);
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

/// No aircraft flies sideways: without this a wrong sign is answered by flying backwards.
void PathSolver::keep_to_course(State& x) const {
  const double course = std::atan2(x(kVelocity), x(kVelocity + 1));
  const double crab = std::remainder(x(kHeading) - course, 2.0 * std::numbers::pi);
  x(kHeading) = std::remainder(course + std::clamp(crab, -kLargestCrab, kLargestCrab),
                               2.0 * std::numbers::pi);
}

/// Takes the step; returns the largest move of a position in metres.
double PathSolver::apply(const PathSolution& solution) {
  double largest = 0.0;
  for (std::size_t k = 0; k < states_.size(); ++k) {
    State& x = states_[k];
    largest = std::max(largest, solution.nodes[k].head<3>().norm());
    x += solution.nodes[k];
    // Below the ground nothing can be linearised.
    x(2) = std::max(x(2), prior_.middle.z() + 30.0);
    keep_to_course(x);
    if (k > 0) {  // one branch along the path
      const double turn = x(kHeading) - states_[k - 1](kHeading);
      x(kHeading) -= turn - std::remainder(turn, 2.0 * std::numbers::pi);
    }
  }
  common_ += solution.common;
  if (model_ == ScanModel::kCone)
    common_(kShape) = std::clamp(common_(kShape), 1.0 * kRadians, 60.0 * kRadians);
  return largest;
}

double PathSolver::cost_per_pulse() const {
  double cost = 0.0;
  for (const Observation& o : pulses_.observations) {
    const Seen x = seen_at(o);
    if (o.has_angle) cost += robust_cost(angle_value(o, x, common_) / scales_.angle);
    if (o.has_pair) cost += robust_cost(pair_value(o, x, options_.coordinate_sigma_m));
  }
  return cost / static_cast<double>(pulses_.observations.size());
}

PathNode PathSolver::node_of(std::size_t k, const PathSolution& solution) const {
  const State& x = states_[k];
  const State& variance = solution.variances[k];
  PathNode node;
  node.time_s = grid_.time_s(k);
  node.position = grid_.origin + Vec3d{x(0), x(1), x(2)};
  node.velocity = {x(kVelocity), x(kVelocity + 1), x(kVelocity + 2)};
  node.standard_error_m = {std::sqrt(variance(0)), std::sqrt(variance(1)), std::sqrt(variance(2))};
  const double yaw = model_ == ScanModel::kPlane ? common_(kShape) : 0.0;
  node.heading_deg = (x(kHeading) + yaw) / kRadians;
  node.heading_error_deg = std::sqrt(variance(kHeading)) / kRadians;
  node.axis_side = x(kAxisSide);
  node.axis_fore = x(kAxisFore);
  node.lean_deg = (model_ == ScanModel::kCone ? std::atan(x(kAxisFore)) : x(kAxisFore)) / kRadians;
  const auto reach = static_cast<std::size_t>(std::ceil(0.5 / grid_.step_s));
  const std::size_t end = std::min(states_.size(), k + reach + 1);
  node.bridged = true;
  for (std::size_t j = k > reach ? k - reach : 0; j < end; ++j)
    if (pulses_.seen[j]) node.bridged = false;
  return node;
}

PathEstimate PathSolver::result(const PathSolution& solution) const {
  PathEstimate estimate;
  estimate.is_valid = true;
  estimate.model = model_;
  if (model_ == ScanModel::kCone) {
    estimate.cone_deg = common_(kShape) / kRadians;
    estimate.cone_error_deg = std::sqrt(solution.common_variances(kShape)) / kRadians;
  }
  estimate.yaw_offset_deg = model_ == ScanModel::kPlane ? common_(kShape) / kRadians : 0.0;
  estimate.angle_offset_deg = common_(kOffset) / kRadians;
  estimate.angle_residual_deg = scales_.angle / kRadians;
  estimate.scan_residual_deg = model_ == ScanModel::kNone ? 0.0 : scales_.scan / kRadians;
  estimate.pair_residual = scales_.pair;
  estimate.pulses = pulses_.angles;
  estimate.pairs = pulses_.pairs;
  estimate.cost_per_pulse = cost_per_pulse();
  for (std::size_t k = 0; k < states_.size(); ++k) estimate.nodes.push_back(node_of(k, solution));
  return estimate;
}

PathEstimate PathSolver::run() {
  bool is_settled = false;
  // The ends of whole degrees say more than their middles, but only once the path is near.
  const bool has_ends = pulses_.whole_degrees && pulses_.angles > 0;
  const int early = is_warm_ ? 0 : kEarlyIterations;
  const int middle = early + (has_ends && !is_warm_ ? kMiddleIterations : 0);
  for (int iteration = 0;; ++iteration) {
    by_ends_ = has_ends && iteration >= middle;
    weigh(iteration < early);
    PathSystem system(states_.size());
    add_observations(system);
    add_priors(states_, common_, prior_, options_, system);
    add_motion(states_, grid_.step_s, options_, system);
    const bool is_last = is_settled || iteration + 1 >= options_.iterations;
    const PathSolution solution = solve_blocks(system, is_last);
    const double moved = apply(solution);
    if (is_last) {
      weigh(false);
      return result(solution);
    }
    is_settled = iteration > middle + (has_ends ? 3 : 0) && moved < kSettledM;
  }
}

}  // namespace cornice::flightlines
