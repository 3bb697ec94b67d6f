// SPDX-License-Identifier: GPL-3.0-or-later
// Embree 3 or 4 behind one small class: closest hit of a ray with quads or triangles.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/vec.h"

namespace cornice::simulate {

/// Thread contract: cast() may be called from many threads.
class RayMesh {
 public:
  /// Takes the vertices and indices over. Positions relative to the caller's origin.
  RayMesh(std::vector<Vec3f> positions, std::vector<std::array<std::uint32_t, 4>> quads,
          int threads);
  RayMesh(std::vector<Vec3f> positions, std::vector<std::array<std::uint32_t, 3>> triangles,
          int threads);
  ~RayMesh();
  RayMesh(const RayMesh&) = delete;
  RayMesh& operator=(const RayMesh&) = delete;

  struct Hit {
    float range;
    std::uint32_t primitive;
  };
  /// First face met from either side with range in [0, far]; false where there is none.
  bool cast(Vec3f origin, Vec3f direction, float far, Hit& hit) const;

  /// Rays that go nearly the same way are traced several times as fast side by side.
  static constexpr std::size_t kPacket = 16;
  struct PacketRay {
    Vec3f origin;
    Vec3f direction;
    float far = -1.0f;  ///< below 0: no ray
  };
  struct PacketHit {
    float range = -1.0f;  ///< below 0: nothing met
    std::uint32_t primitive = 0;
    Vec3f normal;  ///< of the face, either side, any length
  };
  void cast(const std::array<PacketRay, kPacket>& rays, std::array<PacketHit, kPacket>& hits) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cornice::simulate
