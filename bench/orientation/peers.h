// SPDX-License-Identifier: GPL-3.0-or-later
// What people use today to orient normals, for comparison.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/vec.h"
#include "core/points/flight_line.h"
#include "core/points/point_cloud.h"
#include "stages/normals/point_tree.h"

namespace cornice::bench {

/// Normals of N points by one method; settled 0: the method gives none.
struct Oriented {
  std::string method;
  std::vector<Vec3f> normals;
  std::vector<std::uint8_t> settled;
};

/// What the methods start from: points in the tree's order, planes without a side.
struct PeerInput {
  const normals::PointTree& tree;
  const PointCloud& points;  ///< in the tree's order, with attributes
  const FlightLines& lines;
  std::vector<Vec3f> planes;  ///< unit normals of either side, k = 16
  std::vector<float> quality;
  int threads = 2;
};

/// Fits the planes.
PeerInput make_peer_input(const normals::PointTree& tree, const PointCloud& points,
                          const FlightLines& lines, int threads);

/// Every normal turned up.
Oriented upward(const PeerInput& input);

/// pcl::NormalEstimation with k = 16 and its viewpoint `height_m` above the middle of the cloud.
Oriented pcl_viewpoint(const PeerInput& input, double height_m);

/// A minimum spanning tree over the graph of 16 nearest neighbours, weights 1 - |n_i . n_j|; the
/// highest point of each component is turned up and its side handed on along the tree.
/// Hoppe et al., "Surface reconstruction from unorganized points", SIGGRAPH 1992, section 3.3;
/// CloudCompare orients in the same way.
Oriented spanning_tree(const PeerInput& input);

/// The formulas of Li 2024 (thesis, Sorbonne Université), 5.1.2: beam from the azimuth across the
/// line and the recorded scan angle; settled where |n.b| > 0.25 - 2 (1 - q), or, with `plus`,
/// > 0.25 + 2 (1 - q); then votes of settled neighbours with |n_i . n_j| > 1.35 - q until nothing
/// changes.
Oriented thesis(const PeerInput& input, bool plus);

}  // namespace cornice::bench
