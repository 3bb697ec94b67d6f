// SPDX-License-Identifier: GPL-3.0-or-later
// C. F. F. Karney, "Algorithms for geodesics", Journal of Geodesy 87, 2013 (GeographicLib).
#include "stages/flightlines/true_north.h"

#include <cpl_error.h>
#include <ogr_srs_api.h>

#include <GeographicLib/Geodesic.hpp>
#include <cmath>

namespace cornice::flightlines {
namespace {

/// Grid north is the direction to a point this far north on the grid, metres.
constexpr double kNorthStepM = 100.0;

}  // namespace

struct TrueNorth::Impl {
  OGRSpatialReferenceH projected = nullptr;
  OGRSpatialReferenceH geographic = nullptr;
  OGRCoordinateTransformationH transformation = nullptr;
  double step = kNorthStepM;  ///< in CRS units
  double semi_major = 6378137.0;
  double flattening = 1.0 / 298.257223563;

  ~Impl() {
    if (transformation != nullptr) OCTDestroyCoordinateTransformation(transformation);
    if (geographic != nullptr) OSRRelease(geographic);
    if (projected != nullptr) OSRRelease(projected);
  }
  bool to_globe(double& x, double& y) const {
    double z = 0.0;
    return OCTTransform(transformation, 1, &x, &y, &z) != 0 && std::isfinite(x) && std::isfinite(y);
  }
};

TrueNorth::TrueNorth(const Crs& crs) : impl_(std::make_unique<Impl>()) {
  if (crs.empty() || !(crs.metres_per_unit > 0.0)) return;
  CPLPushErrorHandler(CPLQuietErrorHandler);
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
    }
  }
  CPLPopErrorHandler();
}

TrueNorth::~TrueNorth() = default;

std::optional<GlobePosition> TrueNorth::at(Vec3d position) const {
  if (impl_->transformation == nullptr) return std::nullopt;
  double lon = position.x, lat = position.y;
  double lon_north = position.x, lat_north = position.y + impl_->step;
  CPLPushErrorHandler(CPLQuietErrorHandler);
  const bool done = impl_->to_globe(lon, lat) && impl_->to_globe(lon_north, lat_north);
  CPLPopErrorHandler();
  if (!done || std::abs(lat) > 90.0) return std::nullopt;
  const GeographicLib::Geodesic geodesic(impl_->semi_major, impl_->flattening);
  double azimuth = 0.0, azimuth_there = 0.0;
  geodesic.Inverse(lat, lon, lat_north, lon_north, azimuth, azimuth_there);
  return GlobePosition{lat, lon, azimuth};
}

}  // namespace cornice::flightlines
