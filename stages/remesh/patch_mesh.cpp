// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/remesh/patch_mesh.h"

#include <cassert>
#include <utility>

namespace cornice::remesh {

PatchMesh::PatchMesh(std::vector<Vec3f> positions, std::vector<Triangle> triangles,
                     std::vector<std::uint8_t> fixed)
    : positions_(std::move(positions)),
      fixed_(std::move(fixed)),
      out_(positions_.size(), kNone),
      twins_(match_half_edges(triangles, positions_.size(), 1)) {
  corners_.reserve(triangles.size() * 3);
  for (const Triangle& t : triangles) corners_.insert(corners_.end(), t.begin(), t.end());
  for (std::uint32_t& twin : twins_) {
    if (twin >= kNoTwin) twin = kNone;
  }
  for (std::uint32_t t = 0; t < triangles.size(); ++t) announce(t);
}

Vec3f PatchMesh::middle_of_neighbours(std::uint32_t v) const {
  Vec3f sum{};
  float count = 0.0f;
  each_neighbour(v, [&](std::uint32_t n) {
    sum += positions_[n];
    count += 1.0f;
    return true;
  });
  return sum / count;
}

std::uint32_t PatchMesh::add_vertex(Vec3f position) {
  positions_.push_back(position);
  fixed_.push_back(0);
  out_.push_back(kNone);
  return static_cast<std::uint32_t>(positions_.size()) - 1;
}

std::uint32_t PatchMesh::add_two_triangles() {
  const auto first = static_cast<std::uint32_t>(corners_.size() / 3);
  corners_.resize(corners_.size() + 6);
  twins_.resize(twins_.size() + 6, kNone);
  return first;
}

void PatchMesh::set_triangle(std::uint32_t t, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  corners_[3 * t] = a, corners_[3 * t + 1] = b, corners_[3 * t + 2] = c;
}

void PatchMesh::join(std::uint32_t h, std::uint32_t g) {
  if (h != kNone) twins_[h] = g;
  if (g != kNone) twins_[g] = h;
}

void PatchMesh::announce(std::uint32_t t) {
  for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
    std::uint32_t& out = out_[corners_[h]];
    const bool at_rim = out != kNone && corners_[out] == corners_[h] && twins_[out] == kNone;
    if (twins_[h] == kNone || !at_rim) out = h;
  }
}

//        c                  c
//      / | \              / | \        h: a to b, g: b to a
//     a--|--b     =>     a--m--b       triangle of h keeps a, triangle of g keeps b
//      \ | /              \ | /
//        d                  d
std::uint32_t PatchMesh::split(std::uint32_t h, Vec3f position) {
  const std::uint32_t g = twins_[h];
  assert(g != kNone);
  const std::uint32_t a = start(h), b = start(g), c = opposite(h), d = opposite(g);
  const std::uint32_t bc = twins_[next(h)], ca = twins_[previous(h)];
  const std::uint32_t ad = twins_[next(g)], db = twins_[previous(g)];
  const std::uint32_t m = add_vertex(position);
  const std::uint32_t t0 = h / 3, t1 = g / 3;
  const std::uint32_t t2 = add_two_triangles(), t3 = t2 + 1;
  set_triangle(t0, a, m, c);
  set_triangle(t2, m, b, c);
  set_triangle(t1, b, m, d);
  set_triangle(t3, m, a, d);
  join(3 * t0, 3 * t3);
  join(3 * t0 + 1, 3 * t2 + 2);
  join(3 * t0 + 2, ca);
  join(3 * t2, 3 * t1);
  join(3 * t2 + 1, bc);
  join(3 * t1 + 1, 3 * t3 + 2);
  join(3 * t1 + 2, db);
  join(3 * t3 + 1, ad);
  for (const std::uint32_t t : {t0, t1, t2, t3}) announce(t);
  return m;
}

//        c                  c
//      /   \              / | \        t = (a, b, m), t1 = (b, c, m), t2 = (c, a, m)
//     /     \     =>     / .m. \       .
//    a-------b          a-------b
std::uint32_t PatchMesh::insert(std::uint32_t t, Vec3f position) {
  const std::uint32_t a = corners_[3 * t], b = corners_[3 * t + 1], c = corners_[3 * t + 2];
  const std::uint32_t bc = twins_[3 * t + 1], ca = twins_[3 * t + 2];
  const std::uint32_t m = add_vertex(position);
  const std::uint32_t t1 = add_two_triangles(), t2 = t1 + 1;
  set_triangle(t, a, b, m);
  set_triangle(t1, b, c, m);
  set_triangle(t2, c, a, m);
  // A rim edge may change its place; its vertex must not go by the old one.
  for (const std::uint32_t v : {a, b, c}) {
    if (out_[v] / 3 == t) out_[v] = kNone;
  }
  twins_[3 * t1] = bc;
  twins_[3 * t2] = ca;
  join(bc, 3 * t1);
  join(ca, 3 * t2);
  join(3 * t + 1, 3 * t1 + 2);
  join(3 * t1 + 1, 3 * t2 + 2);
  join(3 * t2 + 1, 3 * t + 2);
  for (const std::uint32_t k : {t, t1, t2}) announce(k);
  return m;
}

bool PatchMesh::may_flip(std::uint32_t h) const {
  const std::uint32_t g = twins_[h];
  if (g == kNone || frozen(h)) return false;
  const std::uint32_t c = opposite(h), d = opposite(g);
  if (c == d || (fixed_[c] != 0 && fixed_[d] != 0) || adjacent(c, d)) return false;
  // A vertex that would be left with two neighbours.
  return (fixed_[start(h)] != 0 || valence(start(h)) > 3) &&
         (fixed_[end(h)] != 0 || valence(end(h)) > 3);
}

//        c                  c
//      /   \              / | \        h: a to b          t0 = (a, d, c)
//     a-----b     =>     a  |  b                          t1 = (d, b, c)
//      \   /              \ | /
//        d                  d
void PatchMesh::flip(std::uint32_t h) {
  const std::uint32_t g = twins_[h];
  const std::uint32_t a = start(h), b = start(g), c = opposite(h), d = opposite(g);
  const std::uint32_t bc = twins_[next(h)], ca = twins_[previous(h)];
  const std::uint32_t ad = twins_[next(g)], db = twins_[previous(g)];
  const std::uint32_t t0 = h / 3, t1 = g / 3;
  set_triangle(t0, a, d, c);
  set_triangle(t1, d, b, c);
  // A rim edge may change its place; its vertex must not go by the old one.
  for (const std::uint32_t v : {a, b, c, d}) {
    if (out_[v] / 3 == t0 || out_[v] / 3 == t1) out_[v] = kNone;
  }
  const auto set_twin = [&](std::uint32_t at, std::uint32_t other) {
    twins_[at] = other;
    if (other != kNone) twins_[other] = at;
  };
  set_twin(3 * t0, ad);
  set_twin(3 * t0 + 1, 3 * t1 + 2);
  set_twin(3 * t0 + 2, ca);
  set_twin(3 * t1, db);
  set_twin(3 * t1 + 1, bc);
  announce(t0);
  announce(t1);
}

bool PatchMesh::may_collapse(std::uint32_t h) const {
  const std::uint32_t g = twins_[h];
  const std::uint32_t a = start(h), b = end(h);
  if (g == kNone || fixed_[a] != 0) return false;
  const std::uint32_t c = opposite(h), d = opposite(g);
  if (c == d) return false;
  if ((fixed_[c] == 0 && valence(c) < 4) || (fixed_[d] == 0 && valence(d) < 4)) return false;
  return each_neighbour(a, [&](std::uint32_t n) {
    if (n == b || n == c || n == d) return true;
    // A third common neighbour, or a new edge between two that may have one elsewhere.
    return !(fixed_[n] != 0 && fixed_[b] != 0) && !adjacent(n, b);
  });
}

void PatchMesh::collapse(std::uint32_t h) {
  const std::uint32_t g = twins_[h];
  const std::uint32_t a = start(h), b = end(h), c = opposite(h), d = opposite(g);
  const std::uint32_t bc = twins_[next(h)], ca = twins_[previous(h)];
  const std::uint32_t ad = twins_[next(g)], db = twins_[previous(g)];
  std::uint32_t out = out_[a];
  const std::uint32_t first = out;
  do {
    corners_[out] = b;
    out = twins_[previous(out)];
  } while (out != first);
  const std::uint32_t dead[2] = {h / 3, g / 3};
  for (const std::uint32_t v : {b, c, d}) {
    if (out_[v] / 3 == dead[0] || out_[v] / 3 == dead[1]) out_[v] = kNone;
  }
  out_[a] = kNone;
  for (const std::uint32_t t : dead) {
    for (std::uint32_t k = 3 * t; k < 3 * t + 3; ++k) corners_[k] = twins_[k] = kNone;
  }
  join(bc, ca);
  join(ad, db);
  for (const std::uint32_t k : {bc, ca, ad, db}) {
    if (k != kNone) announce(k / 3);
  }
}

}  // namespace cornice::remesh
