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
/// Flatter rays are followed step by step.
constexpr double kFlat = -0.1;
/// With two samples at distances a and b the interpolated range is off, across the ground, by about
/// (a b)^2 / slope^6: this product of them over slope^3 leaves less than 1e-6 m.
constexpr double kSettledProduct = 2.5e-4;
constexpr int kMostRounds = 5;
/// Where the ground is expected under the mesh, in shells: the mesh stands off it by one where it
/// is level and by more where it curves.
constexpr double kStandOff = 1.4;

/// F on a ray.
struct Sample {
  double t, value, slope;
  Vec3d gradient;
};

/// The root near the second sample by the cubic through both (inverse Hermite interpolation), and
/// the gradient there by the line through both.
void settle_between(const Sample& first, const Sample& second, GroundHit& hit) {
  const double span = first.value - second.value;
  if (span == 0.0) {
    hit.range_m = second.t;
    hit.gradient = second.gradient;
    return;
  }
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

/// Squares of 16 m; what stands in one reaches `margin_m` further.
constexpr double kHeightsStepM = 16.0;

HeightBounds heights_of(const Surface& surface, const Box2d& area, double margin_m) {
  HeightBounds heights{area, kHeightsStepM, 0, 0, {}};
  heights.columns = static_cast<int>(std::ceil(area.width() / kHeightsStepM));
  heights.rows = static_cast<int>(std::ceil(area.height() / kHeightsStepM));
  heights.ranges.resize(static_cast<std::size_t>(heights.columns) *
                        static_cast<std::size_t>(heights.rows));
  const auto margin = static_cast<float>(margin_m);
  for (const Vec3f& p : surface.positions)
    heights.add((surface.origin + p.cast<double>()), margin_m, p.z - margin, p.z + margin);
  return heights;
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
  heights_ = heights_of(surface, area, 4.0 * mesh_step_m);
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
  return follow_from({origin, direction, far_m}, t, end, t == 0.0 && starts_in_shell(origin), hit);
}

/// From range t, which is on the guiding mesh (or within it) or before it.
bool GroundRays::follow_from(const GroundRay& ray, double t, double end, bool is_on_mesh,
                             GroundHit& hit) const {
  for (int shell = 0; shell < kMostShells; ++shell) {
    if (!is_on_mesh) {
      RayMesh::Hit guide{};
      const Vec3d start = ray.origin + ray.direction * t - origin_;
      if (!mesh_->cast(start.cast<float>(), ray.direction.cast<float>(),
                       static_cast<float>(end - t), guide)) {
        return false;
      }
      t += static_cast<double>(guide.range);
    }
    is_on_mesh = false;
    switch (follow(ray.origin, ray.direction, t, hit)) {
      case Outcome::kHit:
        return hit.range_m <= ray.far_m;
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

/// What is known of one ray of a packet.
struct GroundRays::Lead {
  enum class State : std::uint8_t { kMisses, kBeforeMesh, kOnMesh, kSettled };
  State state = State::kMisses;
  bool starts_in_shell = false;
  double begin = 0.0;  ///< range where it enters the bounds
  double end = 0.0;
  double on_mesh = 0.0;
  double guess = 0.0;  ///< range where the ground is expected
};

void GroundRays::cast(std::span<const GroundRay> rays, std::span<GroundHit> hits,
                      std::span<std::uint8_t> met) const {
  using State = Lead::State;
  std::array<Lead, kPacket> leads;
  std::array<RayMesh::PacketRay, kPacket> packet;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const GroundRay& ray = rays[i];
    Lead& lead = leads[i];
    const Vec3d sum = ray.origin + ray.direction;
    lead.end = ray.far_m;
    if (!std::isfinite(sum.x + sum.y + sum.z) ||
        !clip_to_box(bounds_, ray.origin, ray.direction, lead.begin, lead.end)) {
      continue;
    }
    lead.starts_in_shell = lead.begin == 0.0 && starts_in_shell(ray.origin);
    lead.state = State::kBeforeMesh;
    if (lead.starts_in_shell) continue;
    const Vec3d start = ray.origin + ray.direction * lead.begin - origin_;
    packet[i] = {start.cast<float>(), ray.direction.cast<float>(),
                 static_cast<float>(lead.end - lead.begin)};
  }
  std::array<RayMesh::PacketHit, kPacket> guides;
  mesh_->cast(packet, guides);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Lead& lead = leads[i];
    if (lead.state == State::kMisses || lead.starts_in_shell) continue;
    lead.state = State::kMisses;
    if (guides[i].range < 0.0f) continue;
    lead.state = State::kOnMesh;
    lead.on_mesh = lead.begin + static_cast<double>(guides[i].range);
    const Vec3d facet = guides[i].normal.cast<double>();
    const double slope = std::abs(dot(facet, rays[i].direction)) / norm(facet);
    lead.guess = lead.on_mesh + std::min(kSteepWithin, kStandOff * shell_m_ / slope);
  }
  settle_all(rays, leads, hits);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Lead& lead = leads[i];
    if (lead.state == State::kSettled) {
      met[i] = hits[i].range_m <= rays[i].far_m;
    } else if (lead.state == State::kMisses) {
      met[i] = 0;
    } else {
      const bool is_on_mesh = lead.state == State::kOnMesh || lead.starts_in_shell;
      met[i] = follow_from(rays[i], is_on_mesh && !lead.starts_in_shell ? lead.on_mesh : lead.begin,
                           lead.end, is_on_mesh, hits[i]);
    }
  }
}

/// The usual case, in step so that the processor works on several rays at once: from where the mesh
/// says that the ground is, Newton's method settles soon. Leaves the other rays as they are.
void GroundRays::settle_all(std::span<const GroundRay> rays, std::array<Lead, kPacket>& leads,
                            std::span<GroundHit> hits) const {
  std::array<Vec3d, kPacket> places, gradients;
  std::array<double, kPacket> values, ranges;
  std::array<Sample, kPacket> earlier;
  std::array<std::size_t, kPacket> pending;
  std::size_t count = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (leads[i].state != Lead::State::kOnMesh) continue;
    ranges[count] = leads[i].guess;
    pending[count++] = i;
  }
  for (int round = 0; round < kMostRounds && count > 0; ++round) {
    for (std::size_t n = 0; n < count; ++n)
      places[n] = rays[pending[n]].origin + rays[pending[n]].direction * ranges[n];
    field_.values(places.data(), count, values.data(), gradients.data());
    std::size_t kept = 0;
    for (std::size_t n = 0; n < count; ++n) {
      const std::size_t i = pending[n];
      const Sample now{ranges[n], values[n], dot(gradients[n], rays[i].direction), gradients[n]};
      const double steepness = std::max(norm(now.gradient), kFlattest);
      const double slope = now.slope / steepness, distance = now.value / steepness;
      if (slope > kFlat || std::abs(distance) > kSteepWithin) continue;
      const double product = round == 0 ? 1.0 : std::abs(earlier[n].value / steepness * distance);
      if (product < kSettledProduct * -slope * slope * slope) {
        settle_between(earlier[n], now, hits[i]);
        hits[i].point = rays[i].origin + rays[i].direction * hits[i].range_m;
        if (is_first(rays[i], leads[i].on_mesh, hits[i].range_m, slope))
          leads[i].state = Lead::State::kSettled;
        continue;
      }
      earlier[kept] = now;
      ranges[kept] = now.t - distance / slope;
      pending[kept++] = i;
    }
    count = kept;
  }
}

/// True where the ray meets no ground between `from` and its crossing at `to`, which it meets with
/// this slope: going back from there F rises first, and its curvature is bounded.
bool GroundRays::is_first(const GroundRay& ray, double from, double to, double slope) const {
  double reach = -2.0 * slope / kSharpest;
  for (int step = 0; step < kMostRounds; ++step) {
    if (to - reach <= from) return true;
    to -= 0.9 * reach;
    Vec3d gradient;
    const double value = field_.value(ray.origin + ray.direction * to, gradient);
    if (value <= 0.0) return false;
    const double steepness = std::max(norm(gradient), kFlattest);
    const double back = -dot(gradient, ray.direction) / steepness;
    reach = (back + std::sqrt(back * back + 2.0 * kSharpest * value / steepness)) / kSharpest;
  }
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
