// SPDX-License-Identifier: GPL-3.0-or-later
// After Li 2024, "Multi-scale simplification and visualization of large 3D models" (thesis,
// Sorbonne Université), 5.1.2, steps (5) and (6), with the beams of the whole neighbourhood instead
// of the point's own alone.
#include "stages/normals/orient.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/base/parallel.h"
#include "stages/normals/bend_fit.h"
#include "stages/normals/faces.h"
#include "stages/normals/plane_fit.h"
#include "stages/normals/propagate.h"

namespace cornice::normals {
namespace {

/// Quality of a plane, less for one that is hardly broader than the noise.
float merit(const PlaneFit& plane, float least_breadth_m) {
  return plane.breadth_m < least_breadth_m ? plane.quality * plane.breadth_m / least_breadth_m
                                           : plane.quality;
}

/// A point's plane and what the beams of its neighbourhood say.
struct Estimate {
  std::uint32_t point = 0, leaf = 0;
  PlaneFit plane;
  float cosine = 0.0f;  ///< mean_cosines
  Vec3f bent;           ///< bent_normals
};

/// The normal that a point gets once its side is known, but for its sign. Sides are passed on from
/// plane to plane: at edges of thin blades planes are the safer guide.
struct Bent {
  std::uint32_t point;
  Vec3f normal;
};

/// By task, and so in the same order for any number of threads.
using BentParts = std::vector<std::vector<Bent>>;

void write_bent(const BentParts& parts, int threads, std::vector<Vec3f>& normals) {
  parallel_for(parts.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      for (const Bent& bent : parts[p]) {
        Vec3f& normal = normals[bent.point];
        normal = dot(normal, bent.normal) < 0.0f ? -bent.normal : bent.normal;
      }
    }
  });
}

/// Fits planes block by block and hands out an Estimate for each point that was added.
class Estimator {
 public:
  Estimator(const PointTree& tree, const Beams& beams, const NeighbourRule& rule)
      : tree_(tree), beams_(beams), search_(tree, rule) {}

  template <class Take>
  void add_leaf(std::uint32_t leaf, const Take& take) {
    search_.open(leaf);
    for (std::uint32_t i = tree_.nodes()[leaf].begin; i < tree_.nodes()[leaf].end; ++i) {
      add(i, leaf, take, true);
    }
  }
  /// Points of one leaf must follow each other.
  template <class Take>
  void add_again(const Estimate& before, std::uint32_t factor, const Take& take) {
    if (leaf_ != before.leaf || factor_ != factor) search_.open(before.leaf, factor);
    factor_ = factor;
    add(before.point, before.leaf, take, false);
  }
  template <class Take>
  void flush(const Take& take, bool faces = false) {
    estimate(block_, leaves_, take, faces);
    block_.clear();
  }
  template <class Take>
  void flush_faces(const Take& take) {
    estimate(faces_, face_leaves_, take, false);
    faces_.clear();
  }

 private:
  template <class Take>
  void estimate(NeighbourBlock& block, const std::array<std::uint32_t, kLanes>& leaves,
                const Take& take, bool faces) {
    block.finish();
    PlaneBlock planes;
    fit_planes(block, planes);
    const std::array<float, kLanes> cosines = mean_cosines(block, planes, beams_);
    const std::array<Vec3f, kLanes> bent = bent_normals(block, planes);
    for (std::size_t l = 0; l < block.lanes(); ++l) {
      if (faces && may_mix_faces(planes.plane(l))) {
        face_leaves_[faces_.lanes()] = leaves[l];
        finder_.add_face(block, l, beams_, faces_);
        if (faces_.is_full()) flush_faces(take);
      } else {
        take(Estimate{block.point(l), leaves[l], planes.plane(l), cosines[l], bent[l]});
      }
    }
  }
  template <class Take>
  void add(std::uint32_t i, std::uint32_t leaf, const Take& take, bool faces) {
    leaf_ = leaves_[block_.lanes()] = leaf;
    search_.find(i, block_);
    if (block_.is_full()) flush(take, faces);
  }

  const PointTree& tree_;
  const Beams& beams_;
  LeafSearch search_;
  NeighbourBlock block_;
  NeighbourBlock faces_;
  FaceFinder finder_;
  std::array<std::uint32_t, kLanes> leaves_{}, face_leaves_{};
  std::uint32_t leaf_ = 0, factor_ = 1;
};

/// Fits planes that are no broader than the noise again to more and more points; of all fits the
/// one of greatest merit is kept. A sharp ridge has a poor plane that is broad enough: more points
/// would not make it better.
template <class Take>
void widen(Estimator& estimator, std::vector<Estimate>& narrow, float least_breadth_m,
           const Take& take) {
  for (const std::uint32_t factor : {2u, 4u, 8u, 16u}) {
    std::vector<Estimate> still_narrow;
    std::size_t next = 0;
    const auto compare = [&](const Estimate& found) {
      Estimate best = narrow[next++];
      if (found.plane.exists() &&
          (!best.plane.exists() ||
           merit(found.plane, least_breadth_m) > merit(best.plane, least_breadth_m))) {
        best = found;
      }
      if (best.plane.breadth_m < least_breadth_m) {
        still_narrow.push_back(best);
      } else {
        take(best);
      }
    };
    for (const Estimate& estimate : narrow) estimator.add_again(estimate, factor, compare);
    estimator.flush(compare);
    narrow = std::move(still_narrow);
  }
  for (const Estimate& estimate : narrow) take(estimate);
  narrow.clear();
}

constexpr std::size_t kLeavesPerTask = 512;

}  // namespace

OrientedNormals orient_normals(const PointTree& tree, const Beams& beams,
                               const OrientOptions& options, Progress& progress) {
  const std::size_t n = tree.positions().size();
  assert(beams.direction.size() == n && beams.source.size() == n);
  OrientedNormals result;
  result.normals.resize(n);
  result.quality.resize(n);
  result.settled_by.resize(n, SettledBy::kNoPlane);
  std::vector<float> evidence(n);
  const auto settle = [&](const Estimate& found, std::vector<Bent>& bent) {
    const PlaneFit& plane = found.plane;
    const std::uint32_t i = found.point;
    if (!plane.exists()) return;
    const float needed = options.tolerance + options.tolerance_per_lack * (1.0f - plane.quality);
    result.normals[i] = found.cosine > 0.0f ? -plane.normal : plane.normal;
    result.quality[i] = plane.quality;
    evidence[i] = std::abs(found.cosine);
    result.settled_by[i] = evidence[i] >= needed ? SettledBy::kBeams : SettledBy::kNothing;
    if (found.bent != plane.normal) bent.push_back({i, found.bent});
  };
  const std::vector<std::uint32_t>& leaves = tree.leaves();
  BentParts bent(leaves.size() / kLeavesPerTask + 1);
  parallel_for(leaves.size(), kLeavesPerTask, options.threads,
               [&](std::size_t begin, std::size_t end) {
                 Estimator estimator(tree, beams, options.neighbours);
                 std::vector<Estimate> narrow;
                 std::vector<Bent>& here = bent[begin / kLeavesPerTask];
                 const auto settle_here = [&](const Estimate& found) { settle(found, here); };
                 const auto take = [&](const Estimate& found) {
                   if (found.plane.breadth_m < options.least_breadth_m) {
                     narrow.push_back(found);
                   } else {
                     settle_here(found);
                   }
                 };
                 for (std::size_t l = begin; l < end; ++l) estimator.add_leaf(leaves[l], take);
                 estimator.flush(take, true);
                 estimator.flush_faces(take);
                 widen(estimator, narrow, options.least_breadth_m, settle_here);
               });
  check_cancelled(progress);
  progress.begin("propagation", 0);
  result.rounds = propagate(tree, evidence, options, result);
  write_bent(bent, options.threads, result.normals);
  for (const SettledBy by : result.settled_by) ++result.counts[static_cast<std::size_t>(by)];
  return result;
}

}  // namespace cornice::normals
