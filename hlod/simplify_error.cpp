// SPDX-License-Identifier: GPL-3.0-or-later
#include "hlod/simplify_error.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace cornice::hlod {
namespace {

/// Vertices round which a nearer foot is looked for.
constexpr std::size_t kLookLimit = 24;
/// Coarse triangles looked at for a way from foot to foot.
constexpr std::size_t kSearchLimit = 64;
/// A foot that is farther off than this part of the way to the parent may not be the nearest.
constexpr float kFarFoot = 0.1f;

constexpr std::uint32_t kLaneBits = kDistanceLanes - 1;
constexpr std::array<std::size_t, 3> kNext{1, 2, 0};

float segment_distance(Vec3f p, Vec3f a, Vec3f b) {
  const Vec3f d = b - a;
  const float square = dot(d, d);
  const float s = square > 0 ? std::clamp(dot(p - a, d) / square, 0.0f, 1.0f) : 0.0f;
  return norm(p - (a + s * d));
}

bool has(const Triangle& t, std::uint32_t v) {
  return (int{t[0] == v} | int{t[1] == v} | int{t[2] == v}) != 0;
}

/// Which corner of its triangle a vertex is.
std::size_t corner_of(std::uint32_t v, const Triangle& t) { return (t[1] == v) + 2u * (t[2] == v); }

void put(std::array<Lanes, 3>& lanes, std::size_t lane, Vec3f v) {
  lanes[0][lane] = v.x, lanes[1][lane] = v.y, lanes[2][lane] = v.z;
}

/// Where the rest [at, end] of a fine edge comes nearest to the coarse edge p-q. Moves `at` there
/// and returns the distance. Ericson 2005, "Real-Time Collision Detection", 5.1.9.
float pass_over(Vec3f p, Vec3f q, Vec3f end, Vec3f& at) {
  const Vec3f u = end - at, v = q - p, w = at - p;
  const float uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), uw = dot(u, w), vw = dot(v, w);
  const float square = uu * vv - uv * uv;
  float s = square > 0 ? std::clamp((uv * vw - uw * vv) / square, 0.0f, 1.0f) : 0.0f;
  float t = vv > 0 ? (uv * s + vw) / vv : 0.0f;
  if (!(t >= 0 && t <= 1)) {
    t = t > 1 ? 1.0f : 0.0f;
    s = uu > 0 ? std::clamp((t * uv - uw) / uu, 0.0f, 1.0f) : 0.0f;
  }
  at = at + s * u;
  return norm(at - (p + t * v));
}

}  // namespace

void StepError::prepare(const SimplifyMesh& mesh, const Simplifier& simplifier,
                        std::span<const Vec3f> fine, std::span<const Triangle> original,
                        std::span<const std::uint8_t> shared) {
  mesh_ = &mesh;
  simplifier_ = &simplifier;
  fine_ = fine;
  original_ = original;
  const std::size_t count = mesh.positions.size();
  feet_.assign(count, kNone);
  own_.assign(count, 0);
  first_.assign(count, kNone);
  next_.resize(count);
  within_.resize(count);
  for (std::uint32_t v = 0; v < count; ++v) {
    within_[v] = simplifier.is_inside(v) && (shared.empty() || shared[v] == 0);
    const std::uint32_t parent = simplifier.parents()[v];
    if (parent != v) next_[v] = std::exchange(first_[parent], v);
  }
  for (std::uint32_t v = 0; v < count; ++v) {
    if (first_[v] != kNone) find_feet(v);
  }
}

void StepError::gather(std::uint32_t vertex, Fan& fan) const {
  const std::span<const std::uint32_t> triangles = simplifier_->fans().of(vertex);
  const std::vector<Vec3f>& positions = mesh_->positions;
  const Vec3f at = positions[vertex];
  fan.lanes.resize((triangles.size() + kDistanceLanes - 1) / kDistanceLanes);
  fan.triangles.resize(fan.lanes.size() * kDistanceLanes);
  for (std::size_t i = 0; i < fan.triangles.size(); ++i) {
    const std::uint32_t triangle = triangles[i < triangles.size() ? i : 0];
    const Triangle& t = mesh_->triangles[triangle];
    const std::size_t corner = corner_of(vertex, t);
    const std::size_t next = kNext[corner];
    FanLanes& lanes = fan.lanes[i / kDistanceLanes];
    put(lanes.next, i % kDistanceLanes, positions[t[next]] - at);
    put(lanes.prev, i % kDistanceLanes, positions[t[kNext[next]]] - at);
    fan.triangles[i] = triangle;
  }
  for (FanLanes& lanes : fan.lanes) measure_fan(lanes);
}

/// The point is relative to the vertex in the fan's middle.
StepError::Foot StepError::foot_in(const Fan& fan, Vec3f point) const {
  Foot foot{std::numeric_limits<float>::infinity(), kNone, false};
  for (std::size_t f = 0; f < fan.lanes.size(); ++f) {
    FanDistances distances;
    distances_to_fan(fan.lanes[f], point, distances);
    // Floats from 0 on are ordered as their bits are; with the lane in the lowest three the least
    // is found without guessing which it is. They are rounded up where they serve as distances.
    std::uint32_t least = kNone;
    for (std::uint32_t i = 0; i < kDistanceLanes; ++i) {
      const auto bits = std::bit_cast<std::uint32_t>(distances.square[i]);
      least = std::min(least, (bits & ~kLaneBits) | i);
    }
    const float square = std::bit_cast<float>(least | kLaneBits);
    if (!(square < foot.square)) continue;
    const std::size_t lane = least & kLaneBits;
    foot = {square, fan.triangles[f * kDistanceLanes + lane], distances.is_beyond[lane] != 0};
  }
  return foot;
}

/// Feet of all that became one vertex.
void StepError::find_feet(std::uint32_t parent) {
  gather(parent, fan_);
  const Vec3f at = mesh_->positions[parent];
  for (std::uint32_t v = first_[parent]; v != kNone; v = next_[v]) {
    const Vec3f way = fine_[v] - at;
    Foot foot = foot_in(fan_, way);
    if (foot.triangle == kNone) {
      own_[v] = norm(way);
      continue;
    }
    if (foot.is_beyond || foot.square > kFarFoot * kFarFoot * dot(way, way)) {
      look_round(v, parent, foot);
    }
    feet_[v] = foot.triangle;
    own_[v] = std::sqrt(foot.square);
    if (simplifier_->is_border(v)) own_[v] = std::max(own_[v], border_distance(v));
  }
}

/// Looks for a nearer foot round the foot's triangle, and on as long as there is one.
void StepError::look_round(std::uint32_t vertex, std::uint32_t parent, Foot& foot) {
  std::array<std::uint32_t, kLookLimit> seen{parent};
  std::size_t count = 1;
  for (bool is_nearer = true; is_nearer;) {
    is_nearer = false;
    const Triangle corners = mesh_->triangles[foot.triangle];
    for (const std::uint32_t corner : corners) {
      if (std::find(seen.begin(), seen.begin() + count, corner) != seen.begin() + count) continue;
      if (count == seen.size()) return;
      seen[count++] = corner;
      gather(corner, farther_);
      const Foot other = foot_in(farther_, fine_[vertex] - mesh_->positions[corner]);
      if (other.square < foot.square) foot = other, is_nearer = true;
    }
  }
}

/// The triangle on the other side of the edge (e, e + 1) of a triangle, or kNone.
std::uint32_t StepError::across(std::uint32_t triangle, std::size_t e) const {
  const Triangle& t = mesh_->triangles[triangle];
  const std::uint32_t to = t[kNext[e]];
  for (const std::uint32_t other : simplifier_->fans().of(t[e])) {
    if (other != triangle && has(mesh_->triangles[other], to)) return other;
  }
  return kNone;
}

/// From a vertex that was on the border to the border next to its parent: a concave border that is
/// cut short lies inside the coarse surface, but the coarse surface then lies outside of the fine.
float StepError::border_distance(std::uint32_t vertex) const {
  const std::uint32_t parent = simplifier_->parents()[vertex];
  float nearest = norm(fine_[vertex] - mesh_->positions[parent]);
  for (const std::uint32_t t : simplifier_->fans().of(parent)) {
    for (std::size_t e = 0; e < 3; ++e) {
      const Triangle& triangle = mesh_->triangles[t];
      if (across(t, e) != kNone) continue;
      nearest = std::min(nearest, segment_distance(fine_[vertex], mesh_->positions[triangle[e]],
                                                   mesh_->positions[triangle[kNext[e]]]));
    }
  }
  return nearest;
}

/// Edges of the fine surface with the coarse edges that they may pass over, one or two with a
/// common end.
class StepError::Crossings {
 public:
  Crossings(const StepError& step, float least) : error_(least), step_(step) {}

  void over(std::uint32_t a, std::uint32_t b, std::uint32_t p, std::uint32_t q) {
    add(a, b, p, q, once_);
    if (once_.count == kDistanceLanes) settle(once_);
  }
  void over(std::uint32_t a, std::uint32_t b, std::uint32_t p, std::uint32_t q, std::uint32_t r) {
    put(further_, twice_.count, step_.mesh_->positions[r]);
    add(a, b, p, q, twice_);
    if (twice_.count == kDistanceLanes) settle_twice();
  }
  void search(std::uint32_t a, std::uint32_t b) { error_ = std::max(error_, step_.search(a, b)); }
  float error() {
    settle(once_);
    settle_twice();
    return error_;
  }

 private:
  struct Batch {
    SegmentLanes segments{};
    Lanes distances{};
    std::array<std::array<std::uint32_t, 2>, kDistanceLanes> edges{};
    std::size_t count = 0;
  };

  void add(std::uint32_t a, std::uint32_t b, std::uint32_t p, std::uint32_t q, Batch& batch) {
    put(batch.segments.a, batch.count, step_.fine_[a]);
    put(batch.segments.b, batch.count, step_.fine_[b]);
    put(batch.segments.p, batch.count, step_.mesh_->positions[p]);
    put(batch.segments.q, batch.count, step_.mesh_->positions[q]);
    batch.edges[batch.count++] = {a, b};
  }
  void settle_twice() {
    pass_over_segments(twice_.segments, twice_.distances);
    const Lanes first = twice_.distances;
    twice_.segments.q = further_;
    pass_over_segments(twice_.segments, twice_.distances);
    for (std::size_t i = 0; i < twice_.count; ++i) {
      twice_.distances[i] = std::max(twice_.distances[i], first[i]);
    }
    settle_measured(twice_);
  }
  void settle(Batch& batch) {
    pass_over_segments(batch.segments, batch.distances);
    settle_measured(batch);
  }
  /// Another way is looked for where this one is the farthest of all.
  void settle_measured(Batch& batch) {
    for (std::size_t i = 0; i < batch.count; ++i) {
      const float distance = batch.distances[i];
      if (distance <= error_) continue;
      const float searched = step_.search(batch.edges[i][0], batch.edges[i][1]);
      error_ = std::max(error_, std::min(distance, searched));
    }
    batch.count = 0;
  }

  float error_;
  const StepError& step_;
  Batch once_, twice_;
  std::array<Lanes, 3> further_{};
};

/// Takes the edge from foot to foot over the coarse edge that the feet's triangles share, or by way
/// of one triangle between them.
void StepError::pass(std::uint32_t a, std::uint32_t b, Crossings& crossings) const {
  const std::vector<Triangle>& triangles = mesh_->triangles;
  if (feet_[b] == kNone) std::swap(a, b);
  if (feet_[a] == kNone) return pass_from_vertex(a, b, crossings);
  const Triangle &from = triangles[feet_[a]], &to = triangles[feet_[b]];
  std::uint32_t p = kNone, q = kNone;
  for (const std::uint32_t v : from) {
    const bool is_shared = has(to, v);
    q = is_shared ? p : q;
    p = is_shared ? v : p;
  }
  if (p == kNone) return crossings.search(a, b);
  if (q != kNone) return crossings.over(a, b, p, q);
  for (const std::uint32_t t : simplifier_->fans().of(p)) {
    const Triangle& triangle = triangles[t];
    const std::size_t corner = corner_of(p, triangle);
    const std::uint32_t next = triangle[kNext[corner]], prev = triangle[kNext[kNext[corner]]];
    if (has(from, next) && has(to, prev)) return crossings.over(a, b, p, next, prev);
    if (has(from, prev) && has(to, next)) return crossings.over(a, b, p, prev, next);
  }
  crossings.search(a, b);
}

/// The same from a vertex a that stays, over the third edge of one of its triangles.
void StepError::pass_from_vertex(std::uint32_t a, std::uint32_t b, Crossings& crossings) const {
  const std::vector<Triangle>& triangles = mesh_->triangles;
  const std::uint32_t to = feet_[b];
  for (const std::uint32_t t : simplifier_->fans().of(a)) {
    const Triangle& triangle = triangles[t];
    if (to == kNone) {
      if (has(triangle, b)) return;
      continue;
    }
    const std::size_t corner = corner_of(a, triangle);
    const std::uint32_t next = triangle[kNext[corner]], prev = triangle[kNext[kNext[corner]]];
    if (has(triangles[to], next) && has(triangles[to], prev)) {
      return crossings.over(a, b, next, prev);
    }
  }
  crossings.search(a, b);
}

/// Triangles that a fine edge may pass on its way.
struct StepError::Ways {
  struct Passed {
    std::uint32_t triangle, before;
    bool is_left;   ///< its neighbours are here, too
    float largest;  ///< distance at the edges on the way so far
    Vec3f at;       ///< how far the fine edge has come
  };
  std::array<Passed, kSearchLimit> passed;
  std::size_t count = 0;

  void add(const Passed& way) {
    for (std::size_t i = 0; i < count; ++i) {
      if (passed[i].triangle != way.triangle) continue;
      if (way.largest < passed[i].largest) passed[i] = way;
      return;
    }
    if (count < kSearchLimit) passed[count++] = way;
  }
  /// The way that went least far off, or null.
  Passed* next() {
    Passed* least = nullptr;
    for (std::size_t i = 0; i < count; ++i) {
      if (passed[i].is_left) continue;
      if (least == nullptr || passed[i].largest < least->largest) least = &passed[i];
    }
    return least;
  }
};

/// From the foot of a to the foot of b over the coarse edges that are nearest to the fine one.
float StepError::search(std::uint32_t a, std::uint32_t b) const {
  // From a foot there is one triangle to begin with.
  if (feet_[a] == kNone && feet_[b] != kNone) std::swap(a, b);
  const std::vector<Triangle>& triangles = mesh_->triangles;
  Ways ways;
  const auto cross_edge = [&](std::uint32_t triangle, std::size_t e, Vec3f at, float largest,
                              std::uint32_t before) {
    const Triangle& t = triangles[triangle];
    const std::uint32_t other = across(triangle, e);
    if (other == kNone || other == before) return;
    const float distance =
        pass_over(mesh_->positions[t[e]], mesh_->positions[t[kNext[e]]], fine_[b], at);
    ways.add({other, triangle, false, std::max(distance, largest), at});
  };
  if (feet_[a] != kNone) {
    ways.add({feet_[a], kNone, false, 0, fine_[a]});
  } else {
    // A vertex that stays is a corner of its triangles; the way leads over the third edge.
    for (const std::uint32_t t : simplifier_->fans().of(a)) {
      const std::size_t corner = (triangles[t][1] == a) + 2u * (triangles[t][2] == a);
      cross_edge(t, kNext[corner], fine_[a], 0, kNone);
    }
  }
  while (Ways::Passed* const way = ways.next()) {
    way->is_left = true;
    const Ways::Passed from = *way;
    const std::uint32_t t = from.triangle;
    if (feet_[b] != kNone ? t == feet_[b] : has(triangles[t], b)) return from.largest;
    for (std::size_t e = 0; e < 3; ++e) {
      cross_edge(t, e, from.at, from.largest, from.before);
    }
  }
  // No way there: what is certain is that distances grow no faster than the way along the edge.
  return std::max(own_[a], own_[b]) + norm(fine_[b] - fine_[a]);
}

/// Whether a fine edge may have to pass over coarse edges: not where both its feet are on one
/// triangle, and not where it is met again from its other side. Without branches, for which it is
/// cannot be foretold.
[[gnu::always_inline]] inline bool StepError::may_pass(std::uint32_t a, std::uint32_t b) const {
  const std::uint32_t from = feet_[a], to = feet_[b];
  const bool stays = from == kNone, ends = to == kNone;
  // Of a vertex that stays and a foot; any triangle will do for two vertices or two feet.
  const std::uint32_t other = stays ? to : from;
  const Triangle& t = mesh_->triangles[other == kNone ? 0 : other];
  const bool is_corner = (stays != ends) & has(t, stays ? a : b);
  const bool is_within = (within_[a] | within_[b]) != 0;
  // An edge between two vertices that stay does, too, where the surface is a manifold.
  const bool is_again = (a > b) & is_within;
  return ((from != to) | (stays & !is_within)) & !(is_again | is_corner);
}

float StepError::of(std::size_t begin, std::size_t end, float least) {
  passing_.resize(std::max(passing_.size(), 3 * (end - begin)));
  std::size_t count = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const Triangle& t = original_[i];
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t a = t[e], b = t[kNext[e]];
      least = std::max(least, own_[a]);
      passing_[count] = {std::min(a, b), std::max(a, b)};
      count += may_pass(a, b);
    }
  }
  Crossings crossings(*this, least);
  for (std::size_t i = 0; i < count; ++i) pass(passing_[i][0], passing_[i][1], crossings);
  return crossings.error();
}

}  // namespace cornice::hlod
