// SPDX-License-Identifier: GPL-3.0-or-later
// Samples of a surface, so many per area, and their distances from another surface.
#pragma once

#include <functional>
#include <vector>

#include "stages/compare/distance_field.h"
#include "stages/compare/statistics.h"

namespace cornice::compare {

/// One place of a surface; stands for spacing^2 square metres of it.
struct Sample {
  Vec3f position;  ///< in the surface's frame
  Vec3f normal;    ///< unit, between those of the corners
  float curvature_per_m = 0.0f;
};

/// Appends the samples of triangle `index`: area / spacing^2 of them on average, the rest of the
/// division decided by a number drawn from `seed` and the index alone, spread over the triangle by
/// a sequence of low discrepancy. So the number of samples is that of the area whatever the shapes
/// of triangles, and each triangle's samples depend on nothing else.
void sample_triangle(const Surface& surface, std::size_t index, double spacing_m,
                     std::uint64_t seed, std::vector<Sample>& samples);

/// What was measured at a sample.
struct Measured {
  float distance_m;  ///< NaN: none
  Place place;
};

/// Measures every sample of `from` that `wanted` accepts (world position), in order of triangles;
/// of a cloud every point. `overhang`: a byte a triangle, or empty. `field` is in the frame of
/// `from`. The sign is that of the field.
std::vector<Measured> measure_samples(const Surface& from, const DistanceField& field,
                                      const std::vector<std::uint8_t>& overhang, double spacing_m,
                                      double max_distance_m, std::uint64_t seed,
                                      const std::function<bool(double x, double y)>& wanted,
                                      int threads);

/// Distances of all vertices; NaN where there is none.
std::vector<float> measure_vertices(const Surface& from, const DistanceField& field,
                                    double max_distance_m,
                                    const std::function<bool(double x, double y)>& wanted,
                                    int threads);

}  // namespace cornice::compare
