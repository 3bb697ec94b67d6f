// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/isolated.h"

#include <pcl/filters/radius_outlier_removal.h>
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace cornice::normals {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

/// True where more than `count` points, p itself included, lie in the cube inside the ball around
/// p.
bool has_company(const PointTree& tree, Vec3f p, double radius_m, std::uint32_t count) {
  const auto half = static_cast<float>(radius_m / std::sqrt(3.0));
  const std::vector<TreeNode>& nodes = tree.nodes();
  std::uint32_t found = 0;
  for (std::uint32_t at = 0; at < nodes.size() && found <= count;) {
    const TreeNode& node = nodes[at];
    const bool apart = node.min.x > p.x + half || node.max.x < p.x - half ||
                       node.min.y > p.y + half || node.max.y < p.y - half ||
                       node.min.z > p.z + half || node.max.z < p.z - half;
    if (!apart && node.skip == at + 1) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) {
        const Vec3f d = tree.positions()[i] - p;
        found += std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}) <= half ? 1 : 0;
      }
    }
    at = apart ? node.skip : at + 1;
  }
  return found > count;
}

/// Indices of points that no node shows to have company: a node of more than `neighbours` points
/// whose diagonal is no longer than the radius vouches for all its points.
std::vector<std::uint32_t> find_suspects(const PointTree& tree, const IsolatedOptions& options) {
  std::vector<std::uint32_t> suspects;
  const std::vector<TreeNode>& nodes = tree.nodes();
  const double radius_sq = options.radius_m * options.radius_m;
  const auto neighbours = static_cast<std::uint32_t>(options.neighbours);
  for (std::uint32_t at = 0; at < nodes.size();) {
    const TreeNode& node = nodes[at];
    const Vec3d diagonal = (node.max - node.min).cast<double>();
    if (node.end - node.begin > neighbours && dot(diagonal, diagonal) <= radius_sq) {
      at = node.skip;
      continue;
    }
    if (node.skip == at + 1) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) {
        if (!has_company(tree, tree.positions()[i], options.radius_m, neighbours)) {
          suspects.push_back(i);
        }
      }
    }
    ++at;
  }
  return suspects;
}

/// Marks every point within `reach` (along each axis) of a suspect.
void mark_around(const PointTree& tree, std::uint32_t suspect, float reach,
                 std::vector<std::uint8_t>& marked) {
  const Vec3f p = tree.positions()[suspect];
  const std::vector<TreeNode>& nodes = tree.nodes();
  for (std::uint32_t at = 0; at < nodes.size();) {
    const TreeNode& node = nodes[at];
    const bool apart = node.min.x > p.x + reach || node.max.x < p.x - reach ||
                       node.min.y > p.y + reach || node.max.y < p.y - reach ||
                       node.min.z > p.z + reach || node.max.z < p.z - reach;
    if (!apart && node.skip == at + 1) {
      std::fill(marked.begin() + node.begin, marked.begin() + node.end, std::uint8_t{1});
    }
    at = apart ? node.skip : at + 1;
  }
}

/// Points marked, as a PCL cloud, and each one's index in the tree.
Cloud::Ptr to_cloud(const PointTree& tree, const std::vector<std::uint8_t>& marked,
                    std::vector<std::uint32_t>& index) {
  const auto cloud = std::make_shared<Cloud>();
  for (std::uint32_t i = 0; i < marked.size(); ++i) {
    if (marked[i] == 0) continue;
    const Vec3f p = tree.positions()[i];
    cloud->push_back({p.x, p.y, p.z});
    index.push_back(i);
  }
  return cloud;
}

std::vector<std::uint8_t> find_by_radius(const PointTree& tree, const IsolatedOptions& options) {
  std::vector<std::uint8_t> isolated(tree.positions().size(), 0);
  const std::vector<std::uint32_t> suspects = find_suspects(tree, options);
  if (suspects.empty()) return isolated;
  std::vector<std::uint8_t> marked(isolated.size(), 0);
  // A little more than the radius: the marks go by float boxes.
  const auto reach = static_cast<float>(options.radius_m * 1.001);
  for (const std::uint32_t s : suspects) mark_around(tree, s, reach, marked);
  std::vector<std::uint32_t> index;
  const Cloud::Ptr cloud = to_cloud(tree, marked, index);
  const auto asked = std::make_shared<pcl::Indices>();
  for (const std::uint32_t s : suspects) {
    const auto place = std::lower_bound(index.begin(), index.end(), s) - index.begin();
    asked->push_back(static_cast<pcl::index_t>(place));
  }
  pcl::RadiusOutlierRemoval<pcl::PointXYZ> filter(true);
  filter.setInputCloud(cloud);
  filter.setIndices(asked);
  filter.setRadiusSearch(options.radius_m);
  filter.setMinNeighborsInRadius(options.neighbours);
  pcl::Indices kept;
  filter.filter(kept);
  for (const std::uint32_t s : suspects) isolated[s] = 1;
  for (const pcl::index_t k : kept) isolated[index[static_cast<std::size_t>(k)]] = 0;
  return isolated;
}

std::vector<std::uint8_t> find_by_statistics(const PointTree& tree,
                                             const IsolatedOptions& options) {
  std::vector<std::uint8_t> isolated(tree.positions().size(), 1);
  std::vector<std::uint32_t> index;
  const Cloud::Ptr cloud = to_cloud(tree, isolated, index);
  pcl::StatisticalOutlierRemoval<pcl::PointXYZ> filter;
  filter.setInputCloud(cloud);
  filter.setMeanK(options.mean_k);
  filter.setStddevMulThresh(options.deviations);
  pcl::Indices kept;
  filter.filter(kept);
  for (const pcl::index_t k : kept) isolated[index[static_cast<std::size_t>(k)]] = 0;
  return isolated;
}

}  // namespace

std::vector<std::uint8_t> find_isolated(const PointTree& tree, const IsolatedOptions& options) {
  const std::size_t n = tree.positions().size();
  switch (n == 0 ? IsolatedOptions::Method::kNone : options.method) {
    case IsolatedOptions::Method::kRadius:
      return find_by_radius(tree, options);
    case IsolatedOptions::Method::kStatistical:
      // Fewer points than asked for have no statistics; PCL would call them all outliers.
      if (n > static_cast<std::size_t>(options.mean_k)) return find_by_statistics(tree, options);
      break;
    case IsolatedOptions::Method::kNone:
      break;
  }
  return std::vector<std::uint8_t>(n, 0);
}

}  // namespace cornice::normals
