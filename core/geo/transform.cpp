// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geo/transform.h"

#include <ogr_srs_api.h>

#include <cmath>
#include <memory>
#include <type_traits>

#include "core/geo/gdal_handles.h"

namespace cornice {
namespace {

struct SystemRelease {
  void operator()(void* system) const { OSRRelease(system); }
};
using System = std::unique_ptr<std::remove_pointer_t<OGRSpatialReferenceH>, SystemRelease>;

/// In plan alone; null where PROJ does not know it.
System plan_of(const Crs& crs) {
  System system(crs.empty() ? nullptr : OSRNewSpatialReference(crs.wkt.c_str()));
  if (system) {
    OSRSetAxisMappingStrategy(system.get(), OAMS_TRADITIONAL_GIS_ORDER);
    OSRStripVertical(system.get());
  }
  return system;
}

}  // namespace

PlanTransform::PlanTransform(const Crs& from, const Crs& to) {
  const QuietGdal quiet;
  const System source = plan_of(from), target = plan_of(to);
  if (!source || !target) return;
  if (void* way = OCTNewCoordinateTransformation(source.get(), target.get()))
    way_ = {way, [](void* made) {
              OCTDestroyCoordinateTransformation(static_cast<OGRCoordinateTransformationH>(made));
            }};
}

std::optional<Vec3d> PlanTransform::operator()(Vec3d position) const {
  if (!way_) return std::nullopt;
  const QuietGdal quiet;
  double x = position.x, y = position.y, z = 0.0;
  const bool done =
      OCTTransform(static_cast<OGRCoordinateTransformationH>(way_.get()), 1, &x, &y, &z) != 0;
  if (!done || !std::isfinite(x) || !std::isfinite(y)) return std::nullopt;
  return Vec3d{x, y, position.z};
}

std::optional<Vec3d> transformed(Vec3d position, const Crs& from, const Crs& to) {
  return PlanTransform(from, to)(position);
}

}  // namespace cornice
