// SPDX-License-Identifier: GPL-3.0-or-later
// The neighbours that lie on the same face of a sharp rock as a point does.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/vec.h"
#include "stages/normals/neighbours.h"
#include "stages/normals/plane_fit.h"
#include "stages/normals/witnesses.h"

namespace cornice::normals {

/// Whether the neighbours lie so far from their plane that it may cut through several faces.
bool may_mix_faces(const PlaneFit& plane);

/// Takes neighbourhoods on a crest, a blade or in a nook apart. Thread contract: one per thread.
class FaceFinder {
 public:
  /// Adds to `faces`, in the next lane, those neighbours of lane `lane` of `block` that lie on the
  /// same face as its point: of all planes through the point and two of its 16 nearest neighbours
  /// the one that has most neighbours on it, near ones counting more, whose beams met it from the
  /// side that the point's own beam came from. All of them where no plane has enough. `block` must
  /// be finished.
  void add_face(const NeighbourBlock& block, std::size_t lane, const Beams& beams,
                NeighbourBlock& faces);

 private:
  struct Neighbour {
    Vec3f offset, beam;  ///< from the point, metres; unit
    float length_m, weight;
    float per_limit_sq;  ///< 1 / square of the distance at which it is off a plane
    std::uint32_t index;
  };
  /// Planes through the point and two neighbours, side by side.
  struct Planes {
    std::array<float, kLanes> x, y, z, valid;
  };
  void collect(const NeighbourBlock& block, std::size_t lane, const Beams& beams);
  Planes planes_through(const Neighbour& a) const;
  std::array<float, kLanes> support(const Planes& planes, Vec3f own_beam) const;
  Vec3f best_plane(Vec3f own_beam) const;

  std::vector<Neighbour> near_;
};

}  // namespace cornice::normals
