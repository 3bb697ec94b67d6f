// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/poisson/hills.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/base/random.h"

namespace cornice::bench {
namespace {

struct Height {
  double z, dx, dy;
};

Height height_at(double x, double y, double side) {
  const double bend = x - 0.5 * side - 20.0 * std::sin(y / 60.0);
  const double wall = std::tanh(bend / 2.0), steep = 10.0 * (1.0 - wall * wall);
  return {500.0 + 75.0 * std::sin(x / 130.0) * std::cos(y / 170.0) + 20.0 * wall +
              1.5 * std::sin(x / 7.0) * std::sin(y / 9.0),
          75.0 / 130.0 * std::cos(x / 130.0) * std::cos(y / 170.0) + steep +
              1.5 / 7.0 * std::cos(x / 7.0) * std::sin(y / 9.0),
          -75.0 / 170.0 * std::sin(x / 130.0) * std::sin(y / 170.0) -
              steep * std::cos(y / 60.0) / 3.0 + 1.5 / 9.0 * std::sin(x / 7.0) * std::cos(y / 9.0)};
}

}  // namespace

double Hills::distance(Vec3d place) const {
  const Height h = height_at(place.x, place.y, side_m_);
  return (place.z - h.z) / std::sqrt(1.0 + h.dx * h.dx + h.dy * h.dy);
}

OrientedPoints Hills::sample(std::size_t count, double noise_m, double tilt_deg, std::uint64_t seed,
                             int threads) const {
  OrientedPoints points;
  points.origin = origin();
  points.positions.resize(count);
  points.normals.resize(count);
  points.quality.resize(count);
  const double tilt = tilt_deg * 0.017453292519943295 / 1.25331413731550;  // mean of a Rayleigh
  parallel_for(count, 1u << 16, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      CounterRandom random(seed, 0, i);
      const double x = random.uniform(0, side_m_);
      // Along the flight in order, as a scanner's lines come; two passes.
      const double y = side_m_ * (static_cast<double>(i % (count / 2 + 1)) + random.uniform()) /
                       (0.5 * static_cast<double>(count) + 1.0);
      const Height h = height_at(x, y, side_m_);
      const Vec3d normal = normalized(Vec3d{-h.dx, -h.dy, 1.0});
      const Vec3d off{tilt * random.normal(), tilt * random.normal(), tilt * random.normal()};
      const Vec3d at = Vec3d{x, y, h.z} + normal * (noise_m * random.normal());
      points.positions[i] = at.cast<float>();
      points.normals[i] = normalized(normal + off).cast<float>();
      points.quality[i] = static_cast<float>(random.uniform(0.7, 1.0));
    }
  });
  return points;
}

HillsAccuracy measure_accuracy(const Hills& hills, const Mesh& mesh, double border_m,
                               double far_m) {
  double sum = 0.0;
  std::size_t near = 0, far = 0;
  const Vec3d shift = mesh.origin - hills.origin();
  const auto add = [&](Vec3d place) {
    const double edge =
        std::min({place.x, place.y, hills.side_m() - place.x, hills.side_m() - place.y});
    if (edge < border_m) return;
    const double d = hills.distance(place);
    if (std::abs(d) > far_m) {
      ++far;
      return;
    }
    ++near;
    sum += d * d;
  };
  const auto at = [&](std::uint32_t v) { return shift + mesh.positions[v].cast<double>(); };
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) add(at(v));
  for (const auto& t : mesh.triangles) add((at(t[0]) + at(t[1]) + at(t[2])) / 3.0);
  const double all = static_cast<double>(std::max<std::size_t>(near + far, 1));
  return {std::sqrt(sum / static_cast<double>(std::max<std::size_t>(near, 1))),
          static_cast<double>(far) / all};
}

}  // namespace cornice::bench
