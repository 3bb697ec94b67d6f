// SPDX-License-Identifier: GPL-3.0-or-later
// Edge flips after Lawson 1977, "Software for C1 surface interpolation", on a surface in space.
#include "stages/stitch/mend.h"

#include <algorithm>
#include <map>
#include <set>

#include "core/mesh/quality.h"
#include "core/mesh/topology.h"

namespace cornice::stitch {
namespace {

/// Triangles with a smaller angle are mended. Those of the remesher have 20 degrees and more.
constexpr double kThinDeg = 15.0;
/// Triangles of a flip must not be bent more than this: cosine.
constexpr double kFlat = 0.85;
constexpr int kMostPasses = 10;

/// The triangles near a set of vertices, and where their edges are.
class Neighbourhood {
 public:
  Neighbourhood(Mesh& mesh, const std::vector<std::uint32_t>& rows) : mesh_(mesh) {
    std::vector<std::uint8_t> chosen(mesh.positions.size(), 0);
    for (const std::uint32_t row : rows) chosen[row] = 1;
    // Two rings: the triangles of the vertices, then those of the vertices that these have.
    std::vector<std::uint8_t> ring = chosen;
    for (const Triangle& t : mesh.triangles) {
      if (chosen[t[0]] + chosen[t[1]] + chosen[t[2]] == 0) continue;
      for (const std::uint32_t v : t) ring[v] = 1;
    }
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const Triangle& c = mesh.triangles[t];
      if (ring[c[0]] + ring[c[1]] + ring[c[2]] < 2) continue;
      local_.push_back(t);
      add_edges(t);
    }
  }

  const std::vector<std::uint32_t>& triangles() const { return local_; }

  double smallest_angle(const Triangle& t) const {
    return smallest_angle_deg(at(t[0]), at(t[1]), at(t[2]));
  }

  /// Flips edge k of triangle t where that makes things better.
  bool flip(std::uint32_t t, std::uint32_t k) {
    const Triangle one = mesh_.triangles[t];
    const std::uint32_t a = one[k], b = one[(k + 1) % 3], c = one[(k + 2) % 3];
    const auto found = edges_.find({b, a});
    if (found == edges_.end() || found->second == kShared || edges_.at({a, b}) == kShared) {
      return false;
    }
    const std::uint32_t other = found->second;
    const Triangle two = mesh_.triangles[other];
    std::uint32_t d = two[0];
    for (const std::uint32_t v : two) {
      if (v != a && v != b) d = v;
    }
    // Triangles outside the neighbourhood that have both c and d have an edge inside it, too: every
    // neighbour of a ring vertex is in it.
    if (c == d || edges_.contains({c, d}) || edges_.contains({d, c})) return false;
    const Triangle new_one{a, d, c}, new_two{d, b, c};
    if (std::min(smallest_angle(new_one), smallest_angle(new_two)) <=
        1.05 * std::min(smallest_angle(one), smallest_angle(two)) + 0.01) {
      return false;
    }
    if (!keeps_the_surface(one, two, new_one, new_two)) return false;
    drop_edges(one);
    drop_edges(two);
    mesh_.triangles[t] = new_one;
    mesh_.triangles[other] = new_two;
    add_edges(t);
    add_edges(other);
    return true;
  }

 private:
  static constexpr std::uint32_t kShared = 0xffffffffu;  ///< two triangles run along it one way

  Vec3d at(std::uint32_t v) const { return mesh_.positions[v].cast<double>(); }
  Vec3d area_normal(const Triangle& t) const {
    return cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0]));
  }

  /// The new pair must be nearly flat and face the way of the old pair; a folded triangle is
  /// outvoted by the larger one beside it.
  bool keeps_the_surface(const Triangle& one, const Triangle& two, const Triangle& new_one,
                         const Triangle& new_two) const {
    const Vec3d before = normalized(area_normal(one) + area_normal(two));
    const Vec3d n1 = normalized(area_normal(new_one)), n2 = normalized(area_normal(new_two));
    return dot(n1, n2) > kFlat && dot(n1, before) > kFlat && dot(n2, before) > kFlat;
  }

  void add_edges(std::uint32_t t) {
    const Triangle& c = mesh_.triangles[t];
    for (std::uint32_t k = 0; k < 3; ++k) {
      const auto [place, is_new] = edges_.emplace(std::pair{c[k], c[(k + 1) % 3]}, t);
      if (!is_new) place->second = kShared;
    }
  }
  void drop_edges(const Triangle& c) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const auto place = edges_.find({c[k], c[(k + 1) % 3]});
      if (place != edges_.end() && place->second != kShared) edges_.erase(place);
    }
  }

  Mesh& mesh_;
  std::vector<std::uint32_t> local_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> edges_;
};

}  // namespace

std::uint64_t mend_triangles(Mesh& mesh, const std::vector<std::uint32_t>& rows) {
  Neighbourhood near(mesh, rows);
  std::uint64_t flipped = 0;
  for (int pass = 0; pass < kMostPasses; ++pass) {
    const std::uint64_t before = flipped;
    for (const std::uint32_t t : near.triangles()) {
      if (near.smallest_angle(mesh.triangles[t]) >= kThinDeg) continue;
      for (std::uint32_t k = 0; k < 3; ++k) {
        if (!near.flip(t, k)) continue;
        ++flipped;
        break;
      }
    }
    if (flipped == before) break;
  }
  return flipped;
}

}  // namespace cornice::stitch
