// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/point_cloud.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cornice::test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Points whose every attribute is told from their number.
PointCloud numbered(std::uint8_t first, std::uint8_t count) {
  PointCloud cloud;
  cloud.origin = {100.0, 200.0, 300.0};
  cloud.extra_stride = 2;
  for (std::uint8_t i = first; i < first + count; ++i) {
    const auto n = static_cast<float>(i);
    cloud.positions.push_back({n, n + 0.25f, n + 0.5f});
    cloud.exact.push_back({i, i + 1, i + 2});
    cloud.gps_time_s.push_back(1000.0 + i);
    cloud.scan_angle_deg.push_back(-n);
    cloud.return_number.push_back(i);
    cloud.return_count.push_back(i);
    cloud.classification.push_back(i);
    cloud.flags.push_back(i);
    cloud.point_source_id.push_back(i);
    cloud.scanner_channel.push_back(i);
    cloud.user_data.push_back(i);
    cloud.intensity.push_back(i);
    cloud.rgb.push_back({i, i, i});
    cloud.nir.push_back(i);
    cloud.wave_packet.push_back({i});
    cloud.extra_bytes.push_back(i);
    cloud.extra_bytes.push_back(static_cast<std::uint8_t>(100 + i));
  }
  return cloud;
}

void expect_same(const PointCloud& a, const PointCloud& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.exact, b.exact);
  EXPECT_EQ(a.gps_time_s, b.gps_time_s);
  EXPECT_EQ(a.scan_angle_deg, b.scan_angle_deg);
  EXPECT_EQ(a.return_number, b.return_number);
  EXPECT_EQ(a.return_count, b.return_count);
  EXPECT_EQ(a.classification, b.classification);
  EXPECT_EQ(a.flags, b.flags);
  EXPECT_EQ(a.point_source_id, b.point_source_id);
  EXPECT_EQ(a.scanner_channel, b.scanner_channel);
  EXPECT_EQ(a.user_data, b.user_data);
  EXPECT_EQ(a.intensity, b.intensity);
  EXPECT_EQ(a.rgb, b.rgb);
  EXPECT_EQ(a.nir, b.nir);
  EXPECT_EQ(a.wave_packet, b.wave_packet);
  EXPECT_EQ(a.extra_bytes, b.extra_bytes);
}

TEST(PointCloud, AppendingPutsEveryAttributeBehindTheLast) {
  PointCloud cloud = numbered(0, 3);
  cloud.append(numbered(3, 4));
  expect_same(cloud, numbered(0, 7));
}

TEST(PointCloud, AppendingToAnEmptyCloudTakesOriginAndExtraBytes) {
  PointCloud cloud;
  cloud.append(numbered(5, 2));
  EXPECT_EQ(cloud.origin, (Vec3d{100.0, 200.0, 300.0}));
  EXPECT_EQ(cloud.extra_stride, 2u);
  expect_same(cloud, numbered(5, 2));
}

TEST(PointCloud, AppendingAnEmptyCloudChangesNothing) {
  PointCloud cloud = numbered(0, 3);
  cloud.append(PointCloud{});
  expect_same(cloud, numbered(0, 3));
}

TEST(PointCloud, AppendingACloudToItselfDoublesIt) {
  PointCloud cloud = numbered(1, 2);
  cloud.append(cloud);
  EXPECT_THAT(cloud.classification, ElementsAre(1, 2, 1, 2));
  EXPECT_THAT(cloud.extra_bytes, ElementsAre(1, 101, 2, 102, 1, 101, 2, 102));
}

TEST(PointCloud, FilteringKeepsTheChosenPointsInOrder) {
  PointCloud cloud = numbered(0, 5);
  cloud.filter({0, 1, 1, 0, 1});
  PointCloud expected = numbered(1, 2);
  expected.append(numbered(4, 1));
  expect_same(cloud, expected);
}

TEST(PointCloud, FilteringLeavesUnfilledArraysEmpty) {
  PointCloud cloud;
  cloud.positions = {{0, 0, 0}, {1, 1, 1}};
  cloud.classification = {2, 6};
  cloud.filter({0, 1});
  EXPECT_THAT(cloud.classification, ElementsAre(6));
  EXPECT_THAT(cloud.gps_time_s, IsEmpty());
  EXPECT_EQ(cloud.size(), 1u);
}

TEST(PointCloud, FilteringEverythingAwayLeavesAnEmptyCloud) {
  PointCloud cloud = numbered(0, 3);
  cloud.filter({0, 0, 0});
  EXPECT_TRUE(cloud.empty());
  EXPECT_THAT(cloud.extra_bytes, IsEmpty());
}

TEST(PointCloud, ClearingEmptiesEveryArray) {
  PointCloud cloud = numbered(0, 3);
  cloud.clear();
  expect_same(cloud, PointCloud{});
}

TEST(PointCloud, ReservedMemoryIsOfTheAttributesAskedForOnly) {
  PointCloud cloud;
  cloud.reserve(1000, Attribute::kGpsTime | Attribute::kClassification);
  EXPECT_EQ(cloud.memory_bytes(), 1000 * (sizeof(Vec3f) + sizeof(double) + 1));
  EXPECT_EQ(cloud.size(), 0u);
}

TEST(PointCloud, PositionsAreRelativeToTheOrigin) {
  EXPECT_EQ(numbered(2, 1).position(0), (Vec3d{102.0, 202.25, 302.5}));
}

}  // namespace
}  // namespace cornice::test
