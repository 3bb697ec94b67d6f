// SPDX-License-Identifier: GPL-3.0-or-later
// Low-discrepancy points: Roberts 2018, "The unreasonable effectiveness of quasirandom sequences"
// (the plastic number's additive recurrence).
#include "stages/compare/sampling.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"
#include "core/base/radix_sort.h"
#include "core/base/random.h"

namespace cornice::compare {
namespace {

constexpr std::size_t kGrain = 4096;
constexpr double kStepU = 0.7548776662466927;
constexpr double kStepV = 0.5698402909980532;
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

double fraction(double x) { return x - std::floor(x); }

float usable(const Foot& foot) { return foot.found() && !foot.beside ? foot.distance_m : kNone; }

/// Bits of a place's cell along one axis.
constexpr int kCellBits = 10;

/// Spreads the low 10 bits to every third bit.
std::uint64_t spread(std::uint64_t x) {
  x = (x | (x << 16)) & 0x030000ffu;
  x = (x | (x << 8)) & 0x0300f00fu;
  x = (x | (x << 4)) & 0x030c30c3u;
  return (x | (x << 2)) & 0x09249249u;
}

struct KeyedPlace {
  std::uint64_t key;
  std::uint32_t index;
};

/// Places along a Z-curve: the answer for one is then a good guess for the next, and what was read
/// for it is still in the cache. Samples of one wall of a DEM lie 100 m apart.
std::vector<KeyedPlace> along_curve(const std::vector<Vec3f>& places) {
  std::vector<KeyedPlace> order(places.size());
  if (places.empty()) return order;
  Vec3f low = places.front(), high = low;
  for (const Vec3f p : places) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Vec3f size = high - low;
  constexpr auto kCells = static_cast<float>((1 << kCellBits) - 1);
  const float scale = kCells / std::max({size.x, size.y, size.z, 1e-6f});
  const auto cell = [&](float x) { return spread(static_cast<std::uint64_t>(x * scale)); };
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Vec3f p = places[i] - low;
    order[i] = {cell(p.x) | cell(p.y) << 1 | cell(p.z) << 2, static_cast<std::uint32_t>(i)};
  }
  radix_sort(order, 0, 3 * kCellBits, 1, [](const KeyedPlace& place) { return place.key; });
  return order;
}

/// Samples of some elements of a surface, and which element each is of.
struct Samples {
  std::vector<Sample> samples;
  std::vector<std::uint32_t> elements;
};

Samples wanted_samples(const Surface& from, std::size_t begin, std::size_t end, double spacing_m,
                       std::uint64_t seed, const std::function<bool(double x, double y)>& wanted) {
  Samples made;
  std::vector<Sample> own;
  for (std::size_t i = begin; i < end; ++i) {
    own.clear();
    if (from.triangles.empty()) {
      own.push_back(
          {from.positions[i], from.normals.empty() ? Vec3f{0, 0, 1} : from.normals[i], 0.0f});
    } else {
      sample_triangle(from, i, spacing_m, seed, own);
    }
    for (const Sample& sample : own) {
      const Vec3d at = from.origin + sample.position.cast<double>();
      if (!wanted(at.x, at.y)) continue;
      made.samples.push_back(sample);
      made.elements.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return made;
}

/// Calls use(index, foot) for every place.
template <class Use>
void measure_places(const std::vector<Vec3f>& places, const DistanceField& field, float max_m,
                    const Use& use) {
  std::uint32_t guess = 0xffffffffu;
  for (const KeyedPlace& place : along_curve(places)) {
    const Foot foot = field.at(places[place.index], max_m, guess);
    if (foot.found()) guess = foot.triangle;
    use(place.index, foot);
  }
}

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
    const Samples made = wanted_samples(from, begin, end, spacing_m, seed, wanted);
    const std::vector<Sample>& samples = made.samples;
    std::vector<Vec3f> places;
    places.reserve(samples.size());
    for (const Sample& sample : samples) places.push_back(sample.position);
    std::vector<Measured>& measured = chunks[begin / kGrain];
    measured.resize(samples.size());
    measure_places(places, field, max_m, [&](std::size_t i, const Foot& foot) {
      // A cloud has no shape of its own; what it is measured from has.
      const Vec3f normal =
          is_cloud && foot.found() ? field.normal(foot.triangle) : samples[i].normal;
      const bool hangs =
          is_cloud ? normal.z < 0.0f : !overhang.empty() && overhang[made.elements[i]] != 0;
      measured[i] = {usable(foot), place_of(normal, samples[i].curvature_per_m, hangs)};
    });
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
    std::vector<Vec3f> places;
    std::vector<std::size_t> vertices;
    for (std::size_t v = begin; v < end; ++v) {
      const Vec3d at = from.origin + from.positions[v].cast<double>();
      if (!wanted(at.x, at.y)) continue;
      places.push_back(from.positions[v]);
      vertices.push_back(v);
    }
    measure_places(places, field, max_m,
                   [&](std::size_t i, const Foot& foot) { distances[vertices[i]] = usable(foot); });
  });
  return distances;
}

}  // namespace cornice::compare
