// SPDX-License-Identifier: GPL-3.0-or-later
#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "stages/flightlines/lines_output.h"
#include "stages/flightlines/true_north.h"

namespace cornice::flightlines {
namespace {

using Value = std::variant<int, double, std::string>;
struct Field {
  const char* name;
  Value value;
};
using Fields = std::vector<Field>;

/// A GeoPackage in the making.
class Package {
 public:
  Package(const std::string& path, const Crs& crs) : path_(path) {
    GDALAllRegister();
    // A fixed date: the same survey gives the same bytes.
    CPLSetThreadLocalConfigOption("OGR_CURRENT_DATE", "2000-01-01T00:00:00.000Z");
    GDALDriverH driver = GDALGetDriverByName("GPKG");
    if (driver == nullptr) throw RunError(path_, "this GDAL has no GeoPackage driver");
    dataset_ = GDALCreate(driver, path_.c_str(), 0, 0, 0, GDT_Unknown, nullptr);
    if (dataset_ == nullptr) fail("cannot be created");
    if (!crs.empty()) {
      reference_ = OSRNewSpatialReference(crs.wkt.c_str());
      if (reference_ != nullptr) OSRSetAxisMappingStrategy(reference_, OAMS_TRADITIONAL_GIS_ORDER);
    }
    GDALSetMetadataItem(dataset_, "CORNICE_CRS", crs.text().c_str(), nullptr);
  }
  ~Package() {
    if (dataset_ != nullptr) GDALClose(dataset_);
    if (reference_ != nullptr) OSRRelease(reference_);
    CPLSetThreadLocalConfigOption("OGR_CURRENT_DATE", nullptr);
  }
  Package(const Package&) = delete;
  Package& operator=(const Package&) = delete;

  /// Makes a layer with the fields of `sample`.
  void begin_layer(const char* name, OGRwkbGeometryType type, const Fields& sample) {
    layer_ = GDALDatasetCreateLayer(dataset_, name, type == wkbNone ? nullptr : reference_, type,
                                    nullptr);
    if (layer_ == nullptr) fail(std::string("layer ") + name + " cannot be made");
    for (const Field& field : sample) {
      const OGRFieldType kind = std::holds_alternative<int>(field.value)      ? OFTInteger
                                : std::holds_alternative<double>(field.value) ? OFTReal
                                                                              : OFTString;
      OGRFieldDefnH definition = OGR_Fld_Create(field.name, kind);
      if (OGR_L_CreateField(layer_, definition, FALSE) != OGRERR_NONE) fail("a field failed");
      OGR_Fld_Destroy(definition);
    }
    // One transaction a layer: the default commits every feature to disk.
    GDALDatasetStartTransaction(dataset_, FALSE);
  }
  /// Adds a feature; takes the geometry over (nullptr: none).
  void add(const Fields& fields, OGRGeometryH geometry) {
    OGRFeatureH feature = OGR_F_Create(OGR_L_GetLayerDefn(layer_));
    for (int i = 0; i < static_cast<int>(fields.size()); ++i) {
      const Value& value = fields[static_cast<std::size_t>(i)].value;
      if (const int* number = std::get_if<int>(&value))
        OGR_F_SetFieldInteger(feature, i, *number);
      else if (const double* real = std::get_if<double>(&value))
        OGR_F_SetFieldDouble(feature, i, *real);
      else
        OGR_F_SetFieldString(feature, i, std::get<std::string>(value).c_str());
    }
    if (geometry != nullptr) OGR_F_SetGeometryDirectly(feature, geometry);
    const OGRErr error = OGR_L_CreateFeature(layer_, feature);
    OGR_F_Destroy(feature);
    if (error != OGRERR_NONE) fail("a feature could not be written (disk full?)");
  }
  void end_layer() {
    if (GDALDatasetCommitTransaction(dataset_) != OGRERR_NONE) fail("could not be written");
  }
  void close() {
    CPLErrorReset();
    GDALClose(std::exchange(dataset_, nullptr));
    if (CPLGetLastErrorType() >= CE_Failure) fail("could not be closed");
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw RunError(path_, what + ": " + CPLGetLastErrorMsg());
  }
  std::string path_;
  GDALDatasetH dataset_ = nullptr;
  OGRSpatialReferenceH reference_ = nullptr;
  OGRLayerH layer_ = nullptr;
};

int whole(std::uint64_t value) {
  return static_cast<int>(std::min<std::uint64_t>(value, 2147483647));
}

Fields line_fields(const LineEstimate& e, const TrueNorth& north) {
  const FlightLine& line = e.line;
  std::string remarks;
  for (const std::string& remark : e.remarks) remarks += (remarks.empty() ? "" : "; ") + remark;
  GlobePosition first, last;
  if (!line.nodes.empty()) {
    first = north.at(line.nodes.front().position).value_or(GlobePosition{});
    last = north.at(line.nodes.back().position).value_or(GlobePosition{});
  }
  return {{"id", static_cast<int>(line.id)},
          {"point_source_id", int{line.point_source_id}},
          {"scanner_channel", int{line.scanner_channel}},
          {"channel_in_user_data", line.channel_in_user_data ? 1 : 0},
          {"has_time", line.has_time ? 1 : 0},
          {"first_time_s", line.first_time_s},
          {"last_time_s", line.last_time_s},
          {"along_azimuth_deg", line.along_azimuth_deg},
          {"along_standard_error_deg", e.along_standard_error_deg},
          {"across_azimuth_deg", line.across_azimuth_deg},
          {"across_standard_error_deg", line.across_standard_error_deg},
          {"perpendicular_deg", e.perpendicular_deg},
          {"convergence_deg", 0.5 * (first.convergence_deg + last.convergence_deg)},
          {"first_latitude_deg", first.latitude_deg},
          {"first_longitude_deg", first.longitude_deg},
          {"last_latitude_deg", last.latitude_deg},
          {"last_longitude_deg", last.longitude_deg},
          {"scan_angle_sign", line.scan_angle_sign},
          {"sign_from", e.sign_from},
          {"beam_source", std::string(beam_source_name(line.beam_source))},
          {"beam_reason", line.beam_reason},
          {"method", e.method},
          {"points", whole(e.points)},
          {"pulses_used", whole(e.pulses_used)},
          {"pairs_used", whole(e.pairs_used)},
          {"height_m", e.height_m},
          {"speed_ms", e.speed_ms},
          {"min_angle_deg", e.min_angle_deg},
          {"max_angle_deg", e.max_angle_deg},
          {"pulse_rate_hz", e.pulse_rate_hz},
          {"lean_deg", e.lean_deg},
          {"cone_deg", e.cone_deg},
          {"looks", e.looks},
          {"angle_offset_deg", e.angle_offset_deg},
          {"angle_residual_deg", e.angle_residual_deg},
          {"scan_residual_deg", e.scan_residual_deg},
          {"pair_residual", e.pair_residual},
          {"position_error_m", e.position_error_m},
          {"height_error_m", e.height_error_m},
          {"bridged_s", e.bridged_s},
          {"remarks", remarks}};
}

OGRGeometryH line_geometry(const FlightLine& line) {
  if (line.nodes.empty()) return nullptr;
  OGRGeometryH geometry = OGR_G_CreateGeometry(wkbLineStringZM);
  for (const TrajectoryNode& node : line.nodes)
    OGR_G_AddPointZM(geometry, node.position.x, node.position.y, node.position.z, node.gps_time_s);
  return geometry;
}

Fields node_fields(const FlightLine& line, const TrajectoryNode& node) {
  return {{"line", static_cast<int>(line.id)},
          {"gps_time_s", node.gps_time_s},
          {"error_x_m", static_cast<double>(node.standard_error_m.x)},
          {"error_y_m", static_cast<double>(node.standard_error_m.y)},
          {"error_z_m", static_cast<double>(node.standard_error_m.z)},
          {"bridged", node.bridged ? 1 : 0}};
}

void write_layers(Package& package, const SurveyLines& survey) {
  const TrueNorth north(survey.crs);
  package.begin_layer("lines", wkbLineStringZM, line_fields({}, north));
  for (const LineEstimate& estimate : survey.lines)
    package.add(line_fields(estimate, north), line_geometry(estimate.line));
  package.end_layer();
  package.begin_layer("nodes", wkbPointZM, node_fields({}, {}));
  for (const LineEstimate& estimate : survey.lines)
    for (const TrajectoryNode& node : estimate.line.nodes) {
      OGRGeometryH point = OGR_G_CreateGeometry(wkbPointZM);
      OGR_G_SetPointZM(point, 0, node.position.x, node.position.y, node.position.z,
                       node.gps_time_s);
      package.add(node_fields(estimate.line, node), point);
    }
  package.end_layer();
  const auto overlap_fields = [](const OverlapPair& pair) {
    return Fields{{"first_line", static_cast<int>(pair.first_line)},
                  {"second_line", static_cast<int>(pair.second_line)},
                  {"median_dz_m", pair.median_dz_m},
                  {"spread_m", pair.spread_m},
                  {"cells", whole(pair.cells)}};
  };
  package.begin_layer("overlaps", wkbNone, overlap_fields({}));
  for (const OverlapPair& pair : survey.overlaps) package.add(overlap_fields(pair), nullptr);
  package.end_layer();
  package.begin_layer("invalid_pulses", wkbNone,
                      {{"tile", std::string()}, {"reason", std::string()}, {"points", 0}});
  for (const TileCounts& tile : survey.tiles)
    for (std::size_t i = 0; i < kInvalidKinds; ++i)
      if (tile.invalid[i] > 0)
        package.add({{"tile", tile.file.filename().string()},
                     {"reason", std::string(invalid_name(static_cast<Invalid>(i)))},
                     {"points", whole(tile.invalid[i])}},
                    nullptr);
  package.end_layer();
}

}  // namespace

void write_geopackage(const std::filesystem::path& path, const SurveyLines& survey) {
  AtomicFile file(path);
  Package package(file.path().string(), survey.crs);
  write_layers(package, survey);
  package.close();
  file.commit();
}

}  // namespace cornice::flightlines
