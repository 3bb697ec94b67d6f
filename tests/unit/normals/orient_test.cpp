// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/orient.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "stages/normals/propagate.h"
#include "tests/unit/normals/shapes.h"

namespace cornice::normals {
namespace {

using test::add_blade;
using test::add_patch;
using test::Indexed;
using test::Shape;
using test::wrong_share;

constexpr Vec3d kAbove{0, 0, 1500};

OrientedNormals orient(const Indexed& data, int threads = 2) {
  OrientOptions options;
  options.threads = threads;
  return orient_normals(data.tree, data.beams(), options);
}

std::size_t count(const OrientedNormals& normals, SettledBy by) {
  return normals.counts[static_cast<std::size_t>(by)];
}

TEST(OrientNormals, TurnsRollingGroundUp) {
  const Indexed data(test::rolling_ground(20000, 30.0));
  const OrientedNormals oriented = orient(data);
  EXPECT_EQ(wrong_share(data.shape, oriented), 0.0);
  EXPECT_EQ(count(oriented, SettledBy::kBeams), data.shape.positions.size());
}

TEST(OrientNormals, TurnsTheUndersideOfAnOverhangDown) {
  Shape shape;
  // Leans 20 degrees outwards over +x; seen from the side, 35 degrees off the vertical.
  add_patch(shape, {0, 0, 0}, {0, 20, 0}, {7.28, 0, 20}, {20, 0, -7.28}, 15, 0.03, {1050, 10, 1500},
            1);
  const Indexed data(shape);
  EXPECT_EQ(wrong_share(data.shape, orient(data)), 0.0);
}

TEST(OrientNormals, SettlesAWallThatOneLineGrazesByTheBeamsOfAnother) {
  Shape shape;
  add_patch(shape, {0, 0, 0}, {0, 20, 0}, {0, 0, 20}, {1, 0, 0}, 10, 0.03, {2, 10, 1500}, 1);
  add_patch(shape, {0, 0, 0}, {0, 20, 0}, {0, 0, 20}, {1, 0, 0}, 10, 0.03, {900, 10, 1500}, 2);
  const Indexed data(shape);
  const OrientedNormals oriented = orient(data);
  EXPECT_LT(wrong_share(data.shape, oriented), 0.001);
  // The grazing half alone would leave most of the wall in doubt.
  Shape grazed;
  add_patch(grazed, {0, 0, 0}, {0, 20, 0}, {0, 0, 20}, {1, 0, 0}, 20, 0.03, {2, 10, 1500}, 1);
  EXPECT_LT(count(orient(Indexed(grazed)), SettledBy::kBeams), shape.positions.size() / 10);
}

TEST(OrientNormals, TellsTheFacesOfABladeThinnerThanANeighbourhoodApart) {
  for (const double thickness_m : {1.2, 1.6}) {
    Shape shape;
    add_blade(shape, thickness_m, 5.0);
    const Indexed data(shape);
    const OrientedNormals oriented = orient(data);
    EXPECT_LT(wrong_share(data.shape, oriented), 0.005) << thickness_m;
    std::size_t off = 0;
    for (std::size_t i = 0; i < oriented.normals.size(); ++i) {
      off += dot(oriented.normals[i], data.shape.normals[i]) < std::cos(0.35f) ? 1 : 0;
    }
    EXPECT_LT(off, oriented.normals.size() / 50) << thickness_m;
  }
}

TEST(OrientNormals, CarriesTheSideFromAPlateauOverTheEdgeDownAGrazedWall) {
  Shape shape;
  add_patch(shape, {-10, 0, 20}, {10, 0, 0}, {0, 20, 0}, {0, 0, 1}, 20, 0.02, kAbove, 1);
  const double pi = 3.14159265358979;
  for (int i = 0; i < 4000; ++i) {  // A rounded edge of radius 2 m.
    CounterRandom random(5, 0, static_cast<std::uint64_t>(i));
    const double a = random.uniform(0, pi / 2);
    const Vec3d n{std::sin(a), 0, std::cos(a)};
    const Vec3d p = Vec3d{0, random.uniform(0, 20), 18} + n * 2.0;
    shape.add(p, n, p - kAbove);
  }
  // Beams straight down the wall say nothing.
  for (int i = 0; i < 6000; ++i) {
    CounterRandom random(6, 0, static_cast<std::uint64_t>(i));
    shape.add({2.0 + 0.01 * random.normal(), random.uniform(0, 20), random.uniform(0, 18)},
              {1, 0, 0}, {0, 0, -1});
  }
  const Indexed data(shape);
  const OrientedNormals oriented = orient(data);
  EXPECT_LT(wrong_share(data.shape, oriented), 0.001);
  EXPECT_GT(count(oriented, SettledBy::kPropagation), 4000u);
}

TEST(OrientNormals, LeavesAWallAloneUnsettledWhereBeamsRunAlongIt) {
  Shape shape;
  for (int i = 0; i < 500; ++i) {
    CounterRandom random(7, 0, static_cast<std::uint64_t>(i));
    shape.add({0.0, random.uniform(0, 5), random.uniform(0, 5)}, {1, 0, 0}, {0, 0, -1});
  }
  const OrientedNormals oriented = orient(Indexed(shape));
  EXPECT_EQ(count(oriented, SettledBy::kNothing), 500u);
}

TEST(OrientNormals, DoesNotTrustAVerticalBeamOnASteepFace) {
  // The face leans back by 20 degrees; a vertical guess may be 30 degrees off the true beam.
  Shape shape;
  add_patch(shape, {0, 0, 0}, {0, 10, 0}, {-3.64, 0, 10}, {10, 0, 3.64}, 15, 0.01, kAbove, 1,
            BeamSource::kVertical);
  const OrientedNormals doubtful = orient(Indexed(shape));
  EXPECT_EQ(count(doubtful, SettledBy::kBeams), 0u);
  std::fill(shape.sources.begin(), shape.sources.end(), BeamSource::kTrajectory);
  EXPECT_GT(count(orient(Indexed(shape)), SettledBy::kBeams), shape.positions.size() / 2);
}

TEST(OrientNormals, GivesNoPlaneToPointsOnALineAndToTooFew) {
  Shape line;
  for (int i = 0; i < 50; ++i) line.add({i * 0.5, i * 0.25, 0.0}, {0, 0, 1}, {0, 0, -1});
  EXPECT_EQ(count(orient(Indexed(line)), SettledBy::kNoPlane), 50u);
  Shape two;
  two.add({0, 0, 0}, {0, 0, 1}, {0, 0, -1});
  two.add({1, 0, 0}, {0, 0, 1}, {0, 0, -1});
  EXPECT_EQ(count(orient(Indexed(two)), SettledBy::kNoPlane), 2u);
  EXPECT_TRUE(orient(Indexed(Shape{})).normals.empty());
}

TEST(OrientNormals, SettlesThreePointsOfAPlane) {
  Shape three;
  three.add({0, 0, 0}, {0, 0, 1}, {0, 0, -1});
  three.add({1, 0, 0}, {0, 0, 1}, {0, 0, -1});
  three.add({0, 1, 0}, {0, 0, 1}, {0, 0, -1});
  const Indexed data(three);
  EXPECT_EQ(wrong_share(data.shape, orient(data)), 0.0);
}

TEST(OrientNormals, LooksBeyondPointsThatLieCloserTogetherThanTheyAreExact) {
  // As where a mirror turns: rows of points a centimetre apart, 0.7 m from row to row.
  Shape shape;
  for (int row = 0; row < 12; ++row) {
    for (int i = 0; i < 80; ++i) {
      CounterRandom random(8, static_cast<std::uint64_t>(row), static_cast<std::uint64_t>(i));
      const double x = 0.4 * random.uniform(), y = 0.7 * row + 0.02 * random.normal();
      shape.add({x, y, 0.03 * random.normal()}, {0, 0, 1}, {0.1, 0.2, -1.0});
    }
  }
  const Indexed data(shape);
  const auto tilted_share = [&](float breadth_m) {
    OrientOptions options;
    options.least_breadth_m = breadth_m;
    const OrientedNormals oriented = orient_normals(data.tree, data.beams(), options);
    const auto tilted = std::count_if(oriented.normals.begin(), oriented.normals.end(),
                                      [](Vec3f n) { return std::abs(n.z) < 0.9f; });
    return static_cast<double>(tilted) / static_cast<double>(shape.positions.size());
  };
  EXPECT_LT(tilted_share(OrientOptions{}.least_breadth_m), 0.01);
  EXPECT_GT(tilted_share(0.0f), 0.3);
}

TEST(OrientNormals, GivesTheSameBytesWithOneAndTwoThreads) {
  Shape shape = test::rolling_ground(30000, 40.0);
  add_patch(shape, {0, 0, 0}, {0, 20, 0}, {0, 0, 20}, {1, 0, 0}, 20, 0.05, {2, 10, 1500}, 3);
  const Indexed data(shape);
  const OrientedNormals one = orient(data, 1), two = orient(data, 2);
  EXPECT_EQ(one.normals, two.normals);
  EXPECT_EQ(one.quality, two.quality);
  EXPECT_EQ(one.settled_by, two.settled_by);
  EXPECT_GT(count(one, SettledBy::kPropagation), 0u);
}

TEST(Agreement, IsOneAlongACircleAndAcrossAThinWall) {
  const Vec3f up{0, 0, 1}, down{0, 0, -1};
  EXPECT_FLOAT_EQ(agreement(up, up, {1, 0, 0}), 1.0f);
  const Vec3f a{0, 0, 1}, b = normalized(Vec3f{1, 0, 1});
  EXPECT_FLOAT_EQ(agreement(a, b, b - a), 1.0f);
  EXPECT_FLOAT_EQ(agreement(up, down, {0, 0, -0.2f}), 1.0f);
  EXPECT_FLOAT_EQ(agreement(up, down, {1, 0, 0}), -1.0f);
  EXPECT_FLOAT_EQ(agreement(up, down, {0, 0, 0}), -1.0f);
}

}  // namespace
}  // namespace cornice::normals
