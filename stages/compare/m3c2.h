// SPDX-License-Identifier: GPL-3.0-or-later
// Distances between two clouds along local normals.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "stages/compare/options.h"
#include "stages/compare/source.h"
#include "stages/compare/statistics.h"

namespace cornice::compare {

/// A core point of cloud A and how far B lies from it.
struct M3c2Point {
  Vec3f position;
  Vec3f normal;          ///< unit; on the side of A's own normals, else up
  float distance_m;      ///< along the normal, positive where B lies outside; NaN: not known
  float detection_95_m;  ///< level of detection at 95 %; NaN: not known
  bool is_significant() const {
    return distance_m > detection_95_m || -distance_m > detection_95_m;
  }
};

/// Of all parts.
struct M3c2Result {
  Statistics statistics;
  std::uint64_t core_points = 0;
  std::uint64_t measured = 0;
  std::uint64_t significant = 0;  ///< beyond the level of detection
  double mean_detection_95_m = 0.0;
};

/// Core points of `a` in `box` (world): one for each cube of options.spacing_m that holds points.
/// Both clouds must reach m3c2_halo_m beyond the box and have one frame. Equation numbers are those
/// of Lague, Brodu, Leroux 2013, "Accurate 3D comparison of complex topography with terrestrial
/// laser scanner: application to the Rangitikei canyon (N-Z)", ISPRS Journal 82.
std::vector<M3c2Point> m3c2_points(const Surface& a, const Surface& b, const Box2d& box,
                                   const M3c2Options& options, int threads);

/// How far around a core point its neighbours lie.
double m3c2_halo_m(const M3c2Options& options);

}  // namespace cornice::compare
