// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/normals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "stages/normals/beams.h"
#include "tests/unit/normals/shapes.h"

namespace cornice::normals {
namespace {

using test::Indexed;
using test::Shape;

constexpr double kTime = 1000.0;

/// A cloud of ground points, all of line 7, at one time.
PointCloud cloud_of(const std::vector<Vec3f>& positions) {
  PointCloud points;
  points.origin = {2600000, 1200000, 0};
  points.positions = positions;
  const std::size_t n = positions.size();
  points.gps_time_s.assign(n, kTime);
  points.scan_angle_deg.assign(n, 0.0f);
  points.classification.assign(n, 2);
  points.flags.assign(n, 0);
  points.point_source_id.assign(n, 7);
  points.scanner_channel.assign(n, 0);
  points.user_data.assign(n, 0);
  points.intensity.assign(n, 100);
  return points;
}

/// Line 7, flown 1500 m above the middle of the cloud.
FlightLines one_line() {
  FlightLine line;
  line.id = 3;
  line.point_source_id = 7;
  line.first_time_s = 990;
  line.last_time_s = 1010;
  line.scan_angle_sign = 1;
  line.across_azimuth_deg = 90.0;
  line.beam_source = BeamSource::kTrajectory;
  line.nodes = {{990.0, {2600010, 1199300, 1500}, {}, false},
                {1010.0, {2600010, 1200700, 1500}, {}, false}};
  return {"", {line}};
}

Result compute(PointCloud points, const FlightLines& lines, const Options& options = {}) {
  const std::size_t n = points.size();
  return compute_normals(std::move(points), n, lines, built_in_rules("any"), options);
}

void expect_same(const Result& a, const Result& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(a.quality, b.quality);
  EXPECT_EQ(a.line_id, b.line_id);
}

TEST(ComputeNormals, KeepsLineClassAndIntensityWithTheirPoints) {
  PointCloud points = cloud_of(test::rolling_ground(3000, 12.0).positions);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points.intensity[i] = static_cast<std::uint16_t>(i);
    points.classification[i] = i % 2 == 0 ? 2 : 6;
  }
  Options options;
  options.keep_source = true;
  const Result result = compute(points, one_line(), options);
  ASSERT_EQ(result.positions.size(), 3000u);
  std::set<std::uint32_t> seen;
  for (std::size_t r = 0; r < result.positions.size(); ++r) {
    const std::uint32_t i = result.source[r];
    seen.insert(i);
    ASSERT_EQ(result.positions[r], points.positions[i]);
    ASSERT_EQ(result.intensity[r], i);
    ASSERT_EQ(result.classification[r], i % 2 == 0 ? 2 : 6);
    ASSERT_EQ(result.line_id[r], 3u);
    ASSERT_GT(result.normals[r].z, 0.0f);
  }
  EXPECT_EQ(seen.size(), 3000u);
  EXPECT_EQ(result.counts.beams_by_source[0], 3000u);
}

TEST(ComputeNormals, GivesTheSameBytesWithOneAndTwoThreads) {
  const PointCloud points = cloud_of(test::rolling_ground(300000, 120.0).positions);
  Options one, two;
  one.threads = 1;
  two.threads = 2;
  expect_same(compute(points, one_line(), one), compute(points, one_line(), two));
}

TEST(ComputeNormals, DoesNotDependOnTheOrderOfThePoints) {
  Shape ground = test::rolling_ground(5000, 16.0);
  const Result forward = compute(cloud_of(ground.positions), one_line());
  std::reverse(ground.positions.begin(), ground.positions.end());
  expect_same(forward, compute(cloud_of(ground.positions), one_line()));
}

TEST(ComputeNormals, ComesToAnEndOnNoPointsOnePointAndThree) {
  EXPECT_EQ(compute(cloud_of({}), one_line()).counts.put_out, 0u);
  Options options;
  options.isolated.method = IsolatedOptions::Method::kNone;
  const Result one = compute(cloud_of({{1, 2, 3}}), one_line(), options);
  EXPECT_EQ(one.counts.settled_by[static_cast<std::size_t>(SettledBy::kNoPlane)], 1u);
  EXPECT_EQ(one.counts.put_out, 0u);
  const Result three = compute(cloud_of({{1, 2, 3}, {2, 2, 3}, {1, 3, 3}}), one_line(), options);
  EXPECT_EQ(three.counts.put_out, 3u);
  EXPECT_EQ(compute(cloud_of({{1, 2, 3}, {2, 2, 3}}), one_line()).counts.isolated, 2u);
}

TEST(ComputeNormals, CountsAMillionPointsAtOnePlaceAsDuplicates) {
  std::vector<Vec3f> positions = test::rolling_ground(500, 5.0).positions;
  positions.insert(positions.begin(), 1000000, Vec3f{2.0f, 2.0f, 0.5f});
  const Result result = compute(cloud_of(positions), one_line());
  EXPECT_EQ(result.counts.duplicates, 999999u);
  EXPECT_EQ(result.counts.put_out + result.counts.isolated, 501u);
  EXPECT_EQ(compute(cloud_of(std::vector<Vec3f>(1000000, Vec3f{})), one_line()).counts.isolated,
            1u);
}

TEST(ComputeNormals, CountsPointsOnALineAsWithoutPlane) {
  std::vector<Vec3f> line;
  for (int i = 0; i < 200; ++i) line.push_back({0.25f * static_cast<float>(i), 0, 0});
  const Result result = compute(cloud_of(line), one_line());
  EXPECT_EQ(result.counts.settled_by[static_cast<std::size_t>(SettledBy::kNoPlane)], 200u);
  EXPECT_EQ(result.counts.put_out, 0u);
}

TEST(ComputeNormals, CountsPointsWithoutAFlightLineAndTakesTheirBeamsAsVertical) {
  PointCloud points = cloud_of(test::rolling_ground(2000, 10.0).positions);
  for (std::size_t i = 0; i < 500; ++i) points.gps_time_s[i] = 5e5;
  for (std::size_t i = 500; i < 700; ++i) points.point_source_id[i] = 8;
  const Result result = compute(points, one_line());
  EXPECT_EQ(result.counts.without_line, 700u);
  EXPECT_EQ(result.counts.beams_by_source[2], 700u);
  EXPECT_EQ(result.counts.put_out, 2000u);
  const Result none = compute(points, FlightLines{});
  EXPECT_EQ(none.counts.without_line, 2000u);
  for (const Vec3f& n : none.normals) ASSERT_GT(n.z, 0.0f);
}

TEST(ComputeNormals, RemovesPointsAloneInTheAir) {
  std::vector<Vec3f> positions = test::rolling_ground(3000, 12.0).positions;
  positions.push_back({6, 6, 40});
  positions.push_back({3, 3, 70});
  positions.push_back({3, 3.5f, 70});
  Options options;
  EXPECT_EQ(compute(cloud_of(positions), one_line(), options).counts.isolated, 3u);
  options.isolated.method = IsolatedOptions::Method::kStatistical;
  EXPECT_EQ(compute(cloud_of(positions), one_line(), options).counts.isolated, 3u);
  options.isolated.method = IsolatedOptions::Method::kNone;
  EXPECT_EQ(compute(cloud_of(positions), one_line(), options).counts.isolated, 0u);
}

TEST(FindIsolated, AgreesWithCountingAllPointsWithinTheRadius) {
  Shape sparse = test::rolling_ground(600, 60.0);
  for (const Vec3f& p : test::rolling_ground(300, 8.0, 2).positions) {
    sparse.add(p.cast<double>(), {0, 0, 1}, {0, 0, -1});
  }
  const Indexed data(sparse);
  for (const double radius_m : {1.0, 2.5, 4.0}) {
    IsolatedOptions options;
    options.radius_m = radius_m;
    options.neighbours = 3;
    const std::vector<std::uint8_t> isolated = find_isolated(data.tree, options);
    for (std::size_t i = 0; i < isolated.size(); ++i) {
      const auto within = std::count_if(
          data.shape.positions.begin(), data.shape.positions.end(),
          [&](Vec3f p) { return norm((p - data.shape.positions[i]).cast<double>()) <= radius_m; });
      ASSERT_EQ(isolated[i] != 0, within <= 3) << "point " << i << ", radius " << radius_m;
    }
  }
}

TEST(ComputeNormals, GivesPointsAtTheBorderTheNormalsOfTheWholeWhereThereIsAHalo) {
  const std::vector<Vec3f> ground = test::rolling_ground(40000, 40.0).positions;
  std::vector<Vec3f> tile, halo;
  for (const Vec3f& p : ground) {
    if (p.x < 20.0f) {
      tile.push_back(p);
    } else if (p.x < 25.0f) {
      halo.push_back(p);
    }
  }
  const std::size_t own = tile.size();
  tile.insert(tile.end(), halo.begin(), halo.end());
  const Result part =
      compute_normals(cloud_of(tile), own, one_line(), built_in_rules("any"), Options{});
  EXPECT_EQ(part.counts.halo, halo.size());
  ASSERT_EQ(part.counts.put_out, own);
  const Result whole = compute(cloud_of(ground), one_line());
  std::map<std::tuple<float, float, float>, Vec3f> expected;
  for (std::size_t i = 0; i < whole.positions.size(); ++i) {
    const Vec3f p = whole.positions[i];
    expected[{p.x, p.y, p.z}] = whole.normals[i];
  }
  for (std::size_t i = 0; i < part.positions.size(); ++i) {
    const Vec3f p = part.positions[i];
    ASSERT_GT(dot(part.normals[i], expected.at({p.x, p.y, p.z})), 1.0f - 1e-5f);
  }
  Options keep;
  keep.keep_halo = true;
  const Result both = compute_normals(cloud_of(tile), own, one_line(), built_in_rules("any"), keep);
  EXPECT_EQ(both.counts.put_out, tile.size());
  EXPECT_EQ(static_cast<std::size_t>(std::count(both.halo.begin(), both.halo.end(), 1)),
            halo.size());
}

TEST(ComputeNormals, KeepsTheTilesOwnPointWhereANeighbourHasItToo) {
  const std::vector<Vec3f> ground = test::rolling_ground(1000, 7.0).positions;
  std::vector<Vec3f> doubled = ground;
  doubled.insert(doubled.end(), ground.begin(), ground.end());
  const Result result =
      compute_normals(cloud_of(doubled), 1000, one_line(), built_in_rules("any"), Options{});
  EXPECT_EQ(result.counts.duplicates, 1000u);
  EXPECT_EQ(result.counts.put_out, 1000u);
}

TEST(FindBeams, StepsDownFromTrajectoryToAnglesToVerticalAndCountsEach) {
  PointCloud points = cloud_of({{10, 0, 0}, {10, 0, 0}, {10, 0, 0}, {10, 0, 0}});
  FlightLines lines = one_line();
  FlightLine angles = lines.lines[0];
  angles.id = 4;
  angles.point_source_id = 8;
  angles.beam_source = BeamSource::kAngles;
  angles.nodes.clear();
  FlightLine vertical = angles;
  vertical.id = 5;
  vertical.point_source_id = 9;
  vertical.beam_source = BeamSource::kVertical;
  lines.lines.push_back(angles);
  lines.lines.push_back(vertical);
  points.point_source_id = {7, 8, 9, 10};
  points.scan_angle_deg = {30, 30, 30, 30};
  const PointBeams found = find_beams(points, lines, BeamSource::kTrajectory, 2);
  EXPECT_EQ(found.by_source, (std::array<std::size_t, 3>{1, 1, 2}));
  EXPECT_EQ(found.without_line, 1u);
  EXPECT_EQ(found.line_id, (std::vector<std::uint16_t>{3, 4, 5, 0}));
  EXPECT_NEAR(found.beams.direction[0].z, -1.0f, 1e-5f);
  EXPECT_NEAR(found.beams.direction[1].x, 0.5f, 1e-5f);
  EXPECT_EQ(found.beams.direction[2], (Vec3f{0, 0, -1}));
  EXPECT_EQ(find_beams(points, lines, BeamSource::kAngles, 1).by_source,
            (std::array<std::size_t, 3>{0, 2, 2}));
  EXPECT_EQ(find_beams(points, lines, BeamSource::kVertical, 1).by_source,
            (std::array<std::size_t, 3>{0, 0, 4}));
}

}  // namespace
}  // namespace cornice::normals
