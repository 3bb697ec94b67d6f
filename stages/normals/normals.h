// SPDX-License-Identifier: GPL-3.0-or-later
// From the points of a tile and its surroundings to oriented points: the stage as one function.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/progress.h"
#include "core/points/flight_line.h"
#include "core/points/point_cloud.h"
#include "stages/normals/class_filter.h"
#include "stages/normals/isolated.h"
#include "stages/normals/orient.h"

namespace cornice::normals {

struct Options {
  NeighbourRule neighbours;  ///< of the plane fit
  IsolatedOptions isolated;
  BeamSource beam = BeamSource::kTrajectory;    ///< the best source to use
  float tolerance = OrientOptions{}.tolerance;  ///< as in OrientOptions, the next three too
  float tolerance_per_lack = OrientOptions{}.tolerance_per_lack;
  float least_breadth_m = OrientOptions{}.least_breadth_m;
  float least_support = OrientOptions{}.least_support;
  bool keep_halo = false;    ///< also put out the points that came from outside the tile
  bool keep_source = false;  ///< fill Result::source; 4 bytes a point
  int threads = 0;           ///< 0: all cores
};

/// What became of the points, step by step; all counts are of points.
struct Counts {
  std::size_t read = 0;  ///< tile and halo
  FilterCounts filter;
  std::size_t duplicates = 0;  ///< at exactly the place of another kept point
  std::size_t isolated = 0;
  std::array<std::size_t, 3> beams_by_source{};  ///< by BeamSource
  std::size_t without_line = 0;             ///< no flight line covers their time: vertical beam
  std::array<std::size_t, 4> settled_by{};  ///< by SettledBy, halo included
  int rounds = 0;                           ///< of propagation
  std::size_t halo = 0;                     ///< settled, but outside the tile and left out
  std::size_t put_out = 0;
};

/// Oriented points, in the order of a space-filling curve. Arrays have one entry per point.
struct Result {
  Vec3d origin;
  std::vector<Vec3f> positions;
  std::vector<Vec3f> normals;          ///< unit, out of the ground
  std::vector<float> quality;          ///< 0..1
  std::vector<std::uint16_t> line_id;  ///< 0: no line
  std::vector<std::uint8_t> classification;
  std::vector<std::uint16_t> intensity;  ///< empty where the input had none
  std::vector<std::uint8_t> halo;        ///< 1: outside the tile; empty unless keep_halo
  std::vector<std::uint32_t> source;     ///< index in the input; empty unless keep_source
  Counts counts;
};

/// Attributes of the points that the stage uses.
constexpr Attribute kAttributes =
    Attribute::kClassification | Attribute::kFlags | Attribute::kGpsTime | Attribute::kScanAngle |
    Attribute::kPointSource | Attribute::kChannel | Attribute::kUserData | Attribute::kIntensity;

/// Filters, fits, orients. The first `tile_points` of `points` belong to the tile, the rest is
/// halo; `points` is used up. Needs classification; other missing attributes count as zeros. Same
/// result for any number of threads. Peak memory about 65 bytes a point, input included.
Result compute_normals(PointCloud points, std::size_t tile_points, const FlightLines& lines,
                       const ClassRules& rules, const Options& options,
                       Progress& progress = no_progress());

}  // namespace cornice::normals
