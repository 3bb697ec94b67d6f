// SPDX-License-Identifier: GPL-3.0-or-later
// Marching by bounds: Kalra & Barr, "Guaranteed ray intersections with implicit surfaces", 1989,
// with a bound on curvature rather than on slope.
#include "stages/simulate/scene_rays.h"

#include <algorithm>
#include <cmath>

namespace cornice::simulate {
namespace {

/// Share of the mesh step that the mesh stands off level ground; more where the ground curves, but
/// less than the three shells at which a ray counts as having left.
constexpr double kShellShare = 0.1;
constexpr int kMostSteps = 200;
/// Largest curvature of F along a ray against its steepness that steps reckon with, 1/m. Sharper
/// edges cost a bracketed search, no more.
constexpr double kSharpest = 1.0;
constexpr double kFlattest = 0.2;
constexpr double kSettled = 8e-4;
/// Newton's method steps past the ground where it curves towards the ray; harmless where the ray
/// falls this steeply from this near.
constexpr double kSteep = -0.5;
constexpr double kSteepWithin = 0.25;
/// With two samples the error is of the order of the product of their squares.
constexpr double kSettledByTwo = 1.5e-3;
constexpr double kLeastStep = 1e-5;
constexpr int kMostShells = 64;

/// F on a ray.
struct Sample {
  double t, value, slope;
  Vec3d gradient;
};

/// The root near the second sample by the cubic through both (inverse Hermite interpolation), and
/// the gradient there by the line through both.
void settle_between(const Sample& first, const Sample& second, GroundHit& hit) {
  const double span = first.value - second.value;
  const double s = -second.value / span;
  const double r = 1.0 - s;
  hit.range_m = r * r * (1.0 + 2.0 * s) * second.t + s * s * (3.0 - 2.0 * s) * first.t +
                span * (s * r * r / second.slope - s * s * r / first.slope);
  const double share = (hit.range_m - second.t) / (first.t - second.t);
  hit.gradient = second.gradient + (first.gradient - second.gradient) * share;
}

bool clip_to_box(const Box3d& box, Vec3d origin, Vec3d direction, double& begin, double& end) {
  const double o[3] = {origin.x, origin.y, origin.z};
  const double d[3] = {direction.x, direction.y, direction.z};
  const double low[3] = {box.min.x, box.min.y, box.min.z};
  const double high[3] = {box.max.x, box.max.y, box.max.z};
  for (int axis = 0; axis < 3; ++axis) {
    if (d[axis] == 0.0) {
      if (o[axis] < low[axis] || o[axis] > high[axis]) return false;
      continue;
    }
    const double a = (low[axis] - o[axis]) / d[axis], b = (high[axis] - o[axis]) / d[axis];
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  return begin <= end;
}

}  // namespace

GroundRays::GroundRays(const GroundField& field, const Box2d& area, double mesh_step_m, int threads)
    : field_(field), shell_m_(kShellShare * mesh_step_m) {
  SurfaceOptions options;
  options.window = area;
  options.step_m = mesh_step_m;
  options.offset_m = shell_m_;
  options.tolerance_m = 0.0;
  options.threads = threads;
  Surface surface = extract_surface(field, options);
  origin_ = surface.origin;
  for (const Vec3f& p : surface.positions) bounds_.add(origin_ + p.cast<double>());
  bounds_.min -= Vec3d{0.0, 0.0, 1.0};
  bounds_.max += Vec3d{0.0, 0.0, 1.0};
  mesh_ =
      std::make_unique<RayMesh>(std::move(surface.positions), std::move(surface.quads), threads);
}

bool GroundRays::cast(Vec3d origin, Vec3d direction, double far_m, GroundHit& hit) const {
  const Vec3d sum = origin + direction;
  if (!std::isfinite(sum.x + sum.y + sum.z)) return false;  // Embree ends the program on NaN
  double t = 0.0, end = far_m;
  if (!clip_to_box(bounds_, origin, direction, t, end)) return false;
  bool in_shell = t == 0.0 && starts_in_shell(origin);
  for (int shell = 0; shell < kMostShells; ++shell) {
    if (!in_shell) {
      RayMesh::Hit guide{};
      const Vec3d start = origin + direction * t - origin_;
      if (!mesh_->cast(start.cast<float>(), direction.cast<float>(), static_cast<float>(end - t),
                       guide)) {
        return false;
      }
      t += static_cast<double>(guide.range);
    }
    in_shell = false;
    switch (follow(origin, direction, t, hit)) {
      case Outcome::kHit:
        return hit.range_m <= far_m;
      case Outcome::kLeft:
        break;
      case Outcome::kBuried:
        return false;
      case Outcome::kGrazing:
        grazing_.fetch_add(1, std::memory_order_relaxed);
        return false;
    }
    if (t >= end) return false;
  }
  grazing_.fetch_add(1, std::memory_order_relaxed);
  return false;
}

/// A ray from so near the ground meets no guiding mesh on its way to it.
bool GroundRays::starts_in_shell(Vec3d origin) const {
  Vec3d gradient;
  const double value = field_.value(origin, gradient);
  return value >= 0.0 && value < 3.0 * shell_m_ * std::max(norm(gradient), kFlattest);
}

/// From range t on the guiding mesh to the ground (kHit) or out of the shell (kLeft, t there).
GroundRays::Outcome GroundRays::follow(Vec3d origin, Vec3d direction, double& t,
                                       GroundHit& hit) const {
  Vec3d gradient;
  double value = field_.value(origin + direction * t, gradient);
  if (value < 0.0) {
    // The ground stands out of the mesh here: the crossing lies behind.
    for (double back = shell_m_; back < 40.0 * shell_m_; back *= 2.0) {
      if (field_.value(origin + direction * (t - back)) > 0.0) {
        return close_in(origin, direction, t - back, t, value, gradient, hit);
      }
    }
    return Outcome::kBuried;
  }
  for (int step = 0; step < kMostSteps; ++step) {
    // Far inside a void the gradient vanishes.
    const double steepness = std::max(norm(gradient), kFlattest);
    const double distance = value / steepness;
    const double slope = dot(gradient, direction) / steepness;
    if (slope > 0.0 && distance > 3.0 * shell_m_) return Outcome::kLeft;
    if (slope < 0.0 && distance < kSettled * slope * slope) {
      // The last Newton step; the error left is of the order of its square.
      hit.range_m = t - distance / slope;
      hit.point = origin + direction * hit.range_m;
      hit.gradient = gradient;
      return Outcome::kHit;
    }
    const double before = t;
    if (slope < kSteep && distance < kSteepWithin) {
      // Too steep and too near to cross the ground twice within a Newton step.
      const Sample first{t, value, slope * steepness, gradient};
      t -= distance / slope;
      value = field_.value(origin + direction * t, gradient);
      const Sample second{t, value, dot(gradient, direction), gradient};
      if (std::abs(value) < kSettledByTwo * steepness && second.slope < 0.5 * first.slope) {
        settle_between(first, second, hit);
        hit.point = origin + direction * hit.range_m;
        return Outcome::kHit;
      }
    } else {
      // The first root of distance + slope s - kSharpest s^2 / 2: no crossing comes before it.
      const double root = std::sqrt(slope * slope + 2.0 * kSharpest * distance);
      const double ahead =
          slope < 0.0 ? 2.0 * distance / (root - slope) : (root + slope) / kSharpest;
      t += std::max(ahead, kLeastStep);
      value = field_.value(origin + direction * t, gradient);
    }
    if (value < 0.0) return close_in(origin, direction, before, t, value, gradient, hit);
  }
  return Outcome::kGrazing;
}

/// The crossing between a range above ground and one below it, where F has `value` and `gradient`.
GroundRays::Outcome GroundRays::close_in(Vec3d origin, Vec3d direction, double above, double below,
                                         double value, Vec3d gradient, GroundHit& hit) const {
  double t = below;
  for (int step = 0; step < 60; ++step) {
    (value > 0.0 ? above : below) = t;
    const double slope = dot(gradient, direction);
    const double steepness = std::max(norm(gradient), kFlattest);
    double next = slope < 0.0 ? t - value / slope : 0.5 * (above + below);
    const bool within = next >= above && next <= below;
    if (!within) next = 0.5 * (above + below);
    // Floats in the fields leave F uncertain by some 1e-7 m, hence the second condition.
    const double relative = slope / steepness;
    if ((within && std::abs(value) < kSettled * relative * relative * steepness) ||
        below - above < 1e-6) {
      hit.range_m = next;
      hit.point = origin + direction * next;
      hit.gradient = gradient;
      // At a touching point the normal can be a hair's breadth beyond square to the ray.
      return slope < 0.0 ? Outcome::kHit : Outcome::kGrazing;
    }
    t = next;
    value = field_.value(origin + direction * t, gradient);
  }
  return Outcome::kGrazing;
}

}  // namespace cornice::simulate
