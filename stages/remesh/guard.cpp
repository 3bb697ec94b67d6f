// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/guard.h"

#include <algorithm>
#include <cmath>

namespace cornice::remesh {
namespace {

/// New triangles are looked at in a lattice of at most so many steps a side.
constexpr int kMostSteps = 64;
/// Cosine between a new triangle's normal and the mean one from which on a change is looked at.
constexpr float kBentCosine = 0.9f;
/// Twice the area over the longest side's square, below which a triangle counts as having none:
/// positions are floats, and a tile's height of 1e3 m leaves
/// 6e-5 m of them.
constexpr float kNoShape = 1e-3f;

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
  facets_.push_back({centre, b, c, cross(ac, n) / nn, cross(n, ab) / nn, n / std::sqrt(nn)});
}

bool Guard::carry_over(Moved& moved, float most_sq) const {
  float best = std::numeric_limits<float>::infinity();
  for (std::uint32_t f = 0; f < facets_.size(); ++f) {
    const Facet& facet = facets_[f];
    const Vec3f d = moved.at - facet.a;
    const float u = dot(d, facet.to_u), v = dot(d, facet.to_v);
    if (u < 0.0f || v < 0.0f || u + v > 1.0f) continue;
    const float height = dot(d, facet.normal);
    if (height * height < best) best = height * height, moved.facet = f;
  }
  if (best > most_sq) {
    // Nearest to a side or a corner.
    for (std::uint32_t f = 0; f < facets_.size(); ++f) {
      const Facet& facet = facets_[f];
      const float d = nearest_on_triangle(moved.at, facet.a, facet.b, facet.c).distance_sq;
      if (d < best) best = d, moved.facet = f;
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

std::uint32_t Guard::start_near(Vec3f p, std::uint32_t facet, std::uint32_t from) const {
  float best = std::numeric_limits<float>::infinity();
  std::uint32_t nearest = kEnd;
  for (const Moved& m : moved_) {
    if (m.facet != facet) continue;
    const Vec3f d = m.at - p;
    if (dot(d, d) < best) best = dot(d, d), nearest = m.id;
  }
  return nearest == kEnd ? from : input_->triangle_at(nearest);
}

bool Guard::stays_near_input(std::uint32_t from) const {
  const float most_sq = limits_.error_m * limits_.error_m;
  for (std::uint32_t f = 0; f < facets_.size(); ++f) {
    const Facet& facet = facets_[f];
    const Vec3f ab = facet.b - facet.a, ac = facet.c - facet.a;
    const float longest = std::sqrt(std::max({dot(ab, ab), dot(ac, ac), dot(ac - ab, ac - ab)}));
    if (longest <= limits_.small_m) continue;
    const int n =
        std::clamp(static_cast<int>(std::ceil(longest / limits_.spacing_m)), 2, kMostSteps);
    const float step = 1.0f / static_cast<float>(n);
    const auto near = [&](float u, float v) {
      const Vec3f p = facet.a + ab * u + ac * v;
      return input_->is_near(p, start_near(p, f, from), most_sq);
    };
    // Neither the side that stays nor the one that the next triangle looks at.
    for (int i = 1; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        if (!near(static_cast<float>(i) * step, static_cast<float>(j) * step)) return false;
      }
    }
    if (n == 2 && !near(1.0f / 3.0f, 1.0f / 3.0f)) return false;
  }
  return true;
}

bool Guard::is_doubtful() const {
  if (limits_.doubt_m < 0.0f) return true;
  const float most_sq = limits_.doubt_m * limits_.doubt_m;
  for (const Moved& m : moved_) {
    if (m.distance_sq > most_sq) return true;
  }
  Vec3f sum{};
  for (const Facet& f : facets_) sum += f.normal;
  for (const Facet& f : facets_) {
    if (dot(f.normal, sum) < kBentCosine * norm(sum)) return true;
  }
  return false;
}

bool Guard::fits(std::uint32_t from) {
  if (flat_ || !carry_over(limits_.error_m * limits_.error_m)) return false;
  return !is_doubtful() || stays_near_input(from);
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
