// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/bend_fit.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "core/base/random.h"

namespace cornice::normals {
namespace {

struct Cloud {
  std::vector<Vec3f> points;  ///< the first is the one asked about
  Vec3d normal;               ///< of the ground there
};

/// Ground z = curvature x² / 2 seen from a point at `x` on it, with neighbours up to `reach_m` away
/// to both sides in y but in x from `low` to `high` of that; turned about y so that no axis is
/// special.
Cloud bent_ground(double curvature, double x, double low, double high, double reach_m,
                  double noise_m, std::uint64_t seed) {
  const double turn = 0.7, c = std::cos(turn), s = std::sin(turn);
  const auto turned = [&](Vec3d p) { return Vec3d{c * p.x - s * p.z, p.y, s * p.x + c * p.z}; };
  Cloud cloud;
  for (std::uint64_t i = 0; i < 16; ++i) {
    CounterRandom random(seed, 7, i);
    const double across = i == 0 ? 0.0 : reach_m * random.uniform(low, high);
    const double y = i == 0 ? 0.0 : reach_m * random.uniform(-1.0, 1.0);
    const double z = 0.5 * curvature * (x + across) * (x + across) + noise_m * random.normal();
    cloud.points.push_back(turned({x + across, y, z}).cast<float>());
  }
  cloud.normal = turned(normalized(Vec3d{-curvature * x, 0.0, 1.0}));
  return cloud;
}

void add(NeighbourBlock& block, const std::vector<Vec3f>& points) {
  std::vector<std::uint32_t> index;
  std::vector<float> x, y, z;
  for (const Vec3f p : points) {
    index.push_back(static_cast<std::uint32_t>(index.size()));
    x.push_back(p.x - points[0].x), y.push_back(p.y - points[0].y), z.push_back(p.z - points[0].z);
  }
  block.add(0, {static_cast<std::uint32_t>(points.size()), index.data(), x.data(), y.data(),
                z.data(), 0.0f});
}

struct Fits {
  PlaneBlock planes;
  std::array<Vec3f, kLanes> bent;
};

Fits fit(const std::vector<std::vector<Vec3f>>& clouds) {
  NeighbourBlock block;
  for (const std::vector<Vec3f>& points : clouds) add(block, points);
  block.finish();
  Fits fits;
  fit_planes(block, fits.planes);
  fits.bent = bent_normals(block, fits.planes);
  return fits;
}

double degrees_between(Vec3f a, Vec3d b) {
  const Vec3d n = a.cast<double>();
  return 57.29577951308232 * std::atan2(norm(cross(n, b)), std::abs(dot(n, b)));
}

/// Root mean square angles to the truth over `count` seeds, of planes and of what becomes of them.
std::pair<double, double> rms_degrees(const auto& make, std::uint64_t count) {
  double plane_sq = 0.0, bent_sq = 0.0;
  for (std::uint64_t seed = 0; seed < count; ++seed) {
    const Cloud cloud = make(seed);
    const Fits fits = fit({cloud.points});
    plane_sq += std::pow(degrees_between(fits.planes.plane(0).normal, cloud.normal), 2);
    bent_sq += std::pow(degrees_between(fits.bent[0], cloud.normal), 2);
  }
  return {std::sqrt(plane_sq / static_cast<double>(count)),
          std::sqrt(bent_sq / static_cast<double>(count))};
}

TEST(BentNormals, AreThoseOfTheGroundAtAPointWhoseNeighboursLieToOneSide) {
  const auto edge = [](std::uint64_t seed) {
    return bent_ground(0.4, 0.3, 0.0, 1.0, 1.2, 0.02, seed);
  };
  const auto [plane, bent] = rms_degrees(edge, 100);
  EXPECT_GT(plane, 9.0);
  EXPECT_LT(bent, 0.7 * plane);
}

TEST(BentNormals, FollowNoiseLittleMoreThanThePlaneDoesOnFlatGround) {
  const auto flat = [](std::uint64_t seed) {
    return bent_ground(0.0, 0.0, -1.0, 1.0, 0.6, 0.025, seed);
  };
  const auto [plane, bent] = rms_degrees(flat, 300);
  EXPECT_LT(bent, 1.2 * plane);
}

TEST(BentNormals, AreThePlanesOnDenseGroundOfRangeNoise) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Fits fits = fit({bent_ground(0.1, 0.2, -1.0, 1.0, 0.4, 0.015, seed).points});
    EXPECT_EQ(fits.bent[0], fits.planes.plane(0).normal);
  }
}

TEST(BentNormals, AreThePlanesOfFacesWithFewPoints) {
  std::vector<Vec3f> face = bent_ground(0.4, 0.3, 0.0, 1.0, 1.2, 0.02, 1).points;
  face.resize(8);
  const Fits fits = fit({face});
  EXPECT_EQ(fits.bent[0], fits.planes.plane(0).normal);
}

TEST(BentNormals, AreTurnedByPointsOfAnotherFaceLessThanTwiceAsFarAsThePlane) {
  const auto two_faces = [](std::uint64_t seed) {
    Cloud cloud = bent_ground(0.0, 0.0, -1.0, 1.0, 1.0, 0.01, seed);
    for (const std::size_t i : {14u, 15u}) cloud.points[i] += (cloud.normal * 0.4).cast<float>();
    return cloud;
  };
  const auto [plane, bent] = rms_degrees(two_faces, 100);
  EXPECT_LT(bent, 2.0 * plane);
}

TEST(BentNormals, AreOfUnitLengthAndOnThePlanesSide) {
  const Fits fits = fit({bent_ground(0.4, 0.3, 0.0, 1.0, 1.2, 0.02, 5).points});
  EXPECT_NEAR(dot(fits.bent[0], fits.bent[0]), 1.0f, 1e-6f);
  EXPECT_GT(dot(fits.bent[0], fits.planes.plane(0).normal), 0.0f);
}

TEST(BentNormals, AreTheSameForALaneWhateverIsBesideIt) {
  const std::vector<Vec3f> one = bent_ground(0.4, 0.3, 0.0, 1.0, 1.2, 0.02, 1).points;
  std::vector<Vec3f> few = bent_ground(0.3, 0.1, -1.0, 1.0, 2.0, 0.05, 2).points;
  few.resize(13);
  const std::vector<Vec3f> line{{0, 0, 0}, {1, 2, 3}, {2, 4, 6}, {3, 6, 9}};
  const Fits together = fit({line, one, few, one}), alone = fit({one}), few_alone = fit({few});
  EXPECT_EQ(together.bent[0], Vec3f{});
  EXPECT_EQ(together.bent[1], alone.bent[0]);
  EXPECT_EQ(together.bent[2], few_alone.bent[0]);
  EXPECT_EQ(together.bent[3], alone.bent[0]);
}

TEST(BentNormals, AreFiniteForPointsOnTopOfEachOtherAndKilometresApart) {
  std::vector<Vec3f> heap = bent_ground(0.4, 0.3, -1.0, 1.0, 1.0, 0.0, 3).points;
  for (std::size_t i = 1; i < 12; ++i) heap[i] = heap[0];
  std::vector<Vec3f> wide = bent_ground(0.0, 0.0, -1.0, 1.0, 4000.0, 100.0, 4).points;
  const Fits fits = fit({heap, wide});
  for (const std::size_t l : {0u, 1u}) {
    const Vec3f n = fits.bent[l];
    EXPECT_NEAR(dot(n, n), 1.0f, 1e-5f) << l;
  }
}

}  // namespace
}  // namespace cornice::normals
