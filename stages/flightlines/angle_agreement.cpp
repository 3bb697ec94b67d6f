// SPDX-License-Identifier: GPL-3.0-or-later
// Recorded angles against a path that was found without them.
#include <algorithm>
#include <cmath>
#include <utility>

#include "stages/flightlines/robust.h"
#include "stages/flightlines/trajectory.h"

namespace cornice::flightlines {
namespace {

constexpr double kLargestCrab = 30.0 * kRadians;

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
  const double offset = median_in_place(work);
  for (double& value : difference) value = std::abs(value - offset);
  return {sign, 1.4826 * median_in_place(difference), offset};
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

}  // namespace cornice::flightlines
