// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/returns.h"

#include <algorithm>
#include <cmath>

namespace cornice::simulate {
namespace {

/// Two echoes closer than this merge in a receiver (pulses of 4 ns).
constexpr double kEchoDistanceM = 0.6;
/// Beyond this incidence (88.9 degrees) too little light comes back.
constexpr double kLeastCosIncidence = 0.02;
/// Water mirrors: a rare echo where the surface is hit nearly square.
constexpr double kWaterEchoChance = 0.01;
constexpr double kWaterLeastCosIncidence = 0.98;
/// A leaf takes between these shares of what is left of the pulse.
constexpr double kLeastLeafShare = 0.15;
constexpr double kMostLeafShare = 0.55;
/// Below this share of the pulse nothing more is detected.
constexpr double kLeastEnergy = 0.12;

/// Of the squared noise, the part along the beam at the nominal range; the rest is shared by the
/// two axes across. Range noise dominates on survey scanners.
constexpr double kAlongShare = 0.64;
/// Part of the noise along the beam that does not depend on range.
constexpr double kConstantAlongShare = 0.5;

double reflectance(SurfaceId surface) {
  switch (surface) {
    case SurfaceId::kGround:
      return 0.35;
    case SurfaceId::kOverhang:
      return 0.30;
    case SurfaceId::kVegetation:
      return 0.45;
    case SurfaceId::kHouse:
      return 0.25;
    case SurfaceId::kWater:
      return 0.05;
  }
  return 0.3;
}

}  // namespace

EchoList follow_pulse(const Scene& scene, const Ray& ray, int most_echoes, CounterRandom& random) {
  Hit hit;
  // Leaves over the edge of the scene have no ground below them and are left out with it.
  if (!scene.cast(ray, hit)) return {};
  return follow_pulse(scene, ray, hit, most_echoes, random);
}

EchoList follow_pulse(const Scene& scene, const Ray& ray, const Hit& hit, int most_echoes,
                      CounterRandom& random) {
  EchoList list;
  double energy = 1.0;
  CanopyPassage passage;
  if (scene.canopy(ray, hit.range_m, passage) && passage.density > 0.0) {
    double range = passage.enter_m;
    while (list.count + 1 < most_echoes && energy > kLeastEnergy) {
      // Leaves are met as a Poisson process along the beam.
      range += std::max(kEchoDistanceM, -std::log(1.0 - random.uniform()) / passage.density);
      if (range > std::min(passage.exit_m, hit.range_m - kEchoDistanceM)) break;
      Echo& echo = list.echoes[static_cast<std::size_t>(list.count++)];
      echo = {range,
              -ray.direction,
              SurfaceId::kVegetation,
              energy,
              1.0,
              (hit.range_m - range) * -ray.direction.z};
      energy *= 1.0 - random.uniform(kLeastLeafShare, kMostLeafShare);
    }
  }
  if (energy <= kLeastEnergy) return list;
  const double cos_incidence = -dot(ray.direction, hit.normal);
  if (cos_incidence < kLeastCosIncidence) return list;
  if (hit.surface == SurfaceId::kWater &&
      (cos_incidence < kWaterLeastCosIncidence || random.uniform() >= kWaterEchoChance))
    return list;
  list.echoes[static_cast<std::size_t>(list.count++)] = {hit.range_m, hit.normal,    hit.surface,
                                                         energy,      cos_incidence, 0.0};
  return list;
}

double NoiseOptions::along_m(double range_m) const {
  return sigma_m * std::sqrt(kAlongShare) *
         (kConstantAlongShare + (1.0 - kConstantAlongShare) * range_m / nominal_range_m);
}

double NoiseOptions::across_rad() const {
  return sigma_m * std::sqrt(0.5 * (1.0 - kAlongShare)) / nominal_range_m;
}

std::uint16_t intensity_of(const Echo& echo, double nominal_range_m, CounterRandom& random) {
  constexpr double kFullScale = 12000.0;  // of a white surface at the nominal range
  const double fall_off = nominal_range_m / echo.range_m;
  const double speckle = 1.0 + 0.25 * (random.uniform() + random.uniform() - 1.0);
  const double value = kFullScale * reflectance(echo.surface) * echo.cos_incidence * echo.energy *
                       fall_off * fall_off * speckle;
  return static_cast<std::uint16_t>(std::clamp(value, 1.0, 65535.0));
}

}  // namespace cornice::simulate
