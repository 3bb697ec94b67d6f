// SPDX-License-Identifier: GPL-3.0-or-later
// COPC files as LASzip reads them, and their octree taken apart byte by byte.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <set>
#include <tuple>

#include "core/base/error.h"
#include "core/io/las.h"
#include "tests/property/las_writer/clouds.h"
#include "tests/property/las_writer/laszip_oracle.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

using test::expected_points;
using test::OracleFile;
using test::OraclePoint;
using test::read_with_laszip;
using test::sample_cloud;
using test::TemporaryFolder;

LasWriteOptions copc_options(int point_format = 6) {
  LasWriteOptions options;
  options.point_format = point_format;
  options.offset = {2746000.0, 1234000.0, 500.0};
  options.crs = crs_from_text("EPSG:2056+5728");
  options.chunk_points = 300;
  return options;
}

std::vector<OraclePoint> sorted(std::vector<OraclePoint> points) {
  std::sort(points.begin(), points.end());
  return points;
}

template <class T>
T load(const std::string& bytes, std::size_t at) {
  T value{};
  if (at + sizeof(T) > bytes.size()) throw std::out_of_range("past the end of the file");
  std::memcpy(&value, &bytes[at], sizeof(T));
  return value;
}

struct Node {
  std::int32_t level, x, y, z;
  std::uint64_t offset;
  std::int32_t bytes, points;
};

/// The octree of a file as the specification lays it out.
struct Octree {
  Vec3d center;
  double half = 0, spacing = 0, first_time = 0, last_time = 0;
  std::uint64_t points_at = 0, table_at = 0;
  std::vector<Node> nodes;
};

Octree parse(const std::string& bytes) {
  EXPECT_EQ(bytes.substr(377, 5), std::string("copc\0", 5));
  EXPECT_EQ(load<std::uint16_t>(bytes, 393), 1);    // record id
  EXPECT_EQ(load<std::uint16_t>(bytes, 395), 160);  // length
  Octree tree;
  tree.center = {load<double>(bytes, 429), load<double>(bytes, 437), load<double>(bytes, 445)};
  tree.half = load<double>(bytes, 453);
  tree.spacing = load<double>(bytes, 461);
  const auto root_at = load<std::uint64_t>(bytes, 469);
  const auto root_bytes = load<std::uint64_t>(bytes, 477);
  tree.first_time = load<double>(bytes, 485);
  tree.last_time = load<double>(bytes, 493);
  EXPECT_EQ(bytes.substr(501, 88), std::string(88, '\0'));
  tree.points_at = load<std::uint32_t>(bytes, 96);
  tree.table_at = load<std::uint64_t>(bytes, tree.points_at);
  // The hierarchy is the data of the first extended record.
  const auto extended_at = load<std::uint64_t>(bytes, 235);
  EXPECT_EQ(bytes.substr(extended_at + 2, 5), std::string("copc\0", 5));
  EXPECT_EQ(load<std::uint16_t>(bytes, extended_at + 18), 1000);
  EXPECT_EQ(load<std::uint64_t>(bytes, extended_at + 20), root_bytes);
  EXPECT_EQ(root_at, extended_at + 60);
  for (std::uint64_t at = root_at; at < root_at + root_bytes; at += 32) {
    tree.nodes.push_back({load<std::int32_t>(bytes, at), load<std::int32_t>(bytes, at + 4),
                          load<std::int32_t>(bytes, at + 8), load<std::int32_t>(bytes, at + 12),
                          load<std::uint64_t>(bytes, at + 16), load<std::int32_t>(bytes, at + 24),
                          load<std::int32_t>(bytes, at + 28)});
  }
  return tree;
}

/// Every rule the hierarchy of a file has to keep, given the points in file order.
void expect_consistent(const Octree& tree, const OracleFile& file, const LasWriteOptions& options) {
  std::set<std::tuple<int, int, int, int>> keys;
  std::uint64_t position = tree.points_at + 8;
  std::size_t point = 0;
  for (const Node& node : tree.nodes) {
    EXPECT_TRUE(keys.insert({node.level, node.x, node.y, node.z}).second);
    if (node.level == 0) {
      EXPECT_EQ(std::tie(node.x, node.y, node.z), std::make_tuple(0, 0, 0));
    } else {
      EXPECT_TRUE(keys.count({node.level - 1, node.x / 2, node.y / 2, node.z / 2}))
          << "a node without its parent";
    }
    if (node.points == 0) continue;
    EXPECT_EQ(node.offset, position);
    position += static_cast<std::uint64_t>(node.bytes);
    const double side = 2 * tree.half / std::ldexp(1.0, node.level);
    const Vec3d low =
        Vec3d{tree.center.x - tree.half, tree.center.y - tree.half, tree.center.z - tree.half} +
        Vec3d{node.x * side, node.y * side, node.z * side};
    for (std::int32_t k = 0; k < node.points; ++k, ++point) {
      ASSERT_LT(point, file.points.size());
      const OraclePoint& p = file.points[point];
      const Vec3d at{p.x * options.scale.x + options.offset.x,
                     p.y * options.scale.y + options.offset.y,
                     p.z * options.scale.z + options.offset.z};
      const Vec3d inside = at - low;
      const double slack = 1e-6;
      EXPECT_TRUE(inside.x >= -slack && inside.x <= side + slack && inside.y >= -slack &&
                  inside.y <= side + slack && inside.z >= -slack && inside.z <= side + slack);
    }
  }
  EXPECT_EQ(position, tree.table_at) << "chunks with a gap between them";
  EXPECT_EQ(point, file.points.size());
}

class CopcFormat : public testing::TestWithParam<int> {};

TEST_P(CopcFormat, HoldsTheSamePointsAsGivenInAConsistentOctree) {
  const TemporaryFolder folder;
  LasWriteOptions options = copc_options(GetParam());
  for (const bool extra : {false, true}) {
    if (extra) options.extra_bytes = test::sample_extra_bytes();
    PointCloud cloud = sample_cloud(5000, options, 7);
    // Most points close together, so that the tree is several levels deep.
    for (std::size_t i = 100; i < cloud.size(); ++i) {
      auto& p = cloud.exact[i];
      p = {20000 + p.x / 100, 40000 + p.y / 100, p.z / 100};
    }
    std::vector<std::uint64_t> order;
    write_copc(folder / "p.copc.laz", cloud, options, no_progress(), &order);
    const OracleFile file = read_with_laszip(folder / "p.copc.laz");
    EXPECT_EQ(file.version_minor, 4);
    EXPECT_EQ(file.point_format, GetParam());
    const std::vector<OraclePoint> given = expected_points(cloud, options);
    EXPECT_EQ(sorted(file.points), sorted(given));
    ASSERT_EQ(order.size(), file.points.size());
    for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(file.points[i], given[order[i]]);
    const Octree tree = parse(test::read_text(folder / "p.copc.laz"));
    EXPECT_GT(tree.nodes.size(), 8u);
    EXPECT_DOUBLE_EQ(tree.spacing, 2 * tree.half / 128);
    EXPECT_EQ(tree.first_time, *std::min_element(cloud.gps_time_s.begin(), cloud.gps_time_s.end()));
    EXPECT_EQ(tree.last_time, *std::max_element(cloud.gps_time_s.begin(), cloud.gps_time_s.end()));
    EXPECT_GT(tree.nodes.back().level, 3);
    expect_consistent(tree, file, options);
  }
}

INSTANTIATE_TEST_SUITE_P(Copc, CopcFormat, testing::Values(6, 7, 8));

TEST(Copc, HasTheSameBytesWithAnyNumberOfThreads) {
  const TemporaryFolder folder;
  LasWriteOptions options = copc_options();
  const PointCloud cloud = sample_cloud(20000, options, 11);
  std::set<std::string> contents;
  for (const int threads : {1, 2, 3}) {
    options.threads = threads;
    write_copc(folder / "p.copc.laz", cloud, options);
    contents.insert(test::read_text(folder / "p.copc.laz"));
  }
  EXPECT_EQ(contents.size(), 1u);
}

TEST(Copc, RoundsPositionsAsTheOtherWriterDoes) {
  const TemporaryFolder folder;
  LasWriteOptions options = copc_options();
  PointCloud cloud = sample_cloud(2000, options, 3, 200.0);
  cloud.exact.clear();
  write_copc(folder / "p.copc.laz", cloud, options);
  LasWriter writer(folder / "p.laz", options);
  writer.write(cloud);
  writer.close();
  const OracleFile copc = read_with_laszip(folder / "p.copc.laz");
  const OracleFile laz = read_with_laszip(folder / "p.laz");
  EXPECT_EQ(sorted(copc.points), sorted(laz.points));
  EXPECT_EQ(copc.bounds, laz.bounds);
  EXPECT_EQ(copc.extended_by_return, laz.extended_by_return);
}

TEST(Copc, HoldsNoPointsOneAndManyAtOnePlace) {
  const TemporaryFolder folder;
  const LasWriteOptions options = copc_options();
  for (const std::size_t count : {0u, 1u, 2000u}) {
    PointCloud cloud = sample_cloud(count, options, 5);
    for (auto& p : cloud.exact) p = {7, -8, 9};
    write_copc(folder / "p.copc.laz", cloud, options);
    const OracleFile file = read_with_laszip(folder / "p.copc.laz");
    EXPECT_EQ(sorted(file.points), sorted(expected_points(cloud, options)));
    const Octree tree = parse(test::read_text(folder / "p.copc.laz"));
    ASSERT_FALSE(tree.nodes.empty());
    expect_consistent(tree, file, options);
  }
}

TEST(Copc, SpreadsTheSampleOfACoarseNodeEvenly) {
  const TemporaryFolder folder;
  const LasWriteOptions options = copc_options();
  const PointCloud cloud = sample_cloud(30000, options, 13);
  write_copc(folder / "p.copc.laz", cloud, options);
  const OracleFile file = read_with_laszip(folder / "p.copc.laz");
  const Octree tree = parse(test::read_text(folder / "p.copc.laz"));
  std::map<std::tuple<int, int, int>, int> cells;
  for (std::int32_t k = 0; k < tree.nodes[0].points; ++k) {
    const OraclePoint& p = file.points[static_cast<std::size_t>(k)];
    const auto cell = [&](double stored, double scale, double offset, double center) {
      const double inside = stored * scale + offset - (center - tree.half);
      return static_cast<int>(std::floor(inside / tree.spacing + 1e-9));
    };
    ++cells[{cell(p.x, options.scale.x, options.offset.x, tree.center.x),
             cell(p.y, options.scale.y, options.offset.y, tree.center.y),
             cell(p.z, options.scale.z, options.offset.z, tree.center.z)}];
  }
  const auto fullest = std::max_element(
      cells.begin(), cells.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  // Points within rounding of a cell's face may count with the neighbour.
  EXPECT_LE(fullest->second, 2);
  EXPECT_GT(tree.nodes[0].points, 10000);
}

TEST(Copc, GivesAWindowThroughItsOctree) {
  const TemporaryFolder folder;
  const LasWriteOptions options = copc_options();
  const PointCloud cloud = sample_cloud(20000, options, 17);
  write_copc(folder / "p.copc.laz", cloud, options);
  const LasInfo info = read_las_info(folder / "p.copc.laz");
  EXPECT_EQ(info.container, LasContainer::kCopc);
  EXPECT_EQ(info.crs.text(), "EPSG:2056+5728");
  LasReadOptions window;
  window.window = Box2d{2746100.0, 1234200.0, 2746150.0, 1234230.0};
  window.attributes = Attribute::kExact;
  const LasReadResult read = read_las(info, window);
  std::vector<std::tuple<int, int, int>> found, inside;
  for (const auto& p : read.points.exact) found.emplace_back(p.x, p.y, p.z);
  for (const auto& p : cloud.exact) {
    if (window.window->contains(p.x * options.scale.x + options.offset.x,
                                p.y * options.scale.y + options.offset.y)) {
      inside.emplace_back(p.x, p.y, p.z);
    }
  }
  std::sort(found.begin(), found.end());
  std::sort(inside.begin(), inside.end());
  EXPECT_EQ(found, inside);
  EXPECT_FALSE(inside.empty());
  EXPECT_LT(read.points_decoded, cloud.size());
}

TEST(Copc, RefusesFormatsThatItCannotHoldAndBadPoints) {
  const TemporaryFolder folder;
  for (const int format : {0, 1, 5, 9, 10}) {
    EXPECT_THROW(write_copc(folder / "p.copc.laz", {}, copc_options(format)), UsageError);
  }
  PointCloud cloud;
  cloud.positions.resize(2);
  cloud.positions[1].x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(write_copc(folder / "p.copc.laz", cloud, copc_options()), InputError);
  EXPECT_TRUE(folder.entries().empty());
}

}  // namespace
}  // namespace cornice
