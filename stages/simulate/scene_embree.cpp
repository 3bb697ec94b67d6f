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
  bool takes_packets = false;  ///< Embree can be built without
  std::vector<Vec3f> positions;
  std::vector<std::array<std::uint32_t, 4>> quads;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  explicit Impl(int threads) {
    const std::string config = "threads=" + std::to_string(thread_count(threads));
    device = rtcNewDevice(config.c_str());
    if (device == nullptr) throw RunError("embree", "cannot start on this processor");
    takes_packets = rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED) != 0;
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
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
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

namespace {

RayMesh::PacketHit cast_one(RTCScene scene, const RayMesh::PacketRay& ray) {
  if (!(ray.far >= 0.0f)) return {};
  alignas(16) RTCRayHit query{};
  query.ray.org_x = ray.origin.x, query.ray.org_y = ray.origin.y, query.ray.org_z = ray.origin.z;
  query.ray.dir_x = ray.direction.x, query.ray.dir_y = ray.direction.y;
  query.ray.dir_z = ray.direction.z;
  query.ray.tnear = 0.0f;
  query.ray.tfar = ray.far;
  query.ray.mask = 0xffffffffu;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(scene, &query);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &query);
#endif
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  return {query.ray.tfar, query.hit.primID, {query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z}};
}

}  // namespace

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
  const PacketHit met = cast_one(impl_->scene, {origin, direction, far});
  if (met.range < 0.0f) return false;
  hit = {met.range, met.primitive};
  return true;
}

void RayMesh::cast(const std::array<PacketRay, kPacket>& rays,
                   std::array<PacketHit, kPacket>& hits) const {
  if (!impl_->takes_packets) {
    for (std::size_t i = 0; i < kPacket; ++i) hits[i] = cast_one(impl_->scene, rays[i]);
    return;
  }
  static_assert(kPacket == 16);
  alignas(64) std::array<std::int32_t, kPacket> active;
  alignas(64) RTCRayHit16 query;
  for (std::size_t i = 0; i < kPacket; ++i) {
    active[i] = rays[i].far >= 0.0f ? -1 : 0;
    query.ray.org_x[i] = rays[i].origin.x;
    query.ray.org_y[i] = rays[i].origin.y;
    query.ray.org_z[i] = rays[i].origin.z;
    query.ray.dir_x[i] = rays[i].direction.x;
    query.ray.dir_y[i] = rays[i].direction.y;
    query.ray.dir_z[i] = rays[i].direction.z;
    query.ray.tnear[i] = 0.0f;
    query.ray.tfar[i] = rays[i].far;
    query.ray.time[i] = 0.0f;
    query.ray.mask[i] = 0xffffffffu;
    query.ray.flags[i] = 0;
    query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
  }
#if RTC_VERSION_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect16(active.data(), impl_->scene, &query, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect16(active.data(), impl_->scene, &context, &query);
#endif
  for (std::size_t i = 0; i < kPacket; ++i) {
    const bool met = active[i] != 0 && query.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
    hits[i] = {met ? query.ray.tfar[i] : -1.0f,
               query.hit.primID[i],
               {query.hit.Ng_x[i], query.hit.Ng_y[i], query.hit.Ng_z[i]}};
  }
}

}  // namespace cornice::simulate
