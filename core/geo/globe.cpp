// SPDX-License-Identifier: GPL-3.0-or-later
// C. F. F. Karney, "Algorithms for geodesics", Journal of Geodesy 87, 2013 (GeographicLib).
#include "core/geo/globe.h"

#include <ogr_srs_api.h>

#include <GeographicLib/Geodesic.hpp>
#include <cmath>

#include "core/geo/gdal_handles.h"

namespace cornice {
namespace {

/// Grid north is the direction to a point this far north on the grid, metres.
constexpr double kNorthStepM = 100.0;

}  // namespace

struct Globe::Impl {
  OGRSpatialReferenceH projected = nullptr;
  OGRSpatialReferenceH geographic = nullptr;
  OGRCoordinateTransformationH transformation = nullptr;
  OGRCoordinateTransformationH backward = nullptr;
  double step = kNorthStepM;  ///< in CRS units
  double semi_major = 6378137.0;
  double flattening = 1.0 / 298.257223563;

  ~Impl() {
    if (backward != nullptr) OCTDestroyCoordinateTransformation(backward);
    if (transformation != nullptr) OCTDestroyCoordinateTransformation(transformation);
    if (geographic != nullptr) OSRRelease(geographic);
    if (projected != nullptr) OSRRelease(projected);
  }
  bool to_globe(double& x, double& y) const {
    double z = 0.0;
    return OCTTransform(transformation, 1, &x, &y, &z) != 0 && std::isfinite(x) && std::isfinite(y);
  }
};

Globe::Globe(const Crs& crs) : impl_(std::make_unique<Impl>()) {
  if (crs.empty() || !(crs.metres_per_unit > 0.0)) return;
  const QuietGdal quiet;
  impl_->projected = OSRNewSpatialReference(crs.wkt.c_str());
  if (impl_->projected != nullptr) {
    OSRSetAxisMappingStrategy(impl_->projected, OAMS_TRADITIONAL_GIS_ORDER);
    OSRStripVertical(impl_->projected);
    impl_->step = kNorthStepM / crs.metres_per_unit;
    OGRErr bad = OGRERR_NONE;
    const double axis = OSRGetSemiMajor(impl_->projected, &bad);
    const double inverse = OSRGetInvFlattening(impl_->projected, &bad);
    if (bad == OGRERR_NONE && inverse > 0.0) {
      impl_->semi_major = axis;
      impl_->flattening = 1.0 / inverse;
    }
    // The CRS's own datum: no shift enters the convergence.
    impl_->geographic = OSRCloneGeogCS(impl_->projected);
    if (impl_->geographic != nullptr) {
      OSRSetAxisMappingStrategy(impl_->geographic, OAMS_TRADITIONAL_GIS_ORDER);
      impl_->transformation = OCTNewCoordinateTransformation(impl_->projected, impl_->geographic);
      impl_->backward = OCTNewCoordinateTransformation(impl_->geographic, impl_->projected);
    }
  }
}

Globe::~Globe() = default;

std::optional<GlobePosition> Globe::at(Vec3d position) const {
  if (impl_->transformation == nullptr) return std::nullopt;
  double lon = position.x, lat = position.y;
  double lon_north = position.x, lat_north = position.y + impl_->step;
  const QuietGdal quiet;
  const bool done = impl_->to_globe(lon, lat) && impl_->to_globe(lon_north, lat_north);
  if (!done || std::abs(lat) > 90.0) return std::nullopt;
  const GeographicLib::Geodesic geodesic(impl_->semi_major, impl_->flattening);
  double azimuth = 0.0, azimuth_there = 0.0;
  geodesic.Inverse(lat, lon, lat_north, lon_north, azimuth, azimuth_there);
  return GlobePosition{lat, lon, azimuth};
}

std::optional<Vec3d> Globe::projected(double latitude_deg, double longitude_deg) const {
  if (impl_->backward == nullptr || std::abs(latitude_deg) > 90.0) return std::nullopt;
  double x = longitude_deg, y = latitude_deg, z = 0.0;
  const QuietGdal quiet;
  const bool done = OCTTransform(impl_->backward, 1, &x, &y, &z) != 0;
  if (!done || !std::isfinite(x) || !std::isfinite(y)) return std::nullopt;
  return Vec3d{x, y, 0.0};
}

}  // namespace cornice
