// SPDX-License-Identifier: GPL-3.0-or-later
// Ways over the coarse surface from foot to foot, looked for where none is at hand.
#include <algorithm>
#include <array>
#include <limits>

#include "hlod/simplify_error.h"

namespace cornice::hlod {
namespace {

/// Coarse triangles looked at for a way from foot to foot.
constexpr std::size_t kSearchLimit = 64;
constexpr std::array<std::size_t, 3> kNext{1, 2, 0};

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

/// Triangles that a fine edge may pass on its way.
struct StepError::Ways {
  struct Passed {
    Triangle triangle, before;  ///< corners in the order of their names
    bool is_left;               ///< its neighbours are here, too
    float largest;              ///< distance at the edges on the way so far
    Vec3f at;                   ///< how far the fine edge has come
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

/// The third corner of the triangle on the other side of the edge (e, e + 1) of a triangle, or
/// kNone.
std::uint32_t StepError::across(const Triangle& triangle, std::size_t e) const {
  const std::uint32_t end = triangle[kNext[e]], own = triangle[kNext[kNext[e]]];
  std::uint32_t other = kNone;
  simplifier_->links().for_each_arc(triangle[e], [&](std::uint32_t from, std::uint32_t to) {
    const std::uint32_t third = from == end ? to : to == end ? from : own;
    other = other == kNone && third != own ? third : other;
  });
  return other;
}

/// From the foot of a, round a vertex that its triangle or a neighbour of it has, to the triangle
/// of the foot of b, the shorter way; infinite where there is none.
float StepError::go_round(std::uint32_t a, std::uint32_t b, std::uint32_t middle) const {
  constexpr float kNoWay = std::numeric_limits<float>::infinity();
  const Link& link = simplifier_->links().of(middle);
  if (link.is_loose() || !link.is_closed()) return kNoWay;
  const Foot &from = feet_[a], &to = feet_[b];
  const std::uint32_t count = link.count();
  // Triangle i lies between the coarse edges i and i + 1 round the middle; a vertex on one of them.
  std::uint32_t start = kNone, goal = kNone;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t edge = link.at[i], next = link.at[i + 1 == count ? 0 : i + 1];
    const bool starts = from.is_point() ? edge == from.corners[0] : from.has(edge) & from.has(next);
    start = starts ? i : start;
    goal = to.has(edge) & to.has(next) ? i : goal;
  }
  if (start == kNone || goal == kNone) return kNoWay;
  const std::uint32_t on = (goal + count - start) % count;
  const std::uint32_t back = (start + count - goal) % count - from.is_point();
  Vec3f at = fine(a);
  float largest = 0;
  for (std::uint32_t k = 0; k < std::min(on, back); ++k) {
    const std::uint32_t place = on <= back ? start + 1 + k : start + count - from.is_point() - k;
    largest =
        std::max(largest, pass_over(coarse(middle), coarse(link.at[place % count]), fine(b), at));
  }
  return largest;
}

/// From the foot of a to the foot of b over the coarse edges that are nearest to the fine one.
float StepError::search(std::uint32_t a, std::uint32_t b) const {
  // From a foot on a triangle there is one triangle to begin with.
  if (feet_[a].is_point() && !feet_[b].is_point()) std::swap(a, b);
  const Foot &from = feet_[a], &to = feet_[b];
  const auto sorted = [](Triangle t) {
    std::sort(t.begin(), t.end());
    return t;
  };
  Ways ways;
  const auto cross_edge = [&](const Triangle& t, std::size_t e, const Ways::Passed& way) {
    const std::uint32_t third = across(t, e);
    if (third == kNone) return;
    const Triangle other = sorted({t[e], t[kNext[e]], third});
    if (other == way.before) return;
    Vec3f at = way.at;
    const float distance = pass_over(coarse(t[e]), coarse(t[kNext[e]]), fine(b), at);
    ways.add({other, way.triangle, false, std::max(distance, way.largest), at});
  };
  if (!from.is_point()) {
    ways.add({sorted(from.corners), {}, false, 0, fine(a)});
  } else {
    // A vertex that stays is a corner of its triangles; the way leads over the third edge.
    const std::uint32_t at = from.corners[0];
    simplifier_->links().for_each_arc(at, [&](std::uint32_t next, std::uint32_t prev) {
      cross_edge({at, next, prev}, 1, {sorted({at, next, prev}), {}, false, 0, fine(a)});
    });
  }
  const Triangle goal = sorted(to.corners);
  while (Ways::Passed* const way = ways.next()) {
    way->is_left = true;
    const Ways::Passed passed = *way;
    const Triangle& t = passed.triangle;
    if (to.is_point() ? std::count(t.begin(), t.end(), goal[0]) != 0 : t == goal) {
      return passed.largest;
    }
    for (std::size_t e = 0; e < 3; ++e) cross_edge(t, e, passed);
  }
  // No way there: what is certain is that distances grow no faster than the way along the edge.
  return std::max(from.distance, to.distance) + norm(fine(b) - fine(a));
}

}  // namespace cornice::hlod
