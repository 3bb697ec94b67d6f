// SPDX-License-Identifier: GPL-3.0-or-later
// What a comparison can be told.
#pragma once

#include <vector>

namespace cornice::compare {

/// Scales of the distances along local normals (Lague, Brodu, Leroux 2013).
struct M3c2Options {
  double normal_scale_m = 2.0;      ///< diameter of the ball whose points give a normal
  double projection_scale_m = 1.0;  ///< diameter of the cylinder along it
  double depth_m = 5.0;             ///< of the cylinder, either way; what it costs grows with it
  double spacing_m = 1.0;           ///< of the core points
  double registration_m = 0.0;      ///< by which the two clouds may be shifted; widens the level
};

/// Every length in metres.
struct Options {
  double spacing_m = 0.5;        ///< a surface is sampled once per square of this side
  double max_distance_m = 25.0;  ///< farther counterparts are none; the halo that is read
  double step_m = 0.0;           ///< of the grid of vertical differences; 0: the DEM's, else 0.5
  double colour_range_m = 0.0;   ///< of the colours, either side of zero; 0: by the differences
  std::vector<double> tolerances_m{0.1, 0.25, 0.5, 1.0};  ///< of the completeness
  std::vector<int> classes;       ///< of LAS points; empty: all but noise and virtual points
  double overhang_deg = 0.0;      ///< below the horizon a normal must point by more than this
  double min_overhang_m2 = 0.1;   ///< smaller ones are not listed
  double min_layer_gap_m = 0.25;  ///< between two layers of one column
  M3c2Options m3c2;
  int threads = 0;
};

}  // namespace cornice::compare
