// SPDX-License-Identifier: GPL-3.0-or-later
// Gradient noise in plan (Perlin 2002) and its sums.
#pragma once

#include <cstdint>

namespace cornice::simulate {

/// About -1..1, zero on its integer lattice, C2. Unit wavelength.
double gradient_noise(double x, double y, std::uint64_t seed);

/// Octaves of halved wavelength and `gain` times the amplitude, about -1..1.
double fractal_noise(double x, double y, int octaves, double gain, std::uint64_t seed);

/// Ridged multifractal (Musgrave 1994), 0..1: sharp crests, smooth hollows; each octave is weighted
/// by the one before, so that crests are rough and hollows are not.
double ridged_noise(double x, double y, int octaves, double gain, std::uint64_t seed);

/// 0 below low, 1 above high, C1 between.
double smooth_step(double low, double high, double value);

}  // namespace cornice::simulate
