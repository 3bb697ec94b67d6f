// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/normals/witnesses.h"

#include <algorithm>

#include "core/base/clones.h"

namespace cornice::normals {
namespace {

/// Sine of the angle by which a beam may be wrong, by BeamSource. A trajectory is good to metres in
/// a thousand; recorded angles leave out the fore and aft lean of the scanner; a vertical beam
/// leaves out the whole scan angle.
constexpr std::array<float, 3> kBeamDoubt{0.02f, 0.17f, 0.5f};

/// Distance from the plane, as a multiple of the neighbourhood's own spread, that halves a beam's
/// weight, and the least such distance in metres: range noise.
constexpr float kSpreads = 1.0f;
constexpr float kLeastSpread_m = 0.02f;

using Lanes = std::array<float, kLanes>;

/// The beams of one row.
struct Row {
  Lanes x, y, z, doubt;
};

[[gnu::always_inline]] inline void fetch(const std::uint32_t* index, const Beams& beams, Row& row) {
  for (std::size_t l = 0; l < kLanes; ++l) {
    const Vec3f b = beams.direction[index[l]];
    row.x[l] = b.x, row.y[l] = b.y, row.z[l] = b.z;
    row.doubt[l] = kBeamDoubt[static_cast<std::size_t>(beams.source[index[l]])];
  }
}

}  // namespace

CORNICE_CLONES
std::array<float, kLanes> mean_cosines(const NeighbourBlock& block, const PlaneBlock& planes,
                                       const Beams& beams) {
  Lanes scale, sum{}, weights{}, mean;
  for (std::size_t l = 0; l < kLanes; ++l) {
    scale[l] = 1.0f / (kSpreads * std::max(planes.spread_m[l], kLeastSpread_m));
  }
  const Lanes& nx = planes.normal_x;
  const Lanes& ny = planes.normal_y;
  const Lanes& nz = planes.normal_z;
  for (std::size_t c = 0; c < block.rows(); ++c) {
    Row row;
    fetch(block.index() + c * kLanes, beams, row);
    const float* dx = block.dx() + c * kLanes;
    const float* dy = block.dy() + c * kLanes;
    const float* dz = block.dz() + c * kLanes;
    for (std::size_t l = 0; l < kLanes; ++l) {
      const float off = scale[l] * (nx[l] * dx[l] + ny[l] * dy[l] + nz[l] * dz[l]);
      const float in_lane = c < block.sizes()[l] ? 1.0f : 0.0f;
      const float weight = in_lane / (1.0f + off * off);
      const float cosine = nx[l] * row.x[l] + ny[l] * row.y[l] + nz[l] * row.z[l];
      // Of the two terms only the one of the cosine's own sign is not zero.
      const float certain =
          std::max(cosine - row.doubt[l], 0.0f) + std::min(cosine + row.doubt[l], 0.0f);
      sum[l] += weight * certain;
      weights[l] += weight;
    }
  }
  for (std::size_t l = 0; l < kLanes; ++l) {
    mean[l] = weights[l] > 0.0f ? sum[l] / weights[l] : 0.0f;
  }
  return mean;
}

}  // namespace cornice::normals
