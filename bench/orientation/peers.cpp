// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/orientation/peers.h"

#include <pcl/features/normal_3d.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "core/base/parallel.h"
#include "stages/normals/beams.h"
#include "stages/normals/plane_fit.h"

namespace cornice::bench {
namespace {

using normals::Neighbourhood;

constexpr std::uint32_t kNeighbours = 16;

std::vector<std::uint8_t> where_there_is_a_plane(const std::vector<Vec3f>& planes) {
  std::vector<std::uint8_t> settled(planes.size());
  for (std::size_t i = 0; i < planes.size(); ++i) {
    settled[i] = dot(planes[i], planes[i]) > 0.5f ? 1 : 0;
  }
  return settled;
}

/// Neighbours of all points, kNeighbours each (fewer points than that: all of them), in one list.
std::vector<std::uint32_t> all_neighbours(const PeerInput& input, std::uint32_t& each) {
  const std::size_t n = input.planes.size();
  each = static_cast<std::uint32_t>(std::min<std::size_t>(kNeighbours, n));
  std::vector<std::uint32_t> list(n * each);
  for_each_neighbourhood(input.tree, {kNeighbours, kNeighbours, 0.0f}, input.threads, {},
                         [&](std::uint32_t i, const Neighbourhood& found) {
                           std::copy_n(found.index, found.size,
                                       list.begin() + static_cast<std::ptrdiff_t>(i) * each);
                         });
  return list;
}

struct Edge {
  float weight;
  std::uint32_t a, b;
};

/// Disjoint sets with path halving.
class Components {
 public:
  explicit Components(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  bool join(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t ra = root(a), rb = root(b);
    parent_[rb] = ra;
    return ra != rb;
  }

 private:
  std::vector<std::uint32_t> parent_;
};

/// Edges of the minimum spanning forest (Kruskal).
std::vector<Edge> spanning_forest(const PeerInput& input) {
  std::uint32_t each = 0;
  const std::vector<std::uint32_t> neighbours = all_neighbours(input, each);
  std::vector<Edge> edges;
  edges.reserve(neighbours.size());
  for (std::size_t e = 0; e < neighbours.size(); ++e) {
    const auto a = static_cast<std::uint32_t>(e / each), b = neighbours[e];
    if (a == b) continue;
    edges.push_back({1.0f - std::abs(dot(input.planes[a], input.planes[b])), a, b});
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& p, const Edge& q) {
    return std::tie(p.weight, p.a, p.b) < std::tie(q.weight, q.a, q.b);
  });
  Components components(input.planes.size());
  std::vector<Edge> tree;
  for (const Edge& edge : edges) {
    if (components.join(edge.a, edge.b)) tree.push_back(edge);
  }
  return tree;
}

/// Hands the side on from `start` along `tree` (adjacency lists).
void hand_on(std::uint32_t start, const std::vector<std::vector<std::uint32_t>>& tree,
             std::vector<Vec3f>& normals, std::vector<std::uint8_t>& seen) {
  std::vector<std::uint32_t> stack{start};
  seen[start] = 1;
  while (!stack.empty()) {
    const std::uint32_t i = stack.back();
    stack.pop_back();
    for (const std::uint32_t j : tree[i]) {
      if (seen[j] != 0) continue;
      seen[j] = 1;
      if (dot(normals[i], normals[j]) < 0.0f) normals[j] = -normals[j];
      stack.push_back(j);
    }
  }
}

}  // namespace

PeerInput make_peer_input(const normals::PointTree& tree, const PointCloud& points,
                          const FlightLines& lines, int threads) {
  PeerInput input{tree, points, lines, {}, {}, threads};
  input.planes.resize(tree.positions().size());
  input.quality.resize(tree.positions().size());
  for_each_neighbourhood(tree, {kNeighbours, kNeighbours, 0.0f}, threads, {},
                         [&](std::uint32_t i, const Neighbourhood& found) {
                           const normals::PlaneFit fit = normals::fit_plane(found);
                           input.planes[i] = fit.normal;
                           input.quality[i] = fit.quality;
                         });
  return input;
}

Oriented upward(const PeerInput& input) {
  Oriented result{"upward", input.planes, where_there_is_a_plane(input.planes)};
  for (Vec3f& n : result.normals) {
    if (n.z < 0.0f) n = -n;
  }
  return result;
}

Oriented pcl_viewpoint(const PeerInput& input, double height_m) {
  const auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  Vec3d middle;
  for (const Vec3f& p : input.tree.positions()) {
    cloud->push_back({p.x, p.y, p.z});
    middle += p.cast<double>() / static_cast<double>(input.planes.size());
  }
  pcl::NormalEstimation<pcl::PointXYZ, pcl::Normal> estimation;
  estimation.setInputCloud(cloud);
  estimation.setKSearch(static_cast<int>(kNeighbours));
  estimation.setViewPoint(static_cast<float>(middle.x), static_cast<float>(middle.y),
                          static_cast<float>(middle.z + height_m));
  pcl::PointCloud<pcl::Normal> normals;
  estimation.compute(normals);
  Oriented result{"PCL, viewpoint above", {}, {}};
  for (const pcl::Normal& n : normals) {
    const bool finite = std::isfinite(n.normal_x);
    result.normals.push_back(finite ? Vec3f{n.normal_x, n.normal_y, n.normal_z} : Vec3f{});
    result.settled.push_back(finite ? 1 : 0);
  }
  return result;
}

Oriented spanning_tree(const PeerInput& input) {
  Oriented result{"spanning tree (Hoppe)", input.planes, where_there_is_a_plane(input.planes)};
  const std::size_t n = input.planes.size();
  std::vector<std::vector<std::uint32_t>> tree(n);
  for (const Edge& edge : spanning_forest(input)) {
    tree[edge.a].push_back(edge.b);
    tree[edge.b].push_back(edge.a);
  }
  std::vector<std::uint32_t> by_height(n);
  std::iota(by_height.begin(), by_height.end(), 0u);
  std::stable_sort(by_height.begin(), by_height.end(), [&](std::uint32_t a, std::uint32_t b) {
    return input.tree.positions()[a].z > input.tree.positions()[b].z;
  });
  std::vector<std::uint8_t> seen(n, 0);
  for (const std::uint32_t i : by_height) {
    if (seen[i] != 0) continue;
    if (result.normals[i].z < 0.0f) result.normals[i] = -result.normals[i];
    hand_on(i, tree, result.normals, seen);
  }
  return result;
}

Oriented thesis(const PeerInput& input, bool plus) {
  constexpr float kScanTolerance = 0.25f, kFlipTolerance = 0.35f;
  Oriented result{plus ? "thesis, 0.25 + 2(1-q)" : "thesis as printed", input.planes, {}};
  const normals::PointBeams beams =
      normals::find_beams(input.points, input.lines, BeamSource::kAngles, input.threads);
  const std::size_t n = input.planes.size();
  result.settled.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const float cosine = dot(input.planes[i], beams.beams.direction[i]);
    const float lack = 2.0f * (1.0f - input.quality[i]);
    if (std::abs(cosine) <= kScanTolerance + (plus ? lack : -lack)) continue;
    result.settled[i] = dot(input.planes[i], input.planes[i]) > 0.5f ? 1 : 0;
    if (cosine > 0.0f) result.normals[i] = -result.normals[i];
  }
  std::uint32_t each = 0;
  const std::vector<std::uint32_t> neighbours = all_neighbours(input, each);
  for (bool changed = true; changed;) {
    changed = false;
    std::vector<std::uint8_t> next = result.settled;
    for (std::size_t i = 0; i < n; ++i) {
      if (result.settled[i] != 0) continue;
      float majority = 0.0f;
      for (std::size_t c = 0; c < each; ++c) {
        const std::uint32_t j = neighbours[i * each + c];
        const float cosine = dot(result.normals[i], result.normals[j]);
        if (result.settled[j] == 0) continue;
        if (std::abs(cosine) > 1.0f + kFlipTolerance - input.quality[i]) {
          majority += input.quality[j] * cosine;
        }
      }
      if (majority == 0.0f) continue;
      if (majority < 0.0f) result.normals[i] = -result.normals[i];
      next[i] = 1;
      changed = true;
    }
    result.settled = std::move(next);
  }
  return result;
}

}  // namespace cornice::bench
