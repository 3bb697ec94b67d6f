// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/change.h"

#include <algorithm>
#include <cmath>

namespace cornice::remesh {
namespace {

/// Square of the bound's share up to which a place counts as one that a triangle should reach.
constexpr float kAbout = 1.6f;

}  // namespace

float least_sine(Vec3f a, Vec3f b, Vec3f c) {
  const Vec3f ab = b - a, ac = c - a, bc = c - b;
  const float sides_sq[3] = {dot(ab, ab), dot(ac, ac), dot(bc, bc)};
  const float shortest_sq = std::max(*std::min_element(sides_sq, sides_sq + 3), 1e-12f);
  const float longer_sq = sides_sq[0] * sides_sq[1] * sides_sq[2] / shortest_sq;
  return longer_sq > 0.0f ? norm(cross(ab, ac)) / std::sqrt(longer_sq) : 0.0f;
}

bool Changer::may(const Change& change) const {
  using enum Change::Kind;
  const std::uint32_t at = change.at;
  switch (change.kind) {
    case kSplit:
      return mesh_.twin(at) != kNone && !mesh_.frozen(at) && patch_.may_cut_at(at, change.to);
    case kInsert:
      return !(mesh_.frozen(3 * at) && mesh_.frozen(3 * at + 1) && mesh_.frozen(3 * at + 2));
    case kFlip:
      return mesh_.may_flip(at);
    case kSwing:
      return !mesh_.fixed(mesh_.opposite(at)) && mesh_.may_flip(at);
    case kCollapse:
      return mesh_.may_collapse(at);
    case kMerge:
      return !mesh_.fixed(mesh_.end(at)) && mesh_.may_collapse(at);
    case kMove:
      return !mesh_.fixed(at);
  }
  return false;
}

void Changer::put(Vec3f a, Vec3f b, Vec3f c, std::uint32_t number) {
  facets_.push_back({a, b, c});
  fresh_.push_back(number);
}

/// The triangles round v, which comes to lie at `to`; those at the vertex `without` vanish.
void Changer::describe_ring(std::uint32_t v, std::uint32_t without, Vec3f to) {
  mesh_.each_out(v, [&](std::uint32_t out) {
    const std::uint32_t b = mesh_.end(out), c = mesh_.opposite(out);
    taken_.push_back(out / 3);
    if (b != without && c != without) put(to, mesh_.position(b), mesh_.position(c), out / 3);
    return true;
  });
}

void Changer::describe(const Change& change) {
  change_ = change;
  taken_.clear();
  facets_.clear();
  fresh_.clear();
  switch (change.kind) {
    case Change::Kind::kMove:
      return describe_ring(change.at, kNone, change.to);
    case Change::Kind::kInsert:
      return describe_insertion(change.at, change.to);
    case Change::Kind::kSplit:
      return describe_split(change.at, change.to);
    case Change::Kind::kFlip:
    case Change::Kind::kSwing:
      return describe_turn(change.at);
    case Change::Kind::kCollapse:
    case Change::Kind::kMerge:
      return describe_collapse(change.at);
  }
}

void Changer::describe_insertion(std::uint32_t t, Vec3f to) {
  const auto first = static_cast<std::uint32_t>(mesh_.triangle_count());
  taken_.push_back(t);
  for (std::uint32_t k = 0; k < 3; ++k) {
    const std::uint32_t h = 3 * t + k;
    put(to, mesh_.position(mesh_.start(h)), mesh_.position(mesh_.end(h)),
        k == 0 ? t : first + k - 1);
  }
}

/// In the order of PatchMesh::split().
void Changer::describe_split(std::uint32_t h, Vec3f to) {
  const std::uint32_t g = mesh_.twin(h);
  const Vec3f a = mesh_.position(mesh_.start(h)), b = mesh_.position(mesh_.end(h));
  const Vec3f c = mesh_.position(mesh_.opposite(h)), d = mesh_.position(mesh_.opposite(g));
  const auto first = static_cast<std::uint32_t>(mesh_.triangle_count());
  taken_.insert(taken_.end(), {h / 3, g / 3});
  put(to, c, a, h / 3);
  put(to, b, c, first);
  put(to, d, b, g / 3);
  put(to, a, d, first + 1);
}

/// An edge a-b with c and d beside it becomes c-d; of a swing, all triangles at c change.
void Changer::describe_turn(std::uint32_t h) {
  const std::uint32_t g = mesh_.twin(h), corner = mesh_.opposite(h);
  const Vec3f a = mesh_.position(mesh_.start(h)), b = mesh_.position(mesh_.end(h));
  const Vec3f d = mesh_.position(mesh_.opposite(g));
  if (change_.kind == Change::Kind::kFlip) {
    change_.to = mesh_.position(corner);
    change_.input_triangle = patch_.hint[corner];
    taken_.push_back(h / 3);
  } else {
    mesh_.each_out(corner, [&](std::uint32_t out) {
      taken_.push_back(out / 3);
      if (out / 3 == h / 3) return true;
      put(change_.to, mesh_.position(mesh_.end(out)), mesh_.position(mesh_.opposite(out)), out / 3);
      return true;
    });
  }
  taken_.push_back(g / 3);
  put(change_.to, a, d, h / 3);
  put(change_.to, d, b, g / 3);
}

void Changer::describe_collapse(std::uint32_t h) {
  const std::uint32_t start = mesh_.start(h), end = mesh_.end(h);
  if (change_.kind == Change::Kind::kCollapse) {
    change_.to = mesh_.position(end);
    change_.input_triangle = patch_.hint[end];
    return describe_ring(start, end, change_.to);
  }
  describe_ring(start, end, change_.to);
  mesh_.each_out(end, [&](std::uint32_t out) {
    const std::uint32_t b = mesh_.end(out), c = mesh_.opposite(out);
    if (b == start || c == start) return true;
    taken_.push_back(out / 3);
    put(change_.to, mesh_.position(b), mesh_.position(c), out / 3);
    return true;
  });
}

bool Changer::is_near_taken(Vec3f p) const {
  const float bound_sq = kAbout * limits_.guard.error_m * limits_.guard.error_m;
  return std::any_of(taken_.begin(), taken_.end(), [&](std::uint32_t t) {
    return nearest_on_triangle(p, mesh_.position(mesh_.start(3 * t)),
                               mesh_.position(mesh_.end(3 * t)),
                               mesh_.position(mesh_.opposite(3 * t)))
               .distance_sq <= bound_sq;
  });
}

void Changer::tell_guard() {
  patch_.guard.begin();
  for (const std::uint32_t t : taken_) patch_.guard.take(t);
  for (const auto& [a, b, c] : facets_) patch_.guard.put(a, b, c);
}

bool Changer::fits(const Vec3f* reach) {
  for (const auto& [a, b, c] : facets_) {
    const Vec3f normal = normalized(cross(b - a, c - a));
    const NearestPoint near =
        input_.walk((a + b + c) * (1.0f / 3.0f), change_.input_triangle, 0.0f);
    if (dot(normal, input_.tree().normal(near.triangle)) < limits_.least_facing) return false;
  }
  tell_guard();
  if (reach != nullptr) patch_.guard.reach(*reach);
  // What has been mended once stays so: or else one change undoes the other without end.
  for (const Vec3f p : places_) {
    if (is_near_taken(p)) patch_.guard.reach(p);
  }
  return patch_.guard.fits(change_.input_triangle);
}

bool Changer::fits_anyway() {
  tell_guard();
  return patch_.guard.fits_anyway();
}

void Changer::carry_out() {
  using enum Change::Kind;
  const std::uint32_t at = change_.at;
  const auto place = [&](std::uint32_t v) {
    mesh_.move(v, change_.to);
    patch_.hint[v] = change_.input_triangle;
  };
  switch (change_.kind) {
    case kSplit:
      patch_.cut(at, change_.to, change_.input_triangle);
      break;
    case kInsert: {
      float size = 0.0f;
      for (std::uint32_t h = 3 * at; h < 3 * at + 3; ++h) size += patch_.size[mesh_.start(h)] / 3;
      mesh_.insert(at, change_.to);
      patch_.size.push_back(size);
      patch_.hint.push_back(change_.input_triangle);
      break;
    }
    case kFlip:
      mesh_.flip(at);
      break;
    case kSwing: {
      const std::uint32_t corner = mesh_.opposite(at);
      mesh_.flip(at);
      place(corner);
      break;
    }
    case kCollapse:
      mesh_.collapse(at);
      break;
    case kMerge: {
      const std::uint32_t end = mesh_.end(at);
      mesh_.collapse(at);
      place(end);
      break;
    }
    case kMove:
      place(at);
      break;
  }
  patch_.guard.commit(fresh_);
  patch_.changed.resize(mesh_.triangle_count(), 1);
  for (const std::uint32_t t : fresh_) patch_.changed[t] = 1;
}

}  // namespace cornice::remesh
