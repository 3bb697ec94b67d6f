// SPDX-License-Identifier: GPL-3.0-or-later
// Curve: Catmull and Rom, "A class of local interpolating splines", 1974, for unequal times.
#include "terrain-viewer/scene/camera_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/input_file.h"

namespace cornice::viewer {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

json read_document(const std::filesystem::path& path) {
  check_input_file(path);
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path.string(), "cannot be opened");
  try {
    return json::parse(in);
  } catch (const json::exception& error) {
    throw InputError(path.string(), std::string("is not JSON: ") + error.what());
  }
}

/// No projection has coordinates beyond, metres.
constexpr double kFarthestM = 1e8;

/// where: what precedes the key's name in an error, such as "keys[2].".
double number(const json& object, const char* key, double lowest, double highest,
              const std::string& file, const std::string& where = "") {
  const auto found = object.find(key);
  std::string problem;
  if (found == object.end())
    problem = "is missing";
  else if (!found->is_number() || found->get<double>() < lowest || found->get<double>() > highest)
    problem = "is " + found->dump();
  if (problem.empty()) return found->get<double>();
  throw InputError(file, "\"" + where + key + "\" " + problem + "; accepted: a number from " +
                             ordered_json(lowest).dump() + " to " + ordered_json(highest).dump());
}

Camera camera_from(const json& object, const std::string& file, const std::string& where = "") {
  if (!object.is_object())
    throw InputError(
        file, (where.empty() ? "a camera" : "\"" + where.substr(0, where.size() - 1) + "\"") +
                  " is to be an object with \"eye\", \"heading_deg\", \"pitch_deg\" "
                  "and \"field_of_view_deg\"");
  const auto eye = object.find("eye");
  const auto is_coordinate = [](const json& v) {
    return v.is_number() && std::abs(v.get<double>()) <= kFarthestM;
  };
  if (eye == object.end() || !eye->is_array() || eye->size() != 3 ||
      !std::all_of(eye->begin(), eye->end(), is_coordinate))
    throw InputError(file, "\"" + where +
                               "eye\" is to be [easting, northing, height] in metres, each within "
                               "100,000 km of 0");
  Camera camera;
  camera.eye = {eye->at(0).get<double>(), eye->at(1).get<double>(), eye->at(2).get<double>()};
  camera.heading_deg = number(object, "heading_deg", -360.0, 360.0, file, where);
  camera.pitch_deg = number(object, "pitch_deg", -90.0, 90.0, file, where);
  camera.field_of_view_deg = number(object, "field_of_view_deg", 1.0, 150.0, file, where);
  return camera;
}

ordered_json json_of(const Camera& camera) {
  return {{"eye", {camera.eye.x, camera.eye.y, camera.eye.z}},
          {"heading_deg", camera.heading_deg},
          {"pitch_deg", camera.pitch_deg},
          {"field_of_view_deg", camera.field_of_view_deg}};
}

/// Tangent of the curve at key i, per second.
Vec3d tangent(const std::vector<CameraPath::Key>& keys, std::size_t i) {
  const std::size_t before = i == 0 ? 0 : i - 1;
  const std::size_t after = std::min(i + 1, keys.size() - 1);
  const double span = keys[after].time_s - keys[before].time_s;
  return (keys[after].camera.eye - keys[before].camera.eye) / span;
}

}  // namespace

Camera read_camera(const std::filesystem::path& path) {
  return camera_from(read_document(path), path.string());
}

void write_camera(const std::filesystem::path& path, const Camera& camera) {
  write_file_atomically(path, json_of(camera).dump(1) + "\n");
}

Camera CameraPath::at(double time_s) const {
  if (time_s <= keys.front().time_s) return keys.front().camera;
  if (time_s >= keys.back().time_s) return keys.back().camera;
  const auto next = std::upper_bound(keys.begin(), keys.end(), time_s,
                                     [](double t, const Key& key) { return t < key.time_s; });
  const auto i = static_cast<std::size_t>(next - keys.begin()) - 1;
  const double span = keys[i + 1].time_s - keys[i].time_s;
  const double t = (time_s - keys[i].time_s) / span;
  Camera camera = between(keys[i].camera, keys[i + 1].camera, t);
  // Hermite's cubic with the tangents at both keys.
  const double t2 = t * t, t3 = t2 * t;
  camera.eye = (2 * t3 - 3 * t2 + 1) * keys[i].camera.eye +
               (t3 - 2 * t2 + t) * span * tangent(keys, i) +
               (3 * t2 - 2 * t3) * keys[i + 1].camera.eye + (t3 - t2) * span * tangent(keys, i + 1);
  return camera;
}

CameraPath read_camera_path(const std::filesystem::path& path) {
  const std::string file = path.string();
  const json document = read_document(path);
  if (!document.is_object() || !document.contains("keys") || !document["keys"].is_array() ||
      document["keys"].empty())
    throw InputError(file, "\"keys\" is to be a list of cameras with \"time_s\"");
  CameraPath cameras;
  if (document.contains("frames_per_second"))
    cameras.frames_per_second = number(document, "frames_per_second", 0.01, 1000.0, file);
  for (const json& key : document["keys"]) {
    const std::string where = "keys[" + std::to_string(cameras.keys.size()) + "]";
    const Camera camera = camera_from(key, file, where + ".");
    const double time = number(key, "time_s", 0.0, 1e6, file, where + ".");
    if (!cameras.keys.empty() && time <= cameras.keys.back().time_s)
      throw InputError(file,
                       "\"" + where + ".time_s\" is " + key["time_s"].dump() +
                           ", no later than the key before; time has to rise from key to key");
    cameras.keys.push_back({time, camera});
  }
  return cameras;
}

void write_camera_path(const std::filesystem::path& path, const CameraPath& cameras) {
  ordered_json document{{"frames_per_second", cameras.frames_per_second},
                        {"keys", ordered_json::array()}};
  for (const CameraPath::Key& key : cameras.keys) {
    ordered_json object{{"time_s", key.time_s}};
    object.update(json_of(key.camera));
    document["keys"].push_back(std::move(object));
  }
  write_file_atomically(path, document.dump(1) + "\n");
}

}  // namespace cornice::viewer
