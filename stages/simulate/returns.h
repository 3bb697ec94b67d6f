// SPDX-License-Identifier: GPL-3.0-or-later
// What comes back of one pulse: leaves on the way, then the first solid surface.
#pragma once

#include <array>
#include <cstdint>

#include "core/base/random.h"
#include "stages/simulate/scene.h"

namespace cornice::simulate {

/// Echoes a receiver keeps of one pulse.
inline constexpr int kMostEchoes = 7;

struct Echo {
  double range_m = 0.0;  ///< true distance from the sensor
  Vec3d normal;          ///< unit; against the beam in vegetation
  SurfaceId surface = SurfaceId::kGround;
  double energy = 1.0;          ///< share of the pulse that was left for it
  double cos_incidence = 1.0;   ///< of beam and normal, 0..1
  double above_ground_m = 0.0;  ///< along the vertical, from the ground where the beam ends
};

struct EchoList {
  std::array<Echo, kMostEchoes> echoes;
  int count = 0;
};

/// Follows one pulse. Echoes are in order of range, at least kEchoDistanceM apart, at most
/// `most_echoes` (1..kMostEchoes; the last is never dropped in favour of leaves). Water swallows
/// nearly all pulses, and a surface that is hit at a grazing angle gives nothing.
EchoList follow_pulse(const Scene& scene, const Ray& ray, int most_echoes, CounterRandom& random);
/// The same where `hit` is what scene.cast() says of the ray.
EchoList follow_pulse(const Scene& scene, const Ray& ray, const Hit& hit, int most_echoes,
                      CounterRandom& random);

/// How well a scanner measures.
struct NoiseOptions {
  /// Standard deviation of a point's position in space at the nominal range: along the beam it
  /// grows with range, across the beam it is an angle.
  double sigma_m = 0.03;
  double nominal_range_m = 1200.0;

  double along_m(double range_m) const;  ///< standard deviation along the beam
  double across_rad() const;             ///< standard deviation of the beam, per axis
};

/// Recorded strength of an echo: reflectance, incidence, range and energy left, with speckle.
std::uint16_t intensity_of(const Echo& echo, double nominal_range_m, CounterRandom& random);

}  // namespace cornice::simulate
