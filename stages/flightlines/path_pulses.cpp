// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/flightlines/path_pulses.h"

#include <algorithm>
#include <cmath>

#include "stages/flightlines/robust.h"

namespace cornice::flightlines {
namespace {

using Eigen::Vector3d;

/// Makes `o` the first-last line of a pulse; false where it has none of use.
bool make_pair(const Pulse& pulse, const TrajectoryOptions& options, Observation& o) {
  const Vector3d up = to_eigen((pulse.first - pulse.last).cast<double>());
  o.pair_m = up.norm();
  if (pulse.conflicting || pulse.first_return >= pulse.last_return ||
      o.pair_m < options.least_pair_m || up.z() < 0.3 * o.pair_m)
    return false;
  o.has_pair = true;
  const Vector3d d = up / o.pair_m;
  o.p += 0.5 * up;
  o.e1 = d.cross(std::abs(d.x()) < 0.5 ? Vector3d::UnitX() : Vector3d::UnitY()).normalized();
  o.e2 = d.cross(o.e1);
  return true;
}

/// The sample in an order of its own: that of the heap depends on the order of points.
std::vector<Pulse> thinned(const std::vector<Pulse>& heap, double kept) {
  std::vector<Pulse> pulses = heap;
  std::sort(pulses.begin(), pulses.end(), [](const Pulse& a, const Pulse& b) {
    return a.hash != b.hash ? a.hash < b.hash : a.time_s < b.time_s;
  });
  if (kept < 1.0)
    pulses.resize(static_cast<std::size_t>(std::ceil(kept * static_cast<double>(pulses.size()))));
  return pulses;
}

/// Middles of whole degrees err evenly to both sides where a swath covers them from end to end; the
/// outermost two are covered in part, and their pulses all err alike: together they count as one.
void share_edges(std::vector<Observation>& observations, std::size_t first) {
  double low = 1e9, high = -1e9;
  for (std::size_t i = first; i < observations.size(); ++i) {
    low = std::min(low, observations[i].angle);
    high = std::max(high, observations[i].angle);
  }
  for (const double edge : {low, high}) {
    double count = 0.0;
    const auto is_there = [&](const Observation& o) {
      return std::abs(o.angle - edge) < 0.5 * kRadians;
    };
    for (std::size_t i = first; i < observations.size(); ++i) count += is_there(observations[i]);
    for (std::size_t i = first; i < observations.size(); ++i)
      if (is_there(observations[i])) observations[i].share = 1.0 / count;
  }
}

}  // namespace

PathGrid::PathGrid(const LinePass& pass, double node_step_s)
    : start_time_s(pass.bins.front()->first_time_s), origin(pass.bins.front()->origin) {
  const double duration = pass.bins.back()->last_time_s - start_time_s;
  const double intervals = std::max(1.0, std::ceil(duration / node_step_s));
  step_s = std::max(duration / intervals, 1e-3);
  nodes = static_cast<std::size_t>(intervals) + 1;
}

PathPulses collect_pulses(const LinePass& pass, const PathGrid& grid, int sign, ScanModel model,
                          const TrajectoryOptions& options) {
  PathPulses result;
  result.seen.assign(grid.nodes, false);
  for (const PulseBin* bin : pass.bins) result.whole_degrees &= !bin->fractional_angles;
  for (const bool pair_list : {false, true}) {
    if (!pair_list && sign == 0 && model == ScanModel::kNone) continue;
    std::size_t total = 0;
    for (const PulseBin* bin : pass.bins)
      total += pair_list ? bin->multiple.size() : bin->any.size();
    const double kept = static_cast<double>(options.most_pulses) /
                        static_cast<double>(std::max(total, std::size_t{1}));
    for (const PulseBin* bin : pass.bins) {
      const std::size_t first = result.observations.size();
      for (const Pulse& pulse : thinned(pair_list ? bin->multiple : bin->any, kept)) {
        Observation o;
        const double at = (pulse.time_s - grid.start_time_s) / grid.step_s;
        o.node = static_cast<std::size_t>(
            std::clamp(std::floor(at), 0.0, static_cast<double>(grid.nodes - 2)));
        o.at = at - static_cast<double>(o.node);
        o.p = to_eigen(bin->origin - grid.origin + pulse.last.cast<double>());
        o.angle = sign * static_cast<double>(pulse.angle_deg) * kRadians;
        o.has_angle = !pair_list && sign != 0;
        o.in_scan = !pair_list && model != ScanModel::kNone;
        if (pair_list && !make_pair(pulse, options, o)) continue;
        result.angles += o.has_angle;
        result.pairs += o.has_pair;
        result.seen[o.node] = result.seen[o.node + 1] = true;
        result.observations.push_back(o);
      }
      if (!pair_list && result.whole_degrees) share_edges(result.observations, first);
    }
  }
  return result;
}

}  // namespace cornice::flightlines
