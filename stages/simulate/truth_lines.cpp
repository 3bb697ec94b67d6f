// SPDX-License-Identifier: GPL-3.0-or-later
#include <cpl_conv.h>
#include <gdal.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/base/error.h"
#include "core/geo/crs.h"
#include "stages/simulate/truth.h"

namespace cornice::simulate {
namespace {

using nlohmann::ordered_json;
using Dataset = std::unique_ptr<void, void (*)(GDALDatasetH)>;
using Feature = std::unique_ptr<std::remove_pointer_t<OGRFeatureH>, void (*)(OGRFeatureH)>;

double right_of(double heading_deg) { return std::fmod(heading_deg + 90.0, 360.0); }

/// Fields of a line in the order of docs/formats/flight_lines.md, then those of truth alone.
ordered_json fields_of(const LineTruth& truth, const LinesHeader& header) {
  const SurveyLine& line = truth.line;
  const double last = truth.tally.last_time_s < truth.tally.first_time_s
                          ? truth.tally.last_time_s + kWeekS
                          : truth.tally.last_time_s;
  return {{"id", line.id},
          {"point_source_id", line.point_source_id},
          {"scanner_channel", line.user_data != 0 ? line.user_data : line.recorded_channel},
          {"channel_in_user_data", line.user_data != 0},
          {"has_time", true},
          {"first_time_s", truth.tally.first_time_s},
          {"last_time_s", last},
          {"along_azimuth_deg", truth.course_deg},
          {"across_azimuth_deg", right_of(truth.heading_deg)},
          {"across_standard_error_deg", 0.0},
          {"scan_angle_sign", line.angle_sign},
          {"beam_source", "trajectory"},
          {"beam_reason", ""},
          {"pass", line.pass + 1},
          {"channel", line.channel},
          {"cross_line", truth.is_cross_line},
          {"heading_deg", truth.heading_deg},
          {"speed_ms", truth.speed_ms},
          {"height_m", truth.height_m},
          {"points", truth.tally.points},
          {"lowest_angle_deg", truth.tally.lowest_angle_deg},
          {"highest_angle_deg", truth.tally.highest_angle_deg},
          {"offset_x_m", line.offset.x},
          {"offset_y_m", line.offset.y},
          {"offset_z_m", line.offset.z},
          {"scanner", header.scanner},
          {"tilt_deg", header.tilt_deg[static_cast<std::size_t>(line.channel)]},
          {"field_of_view_deg", header.field_of_view_deg},
          {"pulse_rate", header.pulse_rate}};
}

[[noreturn]] void cannot_write(const std::filesystem::path& path) {
  throw RunError(path.string(), std::string("cannot be written as a GeoPackage: ") +
                                    CPLGetLastErrorMsg() + "; is the disk full?");
}

/// Settings for this thread alone while one file is written.
class ThreadOption {
 public:
  ThreadOption(const char* name, const std::string& value) : name_(name) {
    CPLSetThreadLocalConfigOption(name, value.c_str());
  }
  ~ThreadOption() { CPLSetThreadLocalConfigOption(name_, nullptr); }
  ThreadOption(const ThreadOption&) = delete;
  ThreadOption& operator=(const ThreadOption&) = delete;

 private:
  const char* name_;
};

void create_fields(OGRLayerH layer, const ordered_json& fields) {
  for (const auto& [name, value] : fields.items()) {
    const OGRFieldType type = value.is_string()         ? OFTString
                              : value.is_number_float() ? OFTReal
                              : name == "points"        ? OFTInteger64
                                                        : OFTInteger;
    const std::unique_ptr<std::remove_pointer_t<OGRFieldDefnH>, void (*)(OGRFieldDefnH)> field(
        OGR_Fld_Create(name.c_str(), type), OGR_Fld_Destroy);
    OGR_L_CreateField(layer, field.get(), TRUE);
  }
}

bool add_feature(OGRLayerH layer, const ordered_json& fields, OGRGeometryH geometry) {
  const Feature feature(OGR_F_Create(OGR_L_GetLayerDefn(layer)), OGR_F_Destroy);
  for (const auto& [name, value] : fields.items()) {
    const int i = OGR_F_GetFieldIndex(feature.get(), name.c_str());
    if (value.is_string())
      OGR_F_SetFieldString(feature.get(), i, value.get<std::string>().c_str());
    else if (value.is_number_float())
      OGR_F_SetFieldDouble(feature.get(), i, value.get<double>());
    else if (value.is_boolean())
      OGR_F_SetFieldInteger(feature.get(), i, value.get<bool>() ? 1 : 0);
    else
      OGR_F_SetFieldInteger64(feature.get(), i, value.get<std::int64_t>());
  }
  OGR_F_SetGeometryDirectly(feature.get(), geometry);
  return OGR_L_CreateFeature(layer, feature.get()) == OGRERR_NONE;
}

void add_lines(GDALDatasetH dataset, const std::vector<LineTruth>& lines, const LinesHeader& header,
               OGRSpatialReferenceH reference, const std::filesystem::path& path) {
  const OGRLayerH layer =
      GDALDatasetCreateLayer(dataset, "lines", reference, wkbLineStringZM, nullptr);
  if (layer == nullptr) cannot_write(path);
  if (!lines.empty()) create_fields(layer, fields_of(lines.front(), header));
  for (const LineTruth& line : lines) {
    const OGRGeometryH curve = OGR_G_CreateGeometry(wkbLineStringZM);
    OGR_G_SetPointCount(curve, static_cast<int>(line.nodes.size()));
    for (std::size_t i = 0; i < line.nodes.size(); ++i) {
      const Vec3d p = line.nodes[i].position;
      OGR_G_SetPointZM(curve, static_cast<int>(i), p.x, p.y, p.z, line.nodes[i].time_s);
    }
    if (!add_feature(layer, fields_of(line, header), curve)) cannot_write(path);
  }
}

void add_nodes(GDALDatasetH dataset, const std::vector<LineTruth>& lines,
               OGRSpatialReferenceH reference, const std::filesystem::path& path) {
  const OGRLayerH layer = GDALDatasetCreateLayer(dataset, "nodes", reference, wkbPoint25D, nullptr);
  if (layer == nullptr) cannot_write(path);
  const auto fields = [](int line, double time) {
    return ordered_json{{"line", line},     {"gps_time_s", time}, {"error_x_m", 0.0},
                        {"error_y_m", 0.0}, {"error_z_m", 0.0},   {"bridged", 0}};
  };
  create_fields(layer, fields(0, 0.0));
  for (const LineTruth& line : lines) {
    for (const LineTruth::Node& node : line.nodes) {
      const OGRGeometryH point = OGR_G_CreateGeometry(wkbPoint25D);
      OGR_G_SetPoint(point, 0, node.position.x, node.position.y, node.position.z);
      if (!add_feature(layer, fields(line.line.id, node.time_s), point)) cannot_write(path);
    }
  }
}

}  // namespace

void write_lines_json(const std::filesystem::path& path, const std::vector<LineTruth>& lines,
                      const LinesHeader& header) {
  ordered_json document{{"format", "cornice flight lines"},
                        {"version", 1},
                        {"crs", header.crs_text},
                        {"lines", ordered_json::array()}};
  for (const LineTruth& line : lines) {
    ordered_json object = fields_of(line, header);
    ordered_json& nodes = object["nodes"] = ordered_json::array();
    for (const LineTruth::Node& node : line.nodes)
      nodes.push_back(
          {node.time_s, node.position.x, node.position.y, node.position.z, 0.0, 0.0, 0.0, 0});
    document["lines"].push_back(std::move(object));
  }
  write_file_atomically(path, document.dump() + "\n");
}

void write_lines_geopackage(const std::filesystem::path& path, const std::vector<LineTruth>& lines,
                            const LinesHeader& header, int year) {
  GDALAllRegister();
  // GeoPackage holds the time of its last change: fixed, so that one seed gives the same bytes.
  const ThreadOption date("OGR_CURRENT_DATE", std::to_string(year) + "-01-01T00:00:00.000Z");
  AtomicFile file(path);
  const Crs crs = crs_from_text(header.crs_text);
  const std::unique_ptr<std::remove_pointer_t<OGRSpatialReferenceH>, void (*)(OGRSpatialReferenceH)>
      reference(OSRNewSpatialReference(crs.wkt.c_str()), OSRDestroySpatialReference);
  Dataset dataset(
      GDALCreate(GDALGetDriverByName("GPKG"), file.path().c_str(), 0, 0, 0, GDT_Unknown, nullptr),
      [](GDALDatasetH open) { GDALClose(open); });
  if (!dataset) cannot_write(path);
  GDALSetMetadataItem(dataset.get(), "CORNICE_CRS", header.crs_text.c_str(), nullptr);
  if (GDALDatasetStartTransaction(dataset.get(), FALSE) != OGRERR_NONE) cannot_write(path);
  add_lines(dataset.get(), lines, header, reference.get(), path);
  add_nodes(dataset.get(), lines, reference.get(), path);
  if (GDALDatasetCommitTransaction(dataset.get()) != OGRERR_NONE) cannot_write(path);
  CPLErrorReset();
  dataset.reset();
  if (CPLGetLastErrorType() >= CE_Failure) cannot_write(path);
  file.commit();
}

}  // namespace cornice::simulate
