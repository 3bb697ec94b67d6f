// SPDX-License-Identifier: GPL-3.0-or-later
// The octree of a COPC file: each node holds a sample of the points of its cube, coarse at the
// root, so that a viewer can stop at any depth.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/progress.h"
#include "core/base/vec.h"

namespace cornice {

/// A node and the points it holds itself.
struct CopcNode {
  std::int32_t level = 0;
  Vec3<std::int32_t> key;  ///< position among the cubes of its level
  std::vector<std::uint32_t> points;
};

/// The cube of the root.
struct CopcCube {
  Vec3d min;
  double side = 1.0;
};

/// Points a side of a node's cube that it holds at most, so that its sample is evenly spread.
constexpr int kCopcGrid = 128;

/// Nodes in breadth-first order, those of one level in Morton order; every point is in exactly one
/// node, and indices ascend within a node. There is always a root. A node with more than
/// `most_points` keeps the first point in file order of each occupied cell of a kCopcGrid^3 grid
/// and hands the others to its children.
/// `stored`: integer coordinates; world = stored * scale + offset. The result does not depend on
/// `threads`.
std::vector<CopcNode> build_copc_octree(const std::vector<Vec3<std::int32_t>>& stored, Vec3d scale,
                                        Vec3d offset, const CopcCube& cube, std::size_t most_points,
                                        int threads, Progress& progress = no_progress());

/// The smallest cube with room for all points, its minimum at theirs.
CopcCube copc_cube(const std::vector<Vec3<std::int32_t>>& stored, Vec3d scale, Vec3d offset);

}  // namespace cornice
