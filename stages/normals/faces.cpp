// SPDX-License-Identifier: GPL-3.0-or-later
// All planes are tried, as they are few; so there is nothing random.
#include "stages/normals/faces.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/base/clones.h"

namespace cornice::normals {
namespace {

/// Rms distance from a plane, in metres and as a share of its breadth, above which it is more than
/// range noise on one face: 5 times the noise of airborne scanners, and a bend of 25 degrees.
constexpr float kMixedSpread_m = 0.15f;
constexpr float kMixedShare = 0.2f;

/// A neighbour is off a plane from this distance on: noise, and more the farther it lies from the
/// point, for rock is rough and bent.
constexpr float kOff_m = 0.08f;
constexpr float kOffPerMetre = 0.12f;

/// Distance from the point, as a share of the farthest neighbour's, that halves a neighbour's
/// weight.
constexpr float kHalfWeight = 0.4f;

/// Sine of the angle between two neighbours below which they make no plane with the point.
constexpr float kLeastSine = 0.3f;

/// Cosine up to which a beam may seem to come from behind a plane that it met: the plane's doubt.
constexpr float kGraze = 0.02f;

constexpr std::size_t kLeastOnFace = 4;

}  // namespace

bool may_mix_faces(const PlaneFit& plane) {
  return plane.spread_m > kMixedSpread_m && plane.spread_m > kMixedShare * plane.breadth_m;
}

void FaceFinder::collect(const NeighbourBlock& block, std::size_t lane, const Beams& beams) {
  near_.clear();
  float reach_m = 0.0f;
  for (std::size_t c = 0; c < block.sizes()[lane]; ++c) {
    const std::size_t at = c * kLanes + lane;
    Neighbour v;
    v.index = block.index()[at];
    v.offset = {block.dx()[at], block.dy()[at], block.dz()[at]};
    v.beam = beams.direction[v.index];
    v.length_m = std::sqrt(dot(v.offset, v.offset));
    const float limit_m = kOff_m + kOffPerMetre * v.length_m;
    v.per_limit_sq = 1.0f / (limit_m * limit_m);
    reach_m = std::max(reach_m, v.length_m);
    near_.push_back(v);
  }
  const float per_half = reach_m > 0.0f ? 1.0f / (kHalfWeight * reach_m) : 0.0f;
  for (Neighbour& v : near_) {
    const float far = per_half * v.length_m;
    v.weight = 1.0f / (1.0f + far * far);
  }
  std::sort(near_.begin(), near_.end(), [](const Neighbour& a, const Neighbour& b) {
    return std::tie(a.length_m, a.index) < std::tie(b.length_m, b.index);
  });
}

FaceFinder::Planes FaceFinder::planes_through(const Neighbour& a) const {
  Planes planes{};
  for (std::size_t l = 0; l < std::min(kLanes, near_.size()); ++l) {
    const Neighbour& b = near_[l];
    const Vec3f n = cross(a.offset, b.offset);
    const float length = std::sqrt(dot(n, n));
    if (length <= kLeastSine * a.length_m * b.length_m) continue;
    planes.x[l] = n.x / length, planes.y[l] = n.y / length, planes.z[l] = n.z / length;
    planes.valid[l] = 1.0f;
  }
  return planes;
}

CORNICE_CLONES
std::array<float, kLanes> FaceFinder::support(const Planes& planes, Vec3f own_beam) const {
  // Met from the side that the normal points to, and from the other.
  std::array<float, kLanes> front{}, back{}, best;
  for (const Neighbour& v : near_) {
    for (std::size_t l = 0; l < kLanes; ++l) {
      const float off =
          planes.x[l] * v.offset.x + planes.y[l] * v.offset.y + planes.z[l] * v.offset.z;
      const float cosine = planes.x[l] * v.beam.x + planes.y[l] * v.beam.y + planes.z[l] * v.beam.z;
      const float on = v.weight * std::max(1.0f - off * off * v.per_limit_sq, 0.0f);
      front[l] += cosine < kGraze ? on : 0.0f;
      back[l] += cosine > -kGraze ? on : 0.0f;
    }
  }
  for (std::size_t l = 0; l < kLanes; ++l) {
    const float cosine =
        planes.x[l] * own_beam.x + planes.y[l] * own_beam.y + planes.z[l] * own_beam.z;
    const float from_front = cosine < kGraze ? front[l] : 0.0f;
    const float from_back = cosine > -kGraze ? back[l] : 0.0f;
    // The sign says the side.
    best[l] = planes.valid[l] * (from_back > from_front ? -from_back : from_front);
  }
  return best;
}

Vec3f FaceFinder::best_plane(Vec3f own_beam) const {
  Vec3f best;
  float most = 0.0f;
  for (std::size_t a = 0; a < std::min(kLanes, near_.size()); ++a) {
    const Planes planes = planes_through(near_[a]);
    const std::array<float, kLanes> supports = support(planes, own_beam);
    for (std::size_t l = 0; l < a; ++l) {
      if (std::abs(supports[l]) <= most) continue;
      most = std::abs(supports[l]);
      best = Vec3f{planes.x[l], planes.y[l], planes.z[l]} * (supports[l] < 0.0f ? -1.0f : 1.0f);
    }
  }
  return best;
}

void FaceFinder::add_face(const NeighbourBlock& block, std::size_t lane, const Beams& beams,
                          NeighbourBlock& faces) {
  collect(block, lane, beams);
  const Vec3f normal = best_plane(beams.direction[block.point(lane)]);
  const auto is_off = [&](const Neighbour& v) {
    const float off = dot(normal, v.offset);
    return off * off * v.per_limit_sq >= 1.0f || dot(normal, v.beam) >= kGraze;
  };
  const auto on_face = static_cast<std::size_t>(
      std::count_if(near_.begin(), near_.end(), [&](const Neighbour& v) { return !is_off(v); }));
  const bool take_all = on_face < kLeastOnFace;
  faces.open_lane(block.point(lane), static_cast<std::uint32_t>(take_all ? near_.size() : on_face));
  std::size_t at = faces.place();
  for (const Neighbour& v : near_) {
    if (!take_all && is_off(v)) continue;
    faces.set(at, v.index, v.offset.x, v.offset.y, v.offset.z);
    at += kLanes;
  }
}

}  // namespace cornice::normals
