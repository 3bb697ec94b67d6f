// SPDX-License-Identifier: GPL-3.0-or-later
// Where a ray meets the ground: a guiding mesh a little off the ground finds the place, the
// implicit function the point.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>

#include "core/base/vec.h"
#include "stages/simulate/scene.h"
#include "stages/simulate/scene_embree.h"
#include "stages/simulate/scene_field.h"
#include "stages/simulate/scene_mesher.h"

namespace cornice::simulate {

struct GroundHit {
  double range_m = 0.0;
  Vec3d point;
  Vec3d gradient;
};

struct GroundRay {
  Vec3d origin;
  Vec3d direction;  ///< unit
  double far_m = 0.0;
};

/// The guiding mesh stands off the ground by more than its facets cut into it, so a ray meets it
/// before the ground; from there steps no longer than the distance to the ground lead either onto
/// it or out of the shell between, and then the mesh is asked again.
/// Thread contract: const members may be called from many threads.
class GroundRays {
 public:
  /// The field must outlive this.
  GroundRays(const GroundField& field, const Box2d& area, double mesh_step_m, int threads);

  /// First point of the ground along the unit direction, before range far_m.
  bool cast(Vec3d origin, Vec3d direction, double far_m, GroundHit& hit) const;
  /// The same for rays side by side, best those of successive pulses. All spans are of one length,
  /// at most kPacket; met[i] says whether hits[i] was set.
  static constexpr std::size_t kPacket = RayMesh::kPacket;
  void cast(std::span<const GroundRay> rays, std::span<GroundHit> hits,
            std::span<std::uint8_t> met) const;
  const Box3d& bounds() const { return bounds_; }
  /// In the coordinates of the field, over the area.
  const HeightBounds& height_bounds() const { return heights_; }
  std::uint64_t grazing_misses() const { return grazing_.load(std::memory_order_relaxed); }

 private:
  enum class Outcome { kHit, kLeft, kBuried, kGrazing };
  struct Lead;
  bool follow_from(const GroundRay& ray, double t, double end, bool is_on_mesh,
                   GroundHit& hit) const;
  void settle_all(std::span<const GroundRay> rays, std::array<Lead, kPacket>& leads,
                  std::span<GroundHit> hits) const;
  bool is_first(const GroundRay& ray, double from, double to, double slope) const;
  bool starts_in_shell(Vec3d origin) const;
  Outcome follow(Vec3d origin, Vec3d direction, double& t, GroundHit& hit) const;
  Outcome close_in(Vec3d origin, Vec3d direction, double above, double below, double value,
                   Vec3d gradient, GroundHit& hit) const;

  const GroundField& field_;
  double shell_m_;
  Vec3d origin_;
  Box3d bounds_;
  HeightBounds heights_;
  std::unique_ptr<RayMesh> mesh_;
  mutable std::atomic<std::uint64_t> grazing_{0};
};

}  // namespace cornice::simulate
