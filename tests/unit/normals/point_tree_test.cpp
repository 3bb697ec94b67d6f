// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <flann/flann.hpp>
#include <limits>
#include <mutex>
#include <numeric>

#include "stages/normals/leaf_search.h"
#include "tests/unit/normals/shapes.h"

namespace cornice::normals {
namespace {

using test::Indexed;
using test::Shape;

float distance_sq(Vec3f a, Vec3f b) {
  const Vec3f d = b - a;
  return d.x * d.x + d.y * d.y + d.z * d.z;
}

/// Indices of the nearest `k` by brute force: by distance, then by index; ascending.
std::vector<std::uint32_t> nearest(std::span<const Vec3f> points, std::size_t i, std::size_t k) {
  std::vector<std::uint32_t> index(points.size());
  std::iota(index.begin(), index.end(), 0u);
  std::sort(index.begin(), index.end(), [&](std::uint32_t a, std::uint32_t b) {
    const float da = distance_sq(points[i], points[a]), db = distance_sq(points[i], points[b]);
    return da != db ? da < db : a < b;
  });
  index.resize(std::min(k, index.size()));
  std::sort(index.begin(), index.end());
  return index;
}

void expect_nearest(const Indexed& data, std::uint32_t k) {
  std::mutex mutex;
  std::size_t visited = 0;
  for_each_neighbourhood(
      data.tree, {k, k, 0.0f}, 2, {}, [&](std::uint32_t i, const Neighbourhood& found) {
        const std::vector<std::uint32_t> got(found.index, found.index + found.size);
        const std::lock_guard lock(mutex);
        ++visited;
        ASSERT_EQ(got, nearest(data.shape.positions, i, k)) << "of point " << i;
        for (std::uint32_t c = 0; c < found.size; ++c) {
          ASSERT_EQ(found.dx[c], data.shape.positions[got[c]].x - data.shape.positions[i].x);
        }
      });
  EXPECT_EQ(visited, data.shape.positions.size());
}

Shape at(const std::vector<Vec3d>& positions) {
  Shape shape;
  for (const Vec3d p : positions) shape.add(p, {0, 0, 1}, {0, 0, -1});
  return shape;
}

TEST(PointTree, FindsTheNearestPointsOnRollingGround) {
  expect_nearest(Indexed(test::rolling_ground(1500, 10.0)), 16);
}

TEST(PointTree, FindsTheNearestPointsWhateverTheCount) {
  for (const std::uint32_t k : {1u, 2u, 5u, 64u}) {
    expect_nearest(Indexed(test::rolling_ground(400, 5.0)), k);
  }
}

TEST(PointTree, FindsTheNearestPointsWhereDensityJumpsAThousandfold) {
  Shape shape = test::rolling_ground(500, 100.0);
  for (const Vec3f& p : test::rolling_ground(500, 0.1, 9).positions) {
    shape.add(p.cast<double>() + Vec3d{50, 50, 0}, {0, 0, 1}, {0, 0, -1});
  }
  shape.add({1e5, -1e5, 3.0}, {0, 0, 1}, {0, 0, -1});
  expect_nearest(Indexed(shape), 16);
}

TEST(PointTree, CountsLowerIndicesAsNearerAmongEqualDistances) {
  std::vector<Vec3d> grid;
  for (int x = 0; x < 12; ++x) {
    for (int y = 0; y < 12; ++y) grid.push_back({x * 0.5, y * 0.5, 0.0});
  }
  expect_nearest(Indexed(at(grid)), 7);
}

TEST(PointTree, FindsNeighboursAmongPointsOnOneLineAndInOneColumn) {
  std::vector<Vec3d> line, column;
  for (int i = 0; i < 100; ++i) {
    line.push_back({i * 0.3, i * 0.6, 0.0});
    column.push_back({5.0, 5.0, i * 0.1});
  }
  expect_nearest(Indexed(at(line)), 8);
  expect_nearest(Indexed(at(column)), 8);
}

TEST(PointTree, GivesAllPointsWhereThereAreFewerThanAskedFor) {
  expect_nearest(Indexed(at({{1, 2, 3}})), 16);
  expect_nearest(Indexed(at({{1, 2, 3}, {1, 2, 4}, {500, 2, 3}})), 16);
}

TEST(PointTree, VisitsNothingOfAnEmptyCloud) {
  const Indexed data{Shape{}};
  for_each_neighbourhood(data.tree, {}, 2, {},
                         [](std::uint32_t, const Neighbourhood&) { FAIL() << "a point of none"; });
}

TEST(PointTree, FindsAllPointsWithinARadius) {
  const Indexed data(test::rolling_ground(1500, 10.0));
  const NeighbourRule within{1, std::numeric_limits<std::uint32_t>::max(), 0.7f};
  for_each_neighbourhood(
      data.tree, within, 1, {}, [&](std::uint32_t i, const Neighbourhood& found) {
        const auto expected = std::count_if(
            data.shape.positions.begin(), data.shape.positions.end(),
            [&](Vec3f p) { return distance_sq(p, data.shape.positions[i]) <= 0.7f * 0.7f; });
        ASSERT_EQ(found.size, expected) << "of point " << i;
        ASSERT_LE(found.reach_sq, 0.7f * 0.7f);
      });
}

TEST(PointTree, KeepsTheCountWithinItsBoundsWhereItFollowsTheDensity) {
  const Indexed data(test::rolling_ground(1500, 10.0));
  std::uint32_t least = 1000, most = 0;
  for_each_neighbourhood(data.tree, {8, 32, 0.8f}, 1, {},
                         [&](std::uint32_t, const Neighbourhood& found) {
                           least = std::min(least, found.size);
                           most = std::max(most, found.size);
                         });
  EXPECT_EQ(least, 8u);
  EXPECT_GT(most, 20u);
  EXPECT_LE(most, 32u);
}

TEST(PointTree, FindsTwiceAsManyNeighboursWhereAskedTo) {
  const Indexed data(test::rolling_ground(800, 8.0));
  LeafSearch search(data.tree, {8, 8, 0.0f});
  for (const std::uint32_t leaf : data.tree.leaves()) {
    for (const std::uint32_t factor : {2u, 1u, 16u}) {
      search.open(leaf, factor);
      for (std::uint32_t i = data.tree.nodes()[leaf].begin; i < data.tree.nodes()[leaf].end; ++i) {
        const Neighbourhood found = search.find(i);
        const std::vector<std::uint32_t> got(found.index, found.index + found.size);
        ASSERT_EQ(got, nearest(data.shape.positions, i, 8 * factor)) << "of point " << i;
      }
    }
  }
}

TEST(PointTree, AgreesWithFlannOnDistances) {
  const Indexed data(test::rolling_ground(20000, 40.0));
  std::vector<Vec3f> points = data.shape.positions;
  const flann::Matrix<float> matrix(&points[0].x, points.size(), 3);
  flann::Index<flann::L2_Simple<float>> index(matrix, flann::KDTreeSingleIndexParams(15));
  index.buildIndex();
  std::vector<std::vector<std::size_t>> ids;
  std::vector<std::vector<float>> distances;
  index.knnSearch(matrix, ids, distances, 16, flann::SearchParams(-1, 0.0f));
  for_each_neighbourhood(data.tree, {}, 2, {}, [&](std::uint32_t i, const Neighbourhood& found) {
    ASSERT_EQ(found.size, 16u);
    ASSERT_NEAR(found.reach_sq, distances[i].back(), 1e-6f) << "of point " << i;
  });
}

TEST(PointTree, IsTheSameForAnyNumberOfThreads) {
  const Shape shape = test::rolling_ground(200000, 100.0);
  const Indexed one(shape, 1), two(shape, 2);
  ASSERT_EQ(one.shape.positions, two.shape.positions);
  ASSERT_EQ(one.tree.leaves(), two.tree.leaves());
  for (std::size_t i = 0; i < one.tree.nodes().size(); ++i) {
    ASSERT_EQ(one.tree.nodes()[i].skip, two.tree.nodes()[i].skip);
    ASSERT_EQ(one.tree.nodes()[i].max, two.tree.nodes()[i].max);
  }
}

TEST(MortonOrder, HoldsEveryPointOnceWithAscendingKeys) {
  const Shape shape = test::rolling_ground(5000, 30.0);
  MortonOrder sorted = sort_along_curve(shape.positions, 2);
  EXPECT_TRUE(std::is_sorted(sorted.keys.begin(), sorted.keys.end()));
  std::sort(sorted.order.begin(), sorted.order.end());
  for (std::uint32_t i = 0; i < sorted.order.size(); ++i) ASSERT_EQ(sorted.order[i], i);
}

TEST(MortonOrder, PutsCoincidentPointsSideBySideLowestIndexFirst) {
  std::vector<Vec3f> points(10, Vec3f{1, 1, 1});
  // Far enough for the others to share one key without sharing one place.
  points.push_back({1e7f, 1e7f, 1e7f});
  points[3] = {1.0f, 1.0f, 1.5f};
  points[7] = {1.0f, 1.0f, 1.5f};
  const MortonOrder sorted = sort_along_curve(points, 1);
  EXPECT_EQ(sorted.order, (std::vector<std::uint32_t>{0, 1, 2, 4, 5, 6, 8, 9, 3, 7, 10}));
}

}  // namespace
}  // namespace cornice::normals
