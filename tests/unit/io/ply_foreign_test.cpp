// SPDX-License-Identifier: GPL-3.0-or-later
// A second opinion: PCL reads what we write.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include "core/io/ply.h"
#include "tests/support/temporary_folder.h"

namespace cornice {
namespace {

using test::TemporaryFolder;
using testing::ElementsAre;

TEST(PlyInPcl, OrientedPointsKeepTheirPositionsNormalsAndProperties) {
  const TemporaryFolder folder;
  OrientedPoints points;
  points.origin = {2600000.0, 1200000.0, 1500.0};
  points.crs_text = "EPSG:2056+5728";
  points.positions = {{0.0f, 0.0f, 0.5f}, {1.0f, 2.0f, 3.0f}};
  points.normals = {{0.0f, 0.0f, 1.0f}, {0.6f, 0.0f, 0.8f}};
  points.quality = {0.5f, 0.25f};
  points.byte_properties = {{"class", {2, 9}}};
  points.line_id = {7, 300};
  write_ply(folder / "a.ply", points);
  pcl::PointCloud<pcl::PointXYZ> positions;
  ASSERT_EQ(pcl::io::loadPLYFile((folder / "a.ply").string(), positions), 0);
  ASSERT_EQ(positions.size(), 2u);
  EXPECT_EQ(positions[1].y, 2.0f);
  pcl::PCLPointCloud2 all;
  ASSERT_EQ(pcl::io::loadPLYFile((folder / "a.ply").string(), all), 0);
  std::vector<std::string> names;
  for (const auto& field : all.fields) names.push_back(field.name);
  EXPECT_THAT(names, ElementsAre("x", "y", "z", "normal_x", "normal_y", "normal_z", "quality",
                                 "class", "line_id"));
  pcl::PointCloud<pcl::Normal> normals;
  pcl::fromPCLPointCloud2(all, normals);
  EXPECT_EQ(normals[1].normal_x, 0.6f);
}

TEST(PlyInPcl, MeshesKeepTheirTriangles) {
  const TemporaryFolder folder;
  Mesh mesh;
  mesh.positions = {{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {1.0f, 1.0f, 0.5f}, {0.0f, 1.0f, 0.0f}};
  mesh.float_properties = {{"support", {1.0f, 2.0f, 3.0f, 4.0f}}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  write_ply(folder / "a.ply", mesh);
  pcl::PolygonMesh read;
  ASSERT_EQ(pcl::io::loadPLYFile((folder / "a.ply").string(), read), 0);
  ASSERT_EQ(read.polygons.size(), 2u);
  EXPECT_THAT(read.polygons[1].vertices, ElementsAre(0, 2, 3));
  EXPECT_EQ(read.cloud.width * read.cloud.height, 4u);
}

}  // namespace
}  // namespace cornice
