// SPDX-License-Identifier: GPL-3.0-or-later
// Noise that benches make their ground of.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/base/random.h"

namespace cornice::bench {

/// Smooth noise of wavelength 1: values at whole places, blended by a quintic. In -1..1.
inline double value_noise(double x, double y, std::uint64_t seed, std::uint64_t stream) {
  const double fx = std::floor(x), fy = std::floor(y);
  const auto at = [&](double i, double j) {
    const auto key = static_cast<std::uint64_t>(static_cast<std::int64_t>(i) * 73856093 +
                                                static_cast<std::int64_t>(j) * 19349663);
    return 2.0 * CounterRandom(seed, stream, key).uniform() - 1.0;
  };
  const auto blend = [](double t) { return t * t * t * (t * (6.0 * t - 15.0) + 10.0); };
  const double u = blend(x - fx), v = blend(y - fy);
  const double low = at(fx, fy) + u * (at(fx + 1, fy) - at(fx, fy));
  const double high = at(fx, fy + 1) + u * (at(fx + 1, fy + 1) - at(fx, fy + 1));
  return low + v * (high - low);
}

/// Ridges and gullies down to boulders, in metres.
inline double mountain(double x, double y, std::uint64_t seed) {
  double z = 0.0, amplitude = 300.0, wavelength = 700.0;
  for (std::uint64_t octave = 0; octave < 9; ++octave) {
    z += amplitude * value_noise(x / wavelength, y / wavelength, seed + octave, 11);
    amplitude *= 0.45;
    wavelength /= 2.03;
  }
  return z;
}

}  // namespace cornice::bench
