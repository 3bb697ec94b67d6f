// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/guard.h"

#include <algorithm>
#include <cmath>

namespace cornice::remesh {
namespace {

/// New triangles are looked at in a lattice of at most so many steps a side.
constexpr int kMostSteps = 64;
/// Twice the area over the longest side's square, below which a triangle counts as having none:
/// positions are floats, and a tile's height of 1e3 m leaves
/// 6e-5 m of them.
constexpr float kNoShape = 1e-3f;
/// Of the bound's square: what hangs that near a triangle stays there, others may be nearer still.
constexpr float kClearShare = 0.25f;

}  // namespace

void Guard::add(std::uint32_t triangle, std::uint32_t input_vertex, float distance_sq) {
  const auto s = static_cast<std::uint32_t>(id_.size());
  id_.push_back(input_vertex);
  distance_sq_.push_back(distance_sq);
  next_.push_back(head_[triangle]);
  head_[triangle] = s;
}

void Guard::renumber(std::uint32_t from, std::uint32_t to) {
  if (from == to) return;
  head_[to] = head_[from];
  head_[from] = kEnd;
}

void Guard::begin() {
  old_.clear();
  left_.clear();
  facets_.clear();
  moved_.clear();
  places_.clear();
  flat_ = false;
}

void Guard::take_vertex(std::uint32_t input_vertex) { left_.push_back(input_vertex); }

void Guard::put(Vec3f centre, Vec3f b, Vec3f c) {
  const Vec3f ab = b - centre, ac = c - centre, bc = c - b;
  const Vec3f n = cross(ab, ac);
  const float nn = dot(n, n);
  const float longest_sq = std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)});
  if (!(nn > kNoShape * kNoShape * longest_sq * longest_sq)) {
    flat_ = true;
    return;
  }
  const float per_nn = 1.0f / nn;
  facets_.push_back(
      {centre, b, c, cross(ac, n) * per_nn, cross(n, ab) * per_nn, n * std::sqrt(per_nn)});
}

/// The squared distance of a place beside the facet, or `best` where it is farther than that.
float Guard::Facet::distance_beside_sq(Vec3f p, float best) const {
  const Vec3f ap = p - a, ab = b - a, ac = c - a;
  const float height = dot(ap, normal);
  if (height * height >= best) return best;
  const auto side = [&](Vec3f d, Vec3f along) {
    const float t = std::clamp(dot(d, along) / dot(along, along), 0.0f, 1.0f);
    const Vec3f rest = d - along * t;
    best = std::min(best, dot(rest, rest));
  };
  side(ap, ab);
  side(ap, ac);
  side(ap - ab, ac - ab);
  return best;
}

bool Guard::carry_over(Moved& moved, float most_sq) const {
  const float clear_sq = kClearShare * most_sq;
  float best = std::numeric_limits<float>::infinity();
  for (std::uint32_t f = 0; f < facets_.size(); ++f) {
    const Facet& facet = facets_[f];
    const Vec3f d = moved.at - facet.a;
    const float u = dot(d, facet.to_u), v = dot(d, facet.to_v);
    if (u < 0.0f || v < 0.0f || u + v > 1.0f) continue;
    const float height = dot(d, facet.normal);
    if (height * height >= best) continue;
    best = height * height, moved.facet = f;
    if (best <= clear_sq) break;
  }
  if (best > most_sq) {
    for (std::uint32_t f = 0; f < facets_.size(); ++f) {
      const float beside = facets_[f].distance_beside_sq(moved.at, best);
      if (beside < best) best = beside, moved.facet = f;
    }
  }
  moved.distance_sq = best;
  return best <= most_sq;
}

bool Guard::carry_over(float most_sq) {
  for (const std::uint32_t t : old_) {
    for (std::uint32_t s = head_[t]; s != kEnd; s = next_[s]) {
      Moved moved{s, id_[s], 0, 0.0f, input_->positions()[id_[s]]};
      if (!carry_over(moved, most_sq)) return false;
      moved_.push_back(moved);
    }
  }
  for (const std::uint32_t id : left_) {
    Moved moved{kEnd, id, 0, 0.0f, input_->positions()[id]};
    if (!carry_over(moved, most_sq)) return false;
    moved_.push_back(moved);
  }
  for (const Vec3f place : places_) {
    Moved moved{kEnd, 0, 0, 0.0f, place};
    if (!carry_over(moved, most_sq)) return false;
  }
  return true;
}

/// Where the input is not folded, new triangles are farthest from it where their new sides cross
/// its own, or at what they carry: a look along the sides is enough.
bool Guard::spokes_stay_near_input(std::uint32_t from) const {
  const float most_sq = limits_.error_m * limits_.error_m;
  return std::all_of(facets_.begin(), facets_.end(), [&](const Facet& facet) {
    const Vec3f ab = facet.b - facet.a;
    const float length = norm(ab);
    if (length <= limits_.small_m) return true;
    const int n =
        std::clamp(static_cast<int>(std::ceil(length / limits_.spacing_m)), 2, kMostSteps);
    std::uint32_t at = from;
    for (int i = 1; i < n; ++i) {
      const float share = static_cast<float>(i) / static_cast<float>(n);
      if (!input_->is_near(facet.a + ab * share, at, most_sq)) return false;
    }
    return true;
  });
}

bool Guard::stays_near_input(std::uint32_t from) const {
  const float most_sq = limits_.error_m * limits_.error_m;
  for (const Facet& facet : facets_) {
    const Vec3f ab = facet.b - facet.a, ac = facet.c - facet.a;
    const float longest = std::sqrt(std::max({dot(ab, ab), dot(ac, ac), dot(ac - ab, ac - ab)}));
    if (longest <= limits_.small_m) continue;
    const int n =
        std::clamp(static_cast<int>(std::ceil(longest / limits_.spacing_m)), 2, kMostSteps);
    const float step = 1.0f / static_cast<float>(n);
    std::uint32_t row = from, at = from;
    const auto near = [&](float u, float v) {
      return input_->is_near(facet.a + ab * u + ac * v, at, most_sq);
    };
    // Neither the side that stays nor the one that the next triangle looks at.
    for (int i = 1; i < n; ++i) {
      at = row;
      for (int j = 0; i + j < n; ++j) {
        if (!near(static_cast<float>(i) * step, static_cast<float>(j) * step)) return false;
        if (j == 0) row = at;
      }
    }
    if (n == 2 && !near(1.0f / 3.0f, 1.0f / 3.0f)) return false;
  }
  return true;
}

/// Whether something carried is so far that a look at the new triangles is worth while.
bool Guard::is_close() const {
  const float most_sq = limits_.doubt_m * limits_.doubt_m;
  return limits_.doubt_m == 0.0f || std::any_of(moved_.begin(), moved_.end(), [&](const Moved& m) {
           return m.distance_sq > most_sq;
         });
}

bool Guard::fits(std::uint32_t from) {
  if (flat_ || !carry_over(limits_.error_m * limits_.error_m)) return false;
  if (limits_.inside) return stays_near_input(from);
  return !is_close() || spokes_stay_near_input(from);
}

bool Guard::fits_anyway() {
  moved_.clear();
  return !flat_ && carry_over(std::numeric_limits<float>::max());
}

void Guard::commit(const std::vector<std::uint32_t>& fresh) {
  for (const std::uint32_t t : old_) head_[t] = kEnd;
  for (const std::uint32_t t : fresh) {
    if (t >= head_.size()) resize(t + 1);
  }
  for (const Moved& m : moved_) {
    const std::uint32_t t = fresh[m.facet];
    if (m.sample == kEnd) {
      add(t, m.id, m.distance_sq);
      continue;
    }
    distance_sq_[m.sample] = m.distance_sq;
    next_[m.sample] = head_[t];
    head_[t] = m.sample;
  }
}

}  // namespace cornice::remesh
