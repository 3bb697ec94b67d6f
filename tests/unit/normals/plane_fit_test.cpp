// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/plane_fit.h"

#include <gtest/gtest.h>
#include <pcl/features/normal_3d.h>

#include <cmath>

#include "tests/unit/normals/shapes.h"

namespace cornice::normals {
namespace {

/// A neighbourhood of the first point.
class Around {
 public:
  explicit Around(const std::vector<Vec3f>& points) {
    for (const Vec3f& p : points) {
      index_.push_back(static_cast<std::uint32_t>(index_.size()));
      x_.push_back(p.x - points[0].x);
      y_.push_back(p.y - points[0].y);
      z_.push_back(p.z - points[0].z);
    }
  }
  PlaneFit fit() const {
    const auto size = static_cast<std::uint32_t>(index_.size());
    return fit_plane({size, index_.data(), x_.data(), y_.data(), z_.data(), 0.0f});
  }

 private:
  std::vector<std::uint32_t> index_;
  std::vector<float> x_, y_, z_;
};

std::vector<Vec3f> noisy_patch(std::size_t count, double noise_m, std::uint64_t seed) {
  std::vector<Vec3f> points;
  for (std::size_t i = 0; i < count; ++i) {
    CounterRandom random(seed, 3, i);
    const double x = random.uniform(), y = random.uniform();
    points.push_back(
        Vec3d{900.0 + x, 400.0 + y, 0.4 * x - 0.2 * y + noise_m * random.normal()}.cast<float>());
  }
  return points;
}

TEST(FitPlane, FindsTheNormalOfAPlane) {
  const PlaneFit fit = Around({{0, 0, 0}, {1, 0, 1}, {0, 1, 0}, {1, 1, 1}, {2, 1, 2}}).fit();
  EXPECT_NEAR(fit.normal.x, -std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(fit.normal.y, 0.0, 1e-6);
  EXPECT_NEAR(fit.normal.z, std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(fit.spread_m, 0.0, 1e-4);
}

TEST(FitPlane, FindsTheNormalOfThreePoints) {
  const PlaneFit fit = Around({{5, 5, 5}, {6, 5, 5}, {5, 5, 7}}).fit();
  EXPECT_NEAR(fit.normal.y, 1.0, 1e-6);
}

TEST(FitPlane, GivesNoNormalToTooFewPointsToOnePlaceAndToALine) {
  const std::vector<std::vector<Vec3f>> clouds{
      {{1, 2, 3}},
      {{1, 2, 3}, {2, 3, 4}},
      std::vector<Vec3f>(16, Vec3f{1, 2, 3}),
      {{0, 0, 0}, {1, 2, 3}, {2, 4, 6}, {3, 6, 9}, {4, 8, 12}},
  };
  for (const auto& cloud : clouds) {
    const PlaneFit fit = Around(cloud).fit();
    EXPECT_EQ(fit.normal, Vec3f{}) << "of " << cloud.size() << " points";
    EXPECT_EQ(fit.quality, 0.0f);
  }
}

TEST(FitPlane, TakesTheQualityFromTheEigenvaluesAndTheDistanceOfThePoint) {
  // A symmetric cross of arms 2, 1 and 0.1 around the first point: the covariance is diagonal,
  // eigenvalues 2 a^2 / 7, and the point lies on the plane.
  const PlaneFit on =
      Around({{0, 0, 0}, {2, 0, 0}, {-2, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 0.1f}, {0, 0, -0.1f}})
          .fit();
  EXPECT_NEAR(on.quality, 1.0 - 0.01, 1e-5);
  EXPECT_NEAR(on.spread_m, 0.1 * std::sqrt(2.0 / 7.0), 1e-6);
  // A square with the point 0.3 m above its middle: mean height 0.24 m below the point.
  const PlaneFit off = Around({{0, 0, 0.3f}, {1, 1, 0}, {1, -1, 0}, {-1, 1, 0}, {-1, -1, 0}}).fit();
  const double l0 = 0.3 * 0.3 * 0.2 * 0.8, l1 = 0.8;
  EXPECT_NEAR(off.quality, (1.0 - l0 / l1) * (1.0 - 3.0 * 0.24 * 0.24 / l1), 1e-5);
}

TEST(FitPlane, AgreesWithPclOnNoisyPatches) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const std::vector<Vec3f> points = noisy_patch(16, 0.05, seed);
    pcl::PointCloud<pcl::PointXYZ> cloud;
    for (const Vec3f& p : points) {
      cloud.push_back({p.x - points[0].x, p.y - points[0].y, p.z - points[0].z});
    }
    Eigen::Vector4f plane;
    float curvature = 0.0f;
    ASSERT_TRUE(pcl::computePointNormal(cloud, plane, curvature));
    const PlaneFit fit = Around(points).fit();
    const float cosine =
        fit.normal.x * plane[0] + fit.normal.y * plane[1] + fit.normal.z * plane[2];
    EXPECT_GT(std::abs(cosine), 1.0f - 1e-5f) << "seed " << seed;
  }
}

TEST(FitPlane, DoesNotLoseTheNormalFarFromTheOrigin) {
  std::vector<Vec3f> near = noisy_patch(16, 0.03, 1);
  for (Vec3f& p : near) p -= Vec3f{900, 400, 0};
  const PlaneFit far_fit = Around(noisy_patch(16, 0.03, 1)).fit(), near_fit = Around(near).fit();
  EXPECT_GT(dot(far_fit.normal, near_fit.normal), 1.0f - 1e-6f);
}

}  // namespace
}  // namespace cornice::normals
