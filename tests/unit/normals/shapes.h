// SPDX-License-Identifier: GPL-3.0-or-later
// Small point clouds with known normals and beams.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/random.h"
#include "core/base/vec.h"
#include "stages/normals/morton_order.h"
#include "stages/normals/orient.h"
#include "stages/normals/point_tree.h"

namespace cornice::normals::test {

/// Points with what is true of them.
struct Shape {
  std::vector<Vec3f> positions;
  std::vector<Vec3f> normals;  ///< true, out of the ground
  std::vector<Vec3f> beams;
  std::vector<BeamSource> sources;

  void add(Vec3d p, Vec3d normal, Vec3d beam, BeamSource source = BeamSource::kTrajectory) {
    positions.push_back(p.cast<float>());
    normals.push_back(normalized(normal).cast<float>());
    beams.push_back(normalized(beam).cast<float>());
    sources.push_back(source);
  }
};

/// A shape in the tree's order, and its tree.
struct Indexed {
  explicit Indexed(const Shape& from, int threads = 1) {
    const MortonOrder sorted = sort_along_curve(from.positions, threads);
    for (const std::uint32_t i : sorted.order) {
      shape.positions.push_back(from.positions[i]);
      shape.normals.push_back(from.normals[i]);
      shape.beams.push_back(from.beams[i]);
      shape.sources.push_back(from.sources[i]);
    }
    tree = PointTree(shape.positions, sorted.keys, threads);
  }
  Beams beams() const { return {shape.beams, shape.sources}; }

  Shape shape;
  PointTree tree;
};

/// About `density` points per square metre on the parallelogram corner + s u + t v, s, t in 0..1,
/// with noise along the normal; beams from a sensor at `sensor`.
inline void add_patch(Shape& shape, Vec3d corner, Vec3d u, Vec3d v, Vec3d outward, double density,
                      double noise_m, Vec3d sensor, std::uint64_t seed,
                      BeamSource source = BeamSource::kTrajectory) {
  const auto count = static_cast<std::size_t>(density * norm(cross(u, v)));
  const Vec3d normal = normalized(outward);
  for (std::size_t i = 0; i < count; ++i) {
    CounterRandom random(seed, 0, i);
    const double s = random.uniform(), t = random.uniform();
    const Vec3d on_patch = corner + u * s + v * t;
    const Vec3d p = on_patch + normal * (noise_m * random.normal());
    shape.add(p, normal, p - sensor, source);
  }
}

/// A blade of rock 20 m long and 12 m high on z = 20, `thickness_m` thick at its foot and half that
/// at its top, each face seen by a sensor on its own side; 3 cm noise.
inline void add_blade(Shape& shape, double thickness_m, double density) {
  const double half = 0.5 * thickness_m;
  for (const double side : {-1.0, 1.0}) {
    add_patch(shape, {10, 20 + side * half, 20}, {20, 0, 0}, {0, -0.5 * side * half, 12},
              {0, side, 0.5 * half / 12}, density, 0.03, {20, 20 + side * 900, 1500},
              side < 0.0 ? 7 : 8);
  }
}

/// Rolling ground of side `side_m` with 3 cm noise, seen from far above.
inline Shape rolling_ground(std::size_t count, double side_m, std::uint64_t seed = 1) {
  Shape shape;
  for (std::size_t i = 0; i < count; ++i) {
    CounterRandom random(seed, 1, i);
    const double x = random.uniform(0, side_m), y = random.uniform(0, side_m);
    const double z = 3.0 * std::sin(x / 5.0) * std::cos(y / 4.0) + 0.03 * random.normal();
    const Vec3d normal{-0.6 * std::cos(x / 5.0) * std::cos(y / 4.0),
                       0.75 * std::sin(x / 5.0) * std::sin(y / 4.0), 1.0};
    shape.add({x, y, z}, normal, {0.1, 0.0, -1.0});
  }
  return shape;
}

/// Share of points whose normal is on the wrong side of the truth, unsettled ones included.
inline double wrong_share(const Shape& shape, const OrientedNormals& oriented) {
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < shape.positions.size(); ++i) {
    const bool settled = oriented.settled_by[i] == SettledBy::kBeams ||
                         oriented.settled_by[i] == SettledBy::kPropagation;
    wrong += settled && dot(oriented.normals[i], shape.normals[i]) > 0.0f ? 0 : 1;
  }
  return static_cast<double>(wrong) / static_cast<double>(shape.positions.size());
}

}  // namespace cornice::normals::test
