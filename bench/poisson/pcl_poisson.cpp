// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/poisson/pcl_poisson.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/surface/poisson.h>

#include <vector>

namespace cornice::bench {

Mesh pcl_poisson(const OrientedPoints& points, int depth) {
  const auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointNormal>>();
  cloud->reserve(points.positions.size());
  for (std::size_t i = 0; i < points.positions.size(); ++i) {
    pcl::PointNormal p;
    p.x = points.positions[i].x, p.y = points.positions[i].y, p.z = points.positions[i].z;
    p.normal_x = points.normals[i].x, p.normal_y = points.normals[i].y;
    p.normal_z = points.normals[i].z;
    cloud->push_back(p);
  }
  pcl::Poisson<pcl::PointNormal> poisson;
  poisson.setDepth(depth);
  poisson.setPointWeight(4.0f);
  poisson.setInputCloud(cloud);
  pcl::PointCloud<pcl::PointNormal> vertices;
  std::vector<pcl::Vertices> polygons;
  poisson.performReconstruction(vertices, polygons);
  Mesh mesh;
  mesh.origin = points.origin;
  for (const pcl::PointNormal& v : vertices) mesh.positions.push_back({v.x, v.y, v.z});
  for (const pcl::Vertices& polygon : polygons) {
    for (std::size_t i = 2; i < polygon.vertices.size(); ++i) {
      mesh.triangles.push_back({static_cast<std::uint32_t>(polygon.vertices[0]),
                                static_cast<std::uint32_t>(polygon.vertices[i - 1]),
                                static_cast<std::uint32_t>(polygon.vertices[i])});
    }
  }
  return mesh;
}

}  // namespace cornice::bench
