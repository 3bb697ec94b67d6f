// SPDX-License-Identifier: GPL-3.0-or-later
// After the steps (5) and (6) of section 5.1.2 of the thesis this project follows (DESIGN.md), with
// the beams of the whole neighbourhood instead of the point's own alone.
#include "stages/normals/orient.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/base/parallel.h"
#include "stages/normals/plane_fit.h"
#include "stages/normals/propagate.h"

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

/// Quality of a plane, less for one that is hardly broader than the noise.
float merit(const PlaneFit& plane, float least_breadth_m) {
  return plane.breadth_m < least_breadth_m ? plane.quality * plane.breadth_m / least_breadth_m
                                           : plane.quality;
}

/// cosine, less what the doubt about the beam may contribute.
float beyond_doubt(float cosine, float doubt) {
  return cosine > 0.0f ? std::max(cosine - doubt, 0.0f) : std::min(cosine + doubt, 0.0f);
}

/// Weighted mean of n . b over the neighbourhood: negative where the beams come from the side that
/// n points to.
float mean_cosine(const PlaneFit& plane, const Neighbourhood& neighbours, const Beams& beams) {
  const float scale = 1.0f / (kSpreads * std::max(plane.spread_m, kLeastSpread_m));
  const Vec3f n = plane.normal;
  float sum = 0.0f, weights = 0.0f;
  for (std::uint32_t c = 0; c < neighbours.size; ++c) {
    const float off = scale * dot(n, Vec3f{neighbours.dx[c], neighbours.dy[c], neighbours.dz[c]});
    const float weight = 1.0f / (1.0f + off * off);
    const std::uint32_t j = neighbours.index[c];
    const auto source = static_cast<std::size_t>(beams.source[j]);
    sum += weight * beyond_doubt(dot(n, beams.direction[j]), kBeamDoubt[source]);
    weights += weight;
  }
  return sum / weights;
}

/// A point's plane and what the beams of its neighbourhood say.
struct Estimate {
  PlaneFit plane;
  float cosine = 0.0f;  ///< mean_cosine
};

Estimate estimate(LeafSearch& search, std::uint32_t i, const Beams& beams, float least_breadth_m) {
  Estimate best;
  for (const std::uint32_t factor : {1u, 2u, 4u, 8u, 16u}) {
    // A sharp ridge has a poor plane that is broad enough: more points would not make it better.
    if (factor > 1 && best.plane.breadth_m >= least_breadth_m) break;
    const Neighbourhood neighbours = search.find(i, factor);
    const PlaneFit plane = fit_plane(neighbours);
    if (dot(plane.normal, plane.normal) == 0.0f) continue;
    if (factor == 1 || merit(plane, least_breadth_m) > merit(best.plane, least_breadth_m)) {
      best = {plane, mean_cosine(plane, neighbours, beams)};
    }
  }
  return best;
}

constexpr std::size_t kLeavesPerTask = 512;

}  // namespace

OrientedNormals orient_normals(const PointTree& tree, const Beams& beams,
                               const OrientOptions& options) {
  const std::size_t n = tree.positions().size();
  assert(beams.direction.size() == n && beams.source.size() == n);
  OrientedNormals result;
  result.normals.resize(n);
  result.quality.resize(n);
  result.settled_by.resize(n, SettledBy::kNoPlane);
  std::vector<float> evidence(n);
  const auto settle = [&](std::uint32_t i, const Estimate& found) {
    const PlaneFit& plane = found.plane;
    if (dot(plane.normal, plane.normal) == 0.0f) return;
    const float needed = options.tolerance + options.tolerance_per_lack * (1.0f - plane.quality);
    result.normals[i] = found.cosine > 0.0f ? -plane.normal : plane.normal;
    result.quality[i] = plane.quality;
    evidence[i] = std::abs(found.cosine);
    result.settled_by[i] = evidence[i] >= needed ? SettledBy::kBeams : SettledBy::kNothing;
  };
  const std::vector<std::uint32_t>& leaves = tree.leaves();
  parallel_for(leaves.size(), kLeavesPerTask, options.threads,
               [&](std::size_t begin, std::size_t end) {
                 LeafSearch search(tree, options.neighbours);
                 for (std::size_t l = begin; l < end; ++l) {
                   const TreeNode& leaf = tree.nodes()[leaves[l]];
                   search.open(leaves[l]);
                   for (std::uint32_t i = leaf.begin; i < leaf.end; ++i) {
                     settle(i, estimate(search, i, beams, options.least_breadth_m));
                   }
                 }
               });
  result.rounds = propagate(tree, evidence, options, result);
  for (const SettledBy by : result.settled_by) ++result.counts[static_cast<std::size_t>(by)];
  return result;
}

}  // namespace cornice::normals
