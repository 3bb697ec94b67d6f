// SPDX-License-Identifier: GPL-3.0-or-later
// Points with nothing around them: birds, dust, errors of the ranging.
#pragma once

#include <cstdint>
#include <vector>

#include "stages/normals/point_tree.h"

namespace cornice::normals {

/// How isolated points are told.
struct IsolatedOptions {
  enum class Method { kNone, kRadius, kStatistical };
  Method method = Method::kRadius;
  /// kRadius: a point needs `neighbours` others within this distance. Walls that beams graze have
  /// as little as a point in 4 m2, so more company cannot be asked for without dropping rock.
  double radius_m = 4.0;
  int neighbours = 2;
  /// kStatistical: a point whose mean distance to `mean_k` neighbours exceeds the mean of all
  /// points by this many standard deviations is isolated. Looks at every point: slow.
  double deviations = 6.0;
  int mean_k = 8;
};

/// 1 for every isolated point of the tree, N in the tree's order. By PCL; with kRadius PCL sees
/// only the points that the tree does not show to be in company at a glance, and their
/// surroundings. Rusu et al., "Towards 3D point cloud based object maps", 2008, section 3.2.
std::vector<std::uint8_t> find_isolated(const PointTree& tree, const IsolatedOptions& options);

}  // namespace cornice::normals
