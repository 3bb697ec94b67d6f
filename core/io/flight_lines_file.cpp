// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/flight_lines_file.h"

#include <gdal.h>
#include <ogr_api.h>

#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/error.h"
#include "core/base/input_file.h"

namespace cornice {
namespace {

using nlohmann::json;

BeamSource beam_source_from(const std::string& name, const std::string& file) {
  if (name == "trajectory") return BeamSource::kTrajectory;
  if (name == "angles") return BeamSource::kAngles;
  if (name == "vertical") return BeamSource::kVertical;
  throw InputError(
      file, "beam source \"" + name + "\" is not known; accepted: trajectory, angles, vertical");
}

TrajectoryNode node_from(const json& row) {
  // [time, x, y, z, error x, error y, error z, bridged 0/1]: one row a node keeps files small.
  TrajectoryNode node;
  node.gps_time_s = row.at(0).get<double>();
  node.position = {row.at(1).get<double>(), row.at(2).get<double>(), row.at(3).get<double>()};
  node.standard_error_m = {row.at(4).get<float>(), row.at(5).get<float>(), row.at(6).get<float>()};
  node.bridged = row.at(7).get<int>() != 0;
  return node;
}

FlightLine line_from(const json& object, const std::string& file) {
  FlightLine line;
  line.id = object.at("id").get<std::uint32_t>();
  line.point_source_id = object.at("point_source_id").get<std::uint16_t>();
  line.scanner_channel = object.at("scanner_channel").get<std::uint8_t>();
  line.channel_in_user_data = object.at("channel_in_user_data").get<bool>();
  line.has_time = object.at("has_time").get<bool>();
  line.first_time_s = object.at("first_time_s").get<double>();
  line.last_time_s = object.at("last_time_s").get<double>();
  line.along_azimuth_deg = object.at("along_azimuth_deg").get<double>();
  line.across_azimuth_deg = object.at("across_azimuth_deg").get<double>();
  line.across_standard_error_deg = object.at("across_standard_error_deg").get<double>();
  line.scan_angle_sign = object.at("scan_angle_sign").get<int>();
  line.beam_source = beam_source_from(object.at("beam_source").get<std::string>(), file);
  line.beam_reason = object.at("beam_reason").get<std::string>();
  for (const json& row : object.at("nodes")) line.nodes.push_back(node_from(row));
  return line;
}

FlightLines read_json(const std::string& file) {
  check_input_file(file);
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file, "cannot be opened");
  try {
    const json document = json::parse(in);
    if (document.at("format").get<std::string>() != "cornice flight lines")
      throw InputError(file,
                       "is JSON but not flight lines; expected the .json or .gpkg that "
                       "cornice-flightlines writes");
    if (const int version = document.at("version").get<int>(); version != 1)
      throw InputError(file, "has version " + std::to_string(version) + "; this program reads 1");
    FlightLines result;
    result.crs_text = document.at("crs").get<std::string>();
    for (const json& object : document.at("lines")) result.lines.push_back(line_from(object, file));
    return result;
  } catch (const json::exception& problem) {
    throw InputError(file, std::string("is no whole flight-line file: ") + problem.what());
  }
}

using Dataset = std::unique_ptr<void, void (*)(GDALDatasetH)>;
using Feature = std::unique_ptr<std::remove_pointer_t<OGRFeatureH>, void (*)(OGRFeatureH)>;

/// A layer's fields by name; throws naming the first that is missing.
class Fields {
 public:
  Fields(GDALDatasetH dataset, const char* layer_name, const std::string& file)
      : file_(file), layer_name_(layer_name) {
    layer_ = GDALDatasetGetLayerByName(dataset, layer_name);
    if (layer_ == nullptr)
      throw InputError(file, std::string("has no layer \"") + layer_name +
                                 "\"; expected the file that cornice-flightlines writes");
    definition_ = OGR_L_GetLayerDefn(layer_);
  }
  OGRLayerH layer() const { return layer_; }
  int index(const char* name) const {
    const int i = OGR_FD_GetFieldIndex(definition_, name);
    if (i < 0)
      throw InputError(file_, "layer \"" + layer_name_ + "\" lacks field \"" + name + "\"");
    return i;
  }
  double number(OGRFeatureH feature, const char* name) const {
    return OGR_F_GetFieldAsDouble(feature, index(name));
  }
  int integer(OGRFeatureH feature, const char* name) const {
    return OGR_F_GetFieldAsInteger(feature, index(name));
  }
  std::string text(OGRFeatureH feature, const char* name) const {
    return OGR_F_GetFieldAsString(feature, index(name));
  }
  void for_each(const std::function<void(OGRFeatureH)>& use) const {
    OGR_L_ResetReading(layer_);
    while (true) {
      const Feature feature(OGR_L_GetNextFeature(layer_), OGR_F_Destroy);
      if (!feature) break;
      use(feature.get());
    }
  }

 private:
  std::string file_;
  std::string layer_name_;
  OGRLayerH layer_ = nullptr;
  OGRFeatureDefnH definition_ = nullptr;
};

FlightLine line_from(const Fields& fields, OGRFeatureH feature, const std::string& file) {
  FlightLine line;
  line.id = static_cast<std::uint32_t>(fields.integer(feature, "id"));
  line.point_source_id = static_cast<std::uint16_t>(fields.integer(feature, "point_source_id"));
  line.scanner_channel = static_cast<std::uint8_t>(fields.integer(feature, "scanner_channel"));
  line.channel_in_user_data = fields.integer(feature, "channel_in_user_data") != 0;
  line.has_time = fields.integer(feature, "has_time") != 0;
  line.first_time_s = fields.number(feature, "first_time_s");
  line.last_time_s = fields.number(feature, "last_time_s");
  line.along_azimuth_deg = fields.number(feature, "along_azimuth_deg");
  line.across_azimuth_deg = fields.number(feature, "across_azimuth_deg");
  line.across_standard_error_deg = fields.number(feature, "across_standard_error_deg");
  line.scan_angle_sign = fields.integer(feature, "scan_angle_sign");
  line.beam_source = beam_source_from(fields.text(feature, "beam_source"), file);
  line.beam_reason = fields.text(feature, "beam_reason");
  return line;
}

TrajectoryNode node_from(const Fields& fields, OGRFeatureH feature, const std::string& file) {
  const OGRGeometryH geometry = OGR_F_GetGeometryRef(feature);
  if (geometry == nullptr) throw InputError(file, "a node has no position");
  TrajectoryNode node;
  node.gps_time_s = fields.number(feature, "gps_time_s");
  node.position = {OGR_G_GetX(geometry, 0), OGR_G_GetY(geometry, 0), OGR_G_GetZ(geometry, 0)};
  node.standard_error_m = {static_cast<float>(fields.number(feature, "error_x_m")),
                           static_cast<float>(fields.number(feature, "error_y_m")),
                           static_cast<float>(fields.number(feature, "error_z_m"))};
  node.bridged = fields.integer(feature, "bridged") != 0;
  return node;
}

std::string crs_text_of(GDALDatasetH dataset) {
  const char* text = GDALGetMetadataItem(dataset, "CORNICE_CRS", nullptr);
  return text == nullptr ? "" : text;
}

FlightLines read_geopackage(const std::string& file) {
  check_input_file(file);
  GDALAllRegister();
  const Dataset dataset(
      GDALOpenEx(file.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, nullptr, nullptr, nullptr),
      [](GDALDatasetH open) { GDALClose(open); });
  if (!dataset) throw InputError(file, "cannot be opened as a GeoPackage");
  FlightLines result;
  result.crs_text = crs_text_of(dataset.get());
  const Fields lines(dataset.get(), "lines", file);
  std::map<std::uint32_t, std::size_t> index_of;
  lines.for_each([&](OGRFeatureH feature) {
    result.lines.push_back(line_from(lines, feature, file));
    index_of[result.lines.back().id] = result.lines.size() - 1;
  });
  const Fields nodes(dataset.get(), "nodes", file);
  nodes.for_each([&](OGRFeatureH feature) {
    const auto found = index_of.find(static_cast<std::uint32_t>(nodes.integer(feature, "line")));
    if (found == index_of.end()) throw InputError(file, "a node names a line that is not there");
    result.lines[found->second].nodes.push_back(node_from(nodes, feature, file));
  });
  return result;
}

void check_lines(const FlightLines& lines, const std::string& file) {
  for (const FlightLine& line : lines.lines) {
    const std::string name = "line " + std::to_string(line.id);
    if (line.beam_source == BeamSource::kTrajectory && line.nodes.size() < 2)
      throw InputError(file, name + " has a trajectory of fewer than 2 nodes");
    for (std::size_t i = 1; i < line.nodes.size(); ++i)
      if (!(line.nodes[i].gps_time_s > line.nodes[i - 1].gps_time_s))
        throw InputError(file, name + " has nodes out of time order");
  }
}

}  // namespace

FlightLines read_flight_lines(const std::filesystem::path& path) {
  const std::string file = path.string();
  const std::string extension = path.extension().string();
  FlightLines lines;
  if (extension == ".json")
    lines = read_json(file);
  else if (extension == ".gpkg")
    lines = read_geopackage(file);
  else
    throw InputError(file, "flight lines are read from .json or .gpkg");
  check_lines(lines, file);
  return lines;
}

}  // namespace cornice
