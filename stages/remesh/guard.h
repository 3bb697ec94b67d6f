// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps a patch within a distance of the input while it changes.
//
// Every vertex of the input that has left the surface hangs on a triangle that is near it, its
// carrier. A change replaces some triangles by others round one vertex:
//
//        o-----o               o-----o
//       / \ * / \             /  * ./ \       *: what the old triangles carry must find a new
//      o---v---o     =>      o----w--- o      one within the bound, and places (.) of the new
//       \ / \*/               \   /\* /       ones must find the input within it
//        o---o                 o----o
//
// So the bound holds from the first change to the last, and nothing but what has changed is
// measured. Carried samples after Ciampalini, Cignoni, Montani, Scopigno 1997, "Multiresolution
// decimation based on global error".
#pragma once

#include <cstdint>
#include <vector>

#include "stages/remesh/reference.h"

namespace cornice::remesh {

struct GuardLimits {
  float error_m = 0.04f;   ///< of both directions, at the places looked at
  float spacing_m = 0.5f;  ///< of the places looked at on new sides, about
  float small_m = 0.0f;    ///< nothing is looked at on sides no longer than this
  float doubt_m = 0.0f;    ///< nor after a change from which nothing carried is farther away; 0:
                           ///< after all
  bool inside = false;     ///< after all, and inside the new triangles, too
};

class Guard {
 public:
  Guard(const Reference& input, const GuardLimits& limits) : input_(&input), limits_(limits) {}

  /// Makes room for triangles numbered below `count`.
  void resize(std::size_t count) { head_.resize(count, kEnd); }
  /// Hangs an input vertex that is `distance_sq` away onto a triangle.
  void add(std::uint32_t triangle, std::uint32_t input_vertex, float distance_sq);
  /// What triangle `from` carries hangs on `to` from now on; `to` must carry nothing.
  void renumber(std::uint32_t from, std::uint32_t to);

  /// Another bound from now on.
  void bound_by(float error_m) { limits_.error_m = error_m; }

  /// A change is described by begin(), then the triangles that go, the input vertices that leave
  /// the surface with it, and the new triangles, each from the same vertex on.
  void begin();
  void take(std::uint32_t triangle) { old_.push_back(triangle); }
  void take_vertex(std::uint32_t input_vertex);
  void put(Vec3f centre, Vec3f b, Vec3f c);
  /// A place that one of the new triangles must come near, too.
  void reach(Vec3f place) { places_.push_back(place); }
  /// Whether the change keeps the bound and makes no triangle without area. `from`: an input
  /// triangle near the centre.
  bool fits(std::uint32_t from);
  /// As if it did: where the surface stays as it is. False where a triangle would have no area.
  bool fits_anyway();
  /// Carries the change out; fresh[i] is the number of the i-th new triangle.
  void commit(const std::vector<std::uint32_t>& fresh);

  /// Calls visit(input vertex, squared distance) for all that a triangle carries.
  template <class Visit>
  void each(std::uint32_t triangle, Visit&& visit) const {
    for (std::uint32_t s = head_[triangle]; s != kEnd; s = next_[s]) visit(id_[s], distance_sq_[s]);
  }

 private:
  static constexpr std::uint32_t kEnd = 0xffffffffu;

  /// A new triangle, made ready: u and v of a place p are dot(p - a, to_u) and dot(p - a, to_v),
  /// its height dot(p - a, normal).
  struct Facet {
    Vec3f a, b, c, to_u, to_v, normal;

    float distance_beside_sq(Vec3f p, float best) const;
  };
  struct Moved {
    std::uint32_t sample;  ///< kEnd: not in the lists yet
    std::uint32_t id;
    std::uint32_t facet;
    float distance_sq;
    Vec3f at;
  };

  bool carry_over(float most_sq);
  bool carry_over(Moved& moved, float most_sq) const;
  bool is_close() const;
  bool stays_near_input(std::uint32_t from) const;
  bool spokes_stay_near_input(std::uint32_t from) const;

  const Reference* input_;
  GuardLimits limits_;
  std::vector<std::uint32_t> head_;  ///< per triangle: a sample
  std::vector<std::uint32_t> next_;  ///< per sample
  std::vector<std::uint32_t> id_;
  std::vector<float> distance_sq_;
  std::vector<std::uint32_t> old_, left_;
  std::vector<Facet> facets_;
  std::vector<Moved> moved_;
  std::vector<Vec3f> places_;
  bool flat_ = false;  ///< a new triangle has no area
};

}  // namespace cornice::remesh
