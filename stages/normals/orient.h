// SPDX-License-Identifier: GPL-3.0-or-later
// Normals of points, turned out of the ground by the beams that met them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/progress.h"
#include "core/base/vec.h"
#include "stages/normals/leaf_search.h"
#include "stages/normals/witnesses.h"

namespace cornice::normals {

/// How a point's normal got its side.
enum class SettledBy : std::uint8_t {
  kNothing,      ///< not settled: neither beams nor neighbours say which side is outside
  kNoPlane,      ///< no plane fits the neighbourhood: fewer than 3 points, or all on one line
  kBeams,        ///< by the beams of the neighbourhood
  kPropagation,  ///< by neighbours that were settled before
};

struct OrientOptions {
  NeighbourRule neighbours;
  /// Least mean |n . b| of a neighbourhood, -1..1, that settles its point at once. Lower settles
  /// more points early; the rest is settled by neighbours, better supported points first.
  float tolerance = 0.25f;
  /// Added to the tolerance per unit of lacking quality: a poor plane needs a clearer beam.
  float tolerance_per_lack = 0.5f;
  /// Breadth (PlaneFit::breadth_m) below which a plane is one of range noise, however good its
  /// quality, and is fitted again to twice, four, eight and sixteen times the neighbours: at the
  /// turns of a swinging mirror points lie closer together than they are exact. 0: never.
  float least_breadth_m = 0.1f;
  /// Support below which a point stays unsettled, on the same scale as the tolerance.
  float least_support = 0.02f;
  int threads = 0;  ///< 0: all cores
};

/// Normals of N points in the tree's order.
struct OrientedNormals {
  std::vector<Vec3f> normals;           ///< unit, out of the ground; of no use where not settled
  std::vector<float> quality;           ///< q1 * q2 of the plane, 0..1
  std::vector<SettledBy> settled_by;    ///< N
  std::array<std::size_t, 4> counts{};  ///< points by SettledBy
  int rounds = 0;                       ///< of propagation
};

/// Fits a plane to every neighbourhood and turns its normal to the side that the beams came from.
///
/// A beam has passed through empty space before it met the surface, so a normal n points outwards
/// where n . b < 0. Every beam that met the neighbourhood is a witness, weighted by how near its
/// point lies to the plane: a face that the point's own line only grazes was often met squarely by
/// another line. Points whose witnesses leave doubt are settled by settled neighbours across the
/// surface (propagate.h), the best supported first.
///
/// `beams` are in the tree's order, N each. Same result for any number of threads.
OrientedNormals orient_normals(const PointTree& tree, const Beams& beams,
                               const OrientOptions& options, Progress& progress = no_progress());

}  // namespace cornice::normals
