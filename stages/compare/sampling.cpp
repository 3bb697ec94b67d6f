// SPDX-License-Identifier: GPL-3.0-or-later
// Low-discrepancy points: Roberts 2018, "The unreasonable effectiveness of quasirandom sequences"
// (the plastic number's additive recurrence).
#include "stages/compare/sampling.h"

#include <cmath>
#include <limits>

#include "core/base/parallel.h"
#include "core/base/random.h"

namespace cornice::compare {
namespace {

constexpr std::size_t kGrain = 4096;
constexpr double kStepU = 0.7548776662466927;
constexpr double kStepV = 0.5698402909980532;
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

double fraction(double x) { return x - std::floor(x); }

float usable(const Foot& foot) { return foot.found() && !foot.beside ? foot.distance_m : kNone; }

}  // namespace

void sample_triangle(const Surface& surface, std::size_t index, double spacing_m,
                     std::uint64_t seed, std::vector<Sample>& samples) {
  const Triangle& t = surface.triangles[index];
  const Vec3f a = surface.positions[t[0]];
  const Vec3f ab = surface.positions[t[1]] - a, ac = surface.positions[t[2]] - a;
  const double area = 0.5 * static_cast<double>(norm(cross(ab, ac)));
  CounterRandom random(seed, 0, index);
  const auto count = static_cast<std::size_t>(area / (spacing_m * spacing_m) + random.uniform());
  if (count == 0) return;
  double u = random.uniform(), v = random.uniform();
  for (std::size_t k = 0; k < count; ++k) {
    u = fraction(u + kStepU), v = fraction(v + kStepV);
    const bool beyond = u + v > 1.0;
    const auto p = static_cast<float>(beyond ? 1.0 - u : u);
    const auto q = static_cast<float>(beyond ? 1.0 - v : v);
    const float r = 1.0f - p - q;
    const Vec3f normal =
        surface.normals[t[0]] * r + surface.normals[t[1]] * p + surface.normals[t[2]] * q;
    const float curvature =
        surface.curvature[t[0]] * r + surface.curvature[t[1]] * p + surface.curvature[t[2]] * q;
    samples.push_back({a + ab * p + ac * q, normalized(normal), curvature});
  }
}

std::vector<Measured> measure_samples(const Surface& from, const DistanceField& field,
                                      const std::vector<std::uint8_t>& overhang, double spacing_m,
                                      double max_distance_m, std::uint64_t seed,
                                      const std::function<bool(double x, double y)>& wanted,
                                      int threads) {
  const bool is_cloud = from.triangles.empty();
  const std::size_t elements = is_cloud ? from.positions.size() : from.triangles.size();
  std::vector<std::vector<Measured>> chunks((elements + kGrain - 1) / kGrain);
  const auto max_m = static_cast<float>(max_distance_m);
  parallel_for(elements, kGrain, threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Sample> samples;
    std::vector<Measured>& measured = chunks[begin / kGrain];
    std::uint32_t guess = 0xffffffffu;
    for (std::size_t i = begin; i < end; ++i) {
      samples.clear();
      if (is_cloud) {
        samples.push_back(
            {from.positions[i], from.normals.empty() ? Vec3f{0, 0, 1} : from.normals[i], 0.0f});
      } else {
        sample_triangle(from, i, spacing_m, seed, samples);
      }
      for (const Sample& sample : samples) {
        const Vec3d at = from.origin + sample.position.cast<double>();
        if (!wanted(at.x, at.y)) continue;
        const Foot foot = field.at(sample.position, max_m, guess);
        if (foot.found()) guess = foot.triangle;
        // A cloud has no shape of its own; what it is measured from has.
        const Vec3f normal = is_cloud && foot.found() ? field.normal(foot.triangle) : sample.normal;
        const bool hangs = is_cloud ? normal.z < 0.0f : !overhang.empty() && overhang[i] != 0;
        measured.push_back({usable(foot), place_of(normal, sample.curvature_per_m, hangs)});
      }
    }
  });
  std::vector<Measured> all;
  for (std::vector<Measured>& chunk : chunks) {
    all.insert(all.end(), chunk.begin(), chunk.end());
    std::vector<Measured>().swap(chunk);
  }
  return all;
}

std::vector<float> measure_vertices(const Surface& from, const DistanceField& field,
                                    double max_distance_m,
                                    const std::function<bool(double x, double y)>& wanted,
                                    int threads) {
  std::vector<float> distances(from.positions.size(), kNone);
  const auto max_m = static_cast<float>(max_distance_m);
  parallel_for(from.positions.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    std::uint32_t guess = 0xffffffffu;
    for (std::size_t v = begin; v < end; ++v) {
      const Vec3d at = from.origin + from.positions[v].cast<double>();
      if (!wanted(at.x, at.y)) continue;
      const Foot foot = field.at(from.positions[v], max_m, guess);
      if (foot.found()) guess = foot.triangle;
      distances[v] = usable(foot);
    }
  });
  return distances;
}

}  // namespace cornice::compare
