// SPDX-License-Identifier: GPL-3.0-or-later
// Ground of any size that is known exactly, as densely sampled and as steep as an alpine tile.
#pragma once

#include <cstdint>

#include "core/base/vec.h"
#include "core/mesh/mesh.h"

namespace cornice::bench {

/// Ridges 150 m high, bumps of metres on them, and along the middle a wall of 40 m at 84 degrees.
/// A height for every place; the truth of meshes made from its points.
class Hills {
 public:
  explicit Hills(double side_m) : side_m_(side_m) {}
  double side_m() const { return side_m_; }
  Vec3d origin() const { return {2600000, 1200000, 1000}; }
  /// Signed distance of a place, relative to origin(), from the ground: positive above it. To
  /// first order, so right near the ground.
  double distance(Vec3d place) const;
  /// `count` points spread evenly over the plan, with `noise_m` along their normals, which are off
  /// by `tilt_deg` on average. The same for any number of threads.
  OrientedPoints sample(std::size_t count, double noise_m, double tilt_deg, std::uint64_t seed,
                        int threads) const;

 private:
  double side_m_;
};

/// Root mean square distance of a mesh's vertices and triangle centroids from the ground, those
/// nearer than `border_m` to the edge and farther than `far_m` from the ground left out.
struct HillsAccuracy {
  double rms_m = 0.0;
  double left_out_share = 0.0;  ///< of those away from the edge, that are too far from the ground
};
HillsAccuracy measure_accuracy(const Hills& hills, const Mesh& mesh, double border_m, double far_m);

}  // namespace cornice::bench
