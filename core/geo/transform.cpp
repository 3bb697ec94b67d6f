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

struct TransformationDestroy {
  void operator()(OGRCoordinateTransformationH transformation) const {
    OCTDestroyCoordinateTransformation(transformation);
  }
};
using Transformation =
    std::unique_ptr<std::remove_pointer_t<OGRCoordinateTransformationH>, TransformationDestroy>;

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

std::optional<Vec3d> transformed(Vec3d position, const Crs& from, const Crs& to) {
  const QuietGdal quiet;
  const System source = plan_of(from), target = plan_of(to);
  if (!source || !target) return std::nullopt;
  const Transformation way(OCTNewCoordinateTransformation(source.get(), target.get()));
  if (!way) return std::nullopt;
  double x = position.x, y = position.y, z = 0.0;
  const bool done = OCTTransform(way.get(), 1, &x, &y, &z) != 0;
  if (!done || !std::isfinite(x) || !std::isfinite(y)) return std::nullopt;
  return Vec3d{x, y, position.z};
}

}  // namespace cornice
