// SPDX-License-Identifier: GPL-3.0-or-later
// Takes surface without measurements off a reconstructed mesh.
//
//   measured |      gap      | measured |  gap   |  measured
//   ─────────┼───────────────┼──────────┼────────┼───────────   gap wider than the bridge: dropped,
//            ▲ dropped ▲     ▲          ▲ kept, source = 1      narrower: kept and marked
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/progress.h"
#include "core/mesh/mesh.h"

namespace cornice::trim {

/// A vertex is measured where its support is at most
///   min(max_support_m, max(min_support_m, spacings / sqrt(density))),
/// density in points per square metre. Without density: at most max_support_m.
struct Options {
  double spacings = 3.0;       ///< mean distances between points
  double min_support_m = 0.5;  ///< never asks for more
  double max_support_m = 2.0;  ///< never allows more, however sparse the points
  double bridge_m = 10.0;      ///< gaps up to this width are kept; 0: none
  double min_area_m2 = 100.0;  ///< smaller parts that do not reach the tile's edge are dropped
  int threads = 0;
};

/// What holds a vertex up: the values of the byte property "source".
enum class Source : std::uint8_t { kMeasured = 0, kBridged = 1, kModel = 2 };

struct Counts {
  std::uint64_t measured_vertices = 0;
  std::uint64_t bridged_vertices = 0;
  std::uint64_t model_vertices = 0;
  std::uint64_t dropped_triangles = 0;  ///< for want of measurements
  std::uint64_t small_parts = 0;        ///< dropped for their size
  std::uint64_t split_vertices = 0;     ///< doubled because the surface touched itself there
  double area_m2 = 0.0;                 ///< of the result
  double bridged_area_m2 = 0.0;  ///< of triangles with a bridged vertex and none of the model
  double model_area_m2 = 0.0;    ///< of triangles with a vertex of the elevation model
  double dropped_area_m2 = 0.0;  ///< for want of measurements
};

struct Result {
  Mesh mesh;  ///< with the byte property "source"
  Counts counts;
};

/// `mesh` has the float property "support" (metres) and may have "density" (points/m²).
///
/// The gap rule is a morphological closing along the surface: what lies within bridge_m / 2 of
/// measured surface is taken, then what lies within bridge_m / 2 of the rest is given up again
/// (Serra 1982). Tiles decide alike on an edge they share, because a vertex on an open border is
/// judged by that border alone: by its own support, or by the length of the unmeasured run it lies
/// in, which ends at the corners of the tile; and a triangle at the border by the two ends of its
/// border edge.
///
/// `on_model` is empty or has a byte per vertex: unmeasured vertices with 1 are kept like measured
/// ones, and gaps between both are bridged up to kModelBridgeM at least, as the reconstruction goes
/// from one to the other there. Throws InputError without "support".
Result trim(const Mesh& mesh, const Options& options,
            const std::vector<std::uint8_t>& on_model = {}, Progress& progress = no_progress());

/// Twice the distance from measured points at which cornice-poisson puts those of the model.
inline constexpr double kModelBridgeM = 10.0;

}  // namespace cornice::trim
