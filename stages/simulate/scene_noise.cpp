// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/scene_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/random.h"

namespace cornice::simulate {
namespace {

struct Gradients {
  std::array<double, 64> x, y;
  Gradients() {
    for (std::size_t i = 0; i < 64; ++i) {
      const double angle = (static_cast<double>(i) + 0.5) * std::numbers::pi / 32.0;
      x[i] = std::cos(angle);
      y[i] = std::sin(angle);
    }
  }
};

double lattice_ramp(std::int64_t i, std::int64_t j, double fx, double fy, std::uint64_t seed) {
  static const Gradients gradients;
  const std::uint64_t hash = mix64(static_cast<std::uint64_t>(i) * 0x9e3779b97f4a7c15ULL +
                                   static_cast<std::uint64_t>(j) * 0xc2b2ae3d27d4eb4fULL + seed);
  const std::size_t g = hash >> 58;
  return gradients.x[g] * fx + gradients.y[g] * fy;
}

double fade(double t) { return t * t * t * (t * (6.0 * t - 15.0) + 10.0); }

/// Turns each octave, so that their lattices do not line up.
void turn(double& x, double& y) {
  const double u = 1.6 * x - 1.2 * y + 17.3;
  y = 1.2 * x + 1.6 * y - 9.1;
  x = u;
}

}  // namespace

double gradient_noise(double x, double y, std::uint64_t seed) {
  const double floor_x = std::floor(x), floor_y = std::floor(y);
  const auto i = static_cast<std::int64_t>(floor_x), j = static_cast<std::int64_t>(floor_y);
  const double fx = x - floor_x, fy = y - floor_y;
  const double u = fade(fx), v = fade(fy);
  const double a =
      std::lerp(lattice_ramp(i, j, fx, fy, seed), lattice_ramp(i + 1, j, fx - 1.0, fy, seed), u);
  const double b = std::lerp(lattice_ramp(i, j + 1, fx, fy - 1.0, seed),
                             lattice_ramp(i + 1, j + 1, fx - 1.0, fy - 1.0, seed), u);
  return std::numbers::sqrt2 * std::lerp(a, b, v);
}

double fractal_noise(double x, double y, int octaves, double gain, std::uint64_t seed) {
  double sum = 0.0, amplitude = 1.0;
  for (int octave = 0; octave < octaves; ++octave) {
    sum += amplitude * gradient_noise(x, y, seed + static_cast<std::uint64_t>(octave));
    amplitude *= gain;
    turn(x, y);
  }
  return sum;
}

double ridged_noise(double x, double y, int octaves, double gain, std::uint64_t seed) {
  double sum = 0.0, amplitude = 1.0, weight = 1.0, most = 0.0;
  for (int octave = 0; octave < octaves; ++octave) {
    double crest = 1.0 - std::abs(gradient_noise(x, y, seed + static_cast<std::uint64_t>(octave)));
    crest *= crest;
    sum += amplitude * weight * crest;
    most += amplitude;
    weight = std::clamp(crest * 1.6, 0.0, 1.0);
    amplitude *= gain;
    turn(x, y);
  }
  return sum / most;
}

double smooth_step(double low, double high, double value) {
  const double t = std::clamp((value - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

}  // namespace cornice::simulate
