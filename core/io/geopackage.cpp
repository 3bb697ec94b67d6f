// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/geopackage.h"

#include <cpl_conv.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>

#include <cassert>
#include <type_traits>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/geo/gdal_handles.h"

namespace cornice {
namespace {

using ReferencePtr =
    std::unique_ptr<std::remove_pointer_t<OGRSpatialReferenceH>, void (*)(OGRSpatialReferenceH)>;
using FeaturePtr = std::unique_ptr<std::remove_pointer_t<OGRFeatureH>, void (*)(OGRFeatureH)>;

OGRwkbGeometryType ogr_type(GeometryKind kind) {
  switch (kind) {
    case GeometryKind::kNone:
      return wkbNone;
    case GeometryKind::kPointZ:
      return wkbPoint25D;
    case GeometryKind::kPointZM:
      return wkbPointZM;
    case GeometryKind::kLineStringZM:
      return wkbLineStringZM;
    case GeometryKind::kPolygon:
      return wkbPolygon;
  }
  return wkbNone;
}

OGRFieldType ogr_type(const FieldValue& value) {
  if (std::holds_alternative<std::int64_t>(value)) return OFTInteger64;
  return std::holds_alternative<double>(value) ? OFTReal : OFTString;
}

/// A new geometry of the kind; the caller owns it.
OGRGeometryH geometry_of(GeometryKind kind, const std::vector<GeometryPoint>& points) {
  OGRGeometryH geometry = OGR_G_CreateGeometry(ogr_type(kind));
  if (kind == GeometryKind::kPolygon) {
    OGRGeometryH ring = OGR_G_CreateGeometry(wkbLinearRing);
    for (const GeometryPoint& p : points) OGR_G_AddPoint_2D(ring, p.position.x, p.position.y);
    OGR_G_CloseRings(ring);
    OGR_G_AddGeometryDirectly(geometry, ring);
    return geometry;
  }
  // A point has one place; GDAL complains of asking.
  if (kind == GeometryKind::kLineStringZM) {
    OGR_G_SetPointCount(geometry, static_cast<int>(points.size()));
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& [p, m] = points[i];
    const int at = static_cast<int>(i);
    if (kind == GeometryKind::kPointZ)
      OGR_G_SetPoint(geometry, at, p.x, p.y, p.z);
    else
      OGR_G_SetPointZM(geometry, at, p.x, p.y, p.z, m);
  }
  return geometry;
}

}  // namespace

struct GeoPackage::State {
  State(const std::filesystem::path& path, const Crs& crs) : name(path.string()), file(path) {
    GDALAllRegister();
    // The file holds the time of its last change: fixed, so that one survey gives the same bytes.
    CPLSetThreadLocalConfigOption("OGR_CURRENT_DATE", "2000-01-01T00:00:00.000Z");
    GDALDriverH driver = GDALGetDriverByName("GPKG");
    if (driver == nullptr) throw RunError(name, "this GDAL has no GeoPackage driver");
    dataset.reset(GDALCreate(driver, file.path().c_str(), 0, 0, 0, GDT_Unknown, nullptr));
    if (!dataset) fail("cannot be created");
    if (!crs.empty()) {
      reference.reset(OSRNewSpatialReference(crs.wkt.c_str()));
      if (reference) OSRSetAxisMappingStrategy(reference.get(), OAMS_TRADITIONAL_GIS_ORDER);
    }
    GDALSetMetadataItem(dataset.get(), "CORNICE_CRS", crs.text().c_str(), nullptr);
  }
  ~State() { CPLSetThreadLocalConfigOption("OGR_CURRENT_DATE", nullptr); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  [[noreturn]] void fail(const std::string& what) const {
    throw RunError(name, what + ": " + CPLGetLastErrorMsg());
  }
  void end_layer() {
    if (layer != nullptr && GDALDatasetCommitTransaction(dataset.get()) != OGRERR_NONE)
      fail("could not be written");
    layer = nullptr;
  }

  std::string name;
  AtomicFile file;
  ReferencePtr reference{nullptr, OSRDestroySpatialReference};
  DatasetPtr dataset;
  OGRLayerH layer = nullptr;
  GeometryKind kind = GeometryKind::kNone;
};

GeoPackage::GeoPackage(const std::filesystem::path& path, const Crs& crs)
    : state_(std::make_unique<State>(path, crs)) {}
GeoPackage::~GeoPackage() = default;

void GeoPackage::begin_layer(const std::string& name, GeometryKind kind, const Fields& sample) {
  state_->end_layer();
  OGRSpatialReferenceH reference = kind == GeometryKind::kNone ? nullptr : state_->reference.get();
  OGRLayerH layer = GDALDatasetCreateLayer(state_->dataset.get(), name.c_str(), reference,
                                           ogr_type(kind), nullptr);
  if (layer == nullptr) state_->fail("layer " + name + " cannot be made");
  for (const Field& field : sample) {
    OGRFieldDefnH definition = OGR_Fld_Create(field.name.c_str(), ogr_type(field.value));
    const OGRErr error = OGR_L_CreateField(layer, definition, FALSE);
    OGR_Fld_Destroy(definition);
    if (error != OGRERR_NONE) state_->fail("field " + field.name + " cannot be made");
  }
  // One transaction a layer: the default commits every feature to disk.
  GDALDatasetStartTransaction(state_->dataset.get(), FALSE);
  state_->layer = layer;
  state_->kind = kind;
}

void GeoPackage::add(const Fields& fields, const std::vector<GeometryPoint>& points) {
  assert(state_->layer != nullptr && "begin_layer comes first");
  const FeaturePtr feature(OGR_F_Create(OGR_L_GetLayerDefn(state_->layer)), OGR_F_Destroy);
  for (int i = 0; i < static_cast<int>(fields.size()); ++i) {
    const FieldValue& value = fields[static_cast<std::size_t>(i)].value;
    if (const auto* whole = std::get_if<std::int64_t>(&value))
      OGR_F_SetFieldInteger64(feature.get(), i, *whole);
    else if (const double* real = std::get_if<double>(&value))
      OGR_F_SetFieldDouble(feature.get(), i, *real);
    else
      OGR_F_SetFieldString(feature.get(), i, std::get<std::string>(value).c_str());
  }
  if (!points.empty()) OGR_F_SetGeometryDirectly(feature.get(), geometry_of(state_->kind, points));
  if (OGR_L_CreateFeature(state_->layer, feature.get()) != OGRERR_NONE)
    state_->fail("a feature could not be written (disk full?)");
}

void GeoPackage::finish() {
  state_->end_layer();
  CPLErrorReset();
  state_->dataset.reset();
  if (CPLGetLastErrorType() >= CE_Failure) state_->fail("could not be closed");
  state_->file.commit();
}

}  // namespace cornice
