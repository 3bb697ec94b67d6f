// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/viewpoint.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace cornice::viewer {
namespace {

constexpr int kWidth = 1200, kHeight = 750;
constexpr double kShape = double(kWidth) / kHeight;

/// Triangles of 5 m of ground of 1000 m.
std::vector<Facet> ground(const std::function<double(double x, double y)>& height) {
  constexpr double kStep = 5.0;
  std::vector<Facet> facets;
  const auto at = [&](double x, double y) {
    return Vec3d{2'600'000.0 + x, 1'200'000.0 + y, height(x, y)};
  };
  const auto add = [&](Vec3d a, Vec3d b, Vec3d c) {
    const Vec3d twice = cross(b - a, c - a);
    facets.push_back({(a + b + c) / 3.0, normalized(twice), 0.5 * norm(twice)});
  };
  for (double y = 0.0; y < 1000.0; y += kStep) {
    for (double x = 0.0; x < 1000.0; x += kStep) {
      add(at(x, y), at(x + kStep, y), at(x + kStep, y + kStep));
      add(at(x, y), at(x + kStep, y + kStep), at(x, y + kStep));
    }
  }
  return facets;
}

/// A wall of 150 m that faces west at x = 600.
double wall(double x, double y) {
  const double share = std::clamp((x - 590.0) / 20.0, 0.0, 1.0);
  return 1000.0 + 150.0 * share + 5.0 * std::sin(0.03 * x) * std::sin(0.02 * y);
}

/// Where the middle of the picture meets the ground first; the eye's own place where that is in the
/// ground, or where there is none within 2 km.
Vec3d first_hit(const Camera& camera, const std::function<double(double x, double y)>& height) {
  const CameraAxes axes = axes_of(camera);
  for (double t = 0.0; t < 2000.0; t += 1.0) {
    const Vec3d p = camera.eye + t * axes.forward;
    if (p.z < height(p.x - 2'600'000.0, p.y - 1'200'000.0)) return p;
  }
  return camera.eye;
}

void expect_in_picture(const Camera& camera, const std::vector<Facet>& facets) {
  for (const Facet& facet : facets) {
    const auto pixel = pixel_of_point(camera, kWidth, kHeight, facet.centre);
    ASSERT_TRUE(pixel);
    ASSERT_TRUE(pixel->x >= 0.0 && pixel->x < kWidth && pixel->y >= 0.0 && pixel->y < kHeight);
  }
}

TEST(Fitted, TouchesTheMarginsAndNoMore) {
  const auto facets = ground(wall);
  std::vector<Vec3d> points;
  for (const Facet& facet : facets) points.push_back(facet.centre);
  for (const double heading : {0.0, 77.0, 200.0}) {
    for (const double pitch : {-10.0, -45.0, -89.0}) {
      const Camera camera = fitted({{}, heading, pitch, 40.0}, points, kShape, 0.05);
      double left = kWidth, right = 0.0, top = kHeight, bottom = 0.0;
      for (const Vec3d& point : points) {
        const auto pixel = pixel_of_point(camera, kWidth, kHeight, point);
        ASSERT_TRUE(pixel);
        left = std::min(left, pixel->x);
        right = std::max(right, pixel->x);
        top = std::min(top, pixel->y);
        bottom = std::max(bottom, pixel->y);
      }
      const double x_margin = 0.05 * kWidth - 1.0, y_margin = 0.05 * kHeight - 1.0;
      EXPECT_GE(left, x_margin);
      EXPECT_LE(right, kWidth - x_margin);
      EXPECT_GE(top, y_margin);
      EXPECT_LE(bottom, kHeight - y_margin);
      EXPECT_TRUE(left < x_margin + 3.0 || top < y_margin + 3.0) << "fills neither way";
      EXPECT_NEAR(std::min(left - x_margin, top - y_margin),
                  std::min(kWidth - x_margin - right, kHeight - y_margin - bottom), 3.0);
    }
  }
}

TEST(Overview, SeesAllOfTheGroundFromWhereItsSlopeFacesTheEye) {
  // Falls to the east: seen from there, looking west.
  const auto facets = ground([](double x, double) { return 2000.0 - 0.6 * x; });
  const Camera camera = overview(facets, kShape);
  EXPECT_NEAR(camera.heading_deg, 270.0, 31.0);
  EXPECT_LE(camera.pitch_deg, -15.0);
  EXPECT_GE(camera.pitch_deg, -60.0);
  expect_in_picture(camera, facets);
}

TEST(Overview, LooksDownMoreSteeplyOnFlatGround) {
  const auto steep = ground([](double x, double y) { return 1000.0 + 0.4 * x + 0.2 * y; });
  const auto flat = ground([](double x, double) { return 1000.0 + 0.01 * x; });
  EXPECT_LT(overview(flat, kShape).pitch_deg, overview(steep, kShape).pitch_deg - 5.0);
}

TEST(SteepestView, LooksAtTheWallFromItsFrontWithNothingBetween) {
  const Camera camera = steepest_view(ground(wall), kShape);
  EXPECT_NEAR(camera.heading_deg, 90.0, 10.0) << "the wall faces west";
  const Vec3d hit = first_hit(camera, wall);
  EXPECT_NEAR(hit.x, 2'600'600.0, 12.0);
  EXPECT_GT(norm(hit - camera.eye), 50.0);
  EXPECT_LT(norm(hit - camera.eye), 600.0) << "is a close view";
}

TEST(SteepestView, LooksOverARidgeInFrontOfTheWall) {
  // Gentle enough, 40 degrees at most, not to be the steepest part itself.
  const auto ridged = [](double x, double y) {
    return wall(x, y) + 90.0 * std::exp(-std::pow((x - 460.0) / 70.0, 2.0));
  };
  const Camera camera = steepest_view(ground(ridged), kShape);
  EXPECT_NEAR(camera.heading_deg, 90.0, 10.0);
  EXPECT_LT(camera.pitch_deg, steepest_view(ground(wall), kShape).pitch_deg);
  EXPECT_NEAR(first_hit(camera, ridged).x, 2'600'600.0, 30.0) << "not the ridge";
}

TEST(SteepestView, OfAWallAtTheEdgeOfTheSurveyHasGroundInTheForeground) {
  // Falls to the west, and ends 30 m beyond its foot.
  const auto edge = [](double x, double y) {
    return 1000.0 + 150.0 * std::clamp((x - 30.0) / 60.0, 0.0, 1.0) + 0.01 * y;
  };
  const Camera camera = steepest_view(ground(edge), kShape);
  const CameraAxes axes = axes_of(camera);
  const double up = std::tan(0.5 * camera.field_of_view_deg * std::numbers::pi / 180.0);
  int ground_seen = 0, rays = 0;
  for (double y = -0.95; y < 0.0; y += 0.1) {
    for (double x = -0.95; x < 1.0; x += 0.1) {
      const Vec3d way = axes.forward + up * kShape * x * axes.right + up * y * axes.up;
      ++rays;
      for (double t = 0.0; t < 2000.0; t += 2.0) {
        const Vec3d p = camera.eye + t * way - Vec3d{2'600'000.0, 1'200'000.0, 0.0};
        if (p.x < 0.0 || p.y < 0.0 || p.x > 1000.0 || p.y > 1000.0 || p.z > edge(p.x, p.y))
          continue;
        ++ground_seen;
        break;
      }
    }
  }
  EXPECT_GE(ground_seen, 0.8 * rays);
  EXPECT_GT(camera.pitch_deg, -70.0) << "shows no wall";
  EXPECT_LT(std::abs(camera.heading_deg - 90.0), 75.0) << "sees its front";
}

TEST(Viewpoints, AreFoundOfASingleTriangle) {
  const std::vector<Facet> one{{{1.0, 2.0, 3.0}, {0.0, 0.0, 1.0}, 1.0}};
  for (const Camera& camera : {overview(one, kShape), steepest_view(one, kShape)}) {
    EXPECT_TRUE(std::isfinite(camera.eye.x + camera.eye.y + camera.eye.z));
    EXPECT_TRUE(pixel_of_point(camera, kWidth, kHeight, one.front().centre));
  }
}

TEST(SunForPictures, StandsOnTheViewersLeft) {
  EXPECT_DOUBLE_EQ(sun_azimuth_for({{}, 0.0, -30.0, 45.0}), 240.0);
  EXPECT_DOUBLE_EQ(sun_azimuth_for({{}, 200.0, -30.0, 45.0}), 80.0);
}

}  // namespace
}  // namespace cornice::viewer
