// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/scene_embree.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <string>

#include "core/base/error.h"
#include "core/base/parallel.h"

namespace cornice::simulate {

struct RayMesh::Impl {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<Vec3f> positions;
  std::vector<std::array<std::uint32_t, 4>> quads;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  explicit Impl(int threads) {
    const std::string config = "threads=" + std::to_string(thread_count(threads));
    device = rtcNewDevice(config.c_str());
    if (device == nullptr) throw RunError("embree", "cannot start on this processor");
    scene = rtcNewScene(device);
  }
  ~Impl() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void build(RTCGeometryType type) {
    // Embree reads vertices in 16-byte steps: one more than there are must be readable.
    positions.push_back({});
    RTCGeometry geometry = rtcNewGeometry(device, type);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               positions.data(), 0, sizeof(Vec3f), positions.size() - 1);
    if (type == RTC_GEOMETRY_TYPE_QUAD) {
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, quads.data(),
                                 0, sizeof quads[0], quads.size());
    } else {
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                 triangles.data(), 0, sizeof triangles[0], triangles.size());
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneFlags(scene,
                     static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_COMPACT));
    rtcCommitScene(scene);
    const RTCError error = rtcGetDeviceError(device);
    if (error == RTC_ERROR_OUT_OF_MEMORY) {
      throw RunError("embree", "out of memory; give a coarser mesh step or a smaller extent");
    }
    if (error != RTC_ERROR_NONE) {
      throw RunError("embree", "error " + std::to_string(static_cast<int>(error)));
    }
  }
};

RayMesh::RayMesh(std::vector<Vec3f> positions, std::vector<std::array<std::uint32_t, 4>> quads,
                 int threads)
    : impl_(std::make_unique<Impl>(threads)) {
  impl_->positions = std::move(positions);
  impl_->quads = std::move(quads);
  impl_->build(RTC_GEOMETRY_TYPE_QUAD);
}

RayMesh::RayMesh(std::vector<Vec3f> positions, std::vector<std::array<std::uint32_t, 3>> triangles,
                 int threads)
    : impl_(std::make_unique<Impl>(threads)) {
  impl_->positions = std::move(positions);
  impl_->triangles = std::move(triangles);
  impl_->build(RTC_GEOMETRY_TYPE_TRIANGLE);
}

RayMesh::~RayMesh() = default;

bool RayMesh::cast(Vec3f origin, Vec3f direction, float far, Hit& hit) const {
  alignas(16) RTCRayHit query{};
  query.ray.org_x = origin.x, query.ray.org_y = origin.y, query.ray.org_z = origin.z;
  query.ray.dir_x = direction.x, query.ray.dir_y = direction.y, query.ray.dir_z = direction.z;
  query.ray.tnear = 0.0f;
  query.ray.tfar = far;
  query.ray.mask = 0xffffffffu;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(impl_->scene, &query);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(impl_->scene, &context, &query);
#endif
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  hit = {query.ray.tfar, query.hit.primID};
  return true;
}

}  // namespace cornice::simulate
