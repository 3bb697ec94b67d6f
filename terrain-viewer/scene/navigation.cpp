// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/scene/navigation.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <sstream>

namespace cornice::viewer {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;
constexpr double kSteepestDeg = 89.9;

double wrapped(double heading_deg) {
  return std::fmod(std::fmod(heading_deg, 360.0) + 360.0, 360.0);
}

}  // namespace

Camera fly(const Camera& camera, const FlyInput& input, double speed_ms, double seconds_s) {
  const CameraAxes axes = axes_of(camera);
  const Vec3d way =
      input.forward * axes.forward + input.right * axes.right + input.up * Vec3d{0.0, 0.0, 1.0};
  Camera moved = camera;
  moved.eye += speed_ms * seconds_s * way;
  return moved;
}

Camera walk(const Camera& camera, const FlyInput& input, double speed_ms, double seconds_s) {
  Camera level = camera;
  level.pitch_deg = 0.0;
  level = fly(level, {input.forward, input.right, 0.0}, speed_ms, seconds_s);
  level.pitch_deg = camera.pitch_deg;
  return level;
}

Camera turn(const Camera& camera, double heading_deg, double pitch_deg) {
  Camera turned = camera;
  turned.heading_deg = wrapped(camera.heading_deg + heading_deg);
  turned.pitch_deg = std::clamp(camera.pitch_deg + pitch_deg, -kSteepestDeg, kSteepestDeg);
  return turned;
}

Camera orbit(const Camera& camera, Vec3d pivot, double heading_deg, double pitch_deg) {
  const CameraAxes before = axes_of(camera);
  const Vec3d way = pivot - camera.eye;
  Camera turned = turn(camera, heading_deg, pitch_deg);
  const CameraAxes after = axes_of(turned);
  // The pivot keeps its coordinates in the camera's frame.
  turned.eye = pivot - dot(way, before.right) * after.right - dot(way, before.up) * after.up -
               dot(way, before.forward) * after.forward;
  return turned;
}

Camera pan(const Camera& camera, Vec3d grabbed, int width, int height, double x, double y) {
  const CameraAxes axes = axes_of(camera);
  const double depth = dot(grabbed - camera.eye, axes.forward);
  const Vec3d ray = ray_of_pixel(camera, width, height, x, y);
  const Vec3d under_pixel = camera.eye + depth / dot(ray, axes.forward) * ray;
  Camera moved = camera;
  moved.eye += grabbed - under_pixel;
  return moved;
}

Camera zoom(const Camera& camera, Vec3d target, double factor, double nearest_m) {
  const Vec3d way = target - camera.eye;
  const double distance = norm(way);
  if (!(distance > 0.0)) return camera;
  const double wanted = std::max(distance * factor, std::min(nearest_m, distance));
  Camera moved = camera;
  moved.eye = target - wanted / distance * way;
  return moved;
}

Camera above_ground(const Camera& camera, const Ground& ground, double clearance_m) {
  Camera raised = camera;
  if (const auto z = ground(camera.eye.x, camera.eye.y))
    raised.eye.z = std::max(raised.eye.z, *z + clearance_m);
  return raised;
}

Camera on_ground(const Camera& camera, const Ground& ground, double eye_height_m) {
  Camera standing = camera;
  if (const auto z = ground(camera.eye.x, camera.eye.y)) standing.eye.z = *z + eye_height_m;
  return standing;
}

Camera seeing_all(const Camera& like, Vec3d lowest, Vec3d highest, double width_over_height) {
  Camera camera = like;
  camera.heading_deg = 0.0;
  camera.pitch_deg = -35.0;
  const Vec3d middle = 0.5 * (lowest + highest);
  const double radius = 0.5 * norm(highest - lowest);
  const double half_up = 0.5 * camera.field_of_view_deg * kRadians;
  const double half = std::min(half_up, std::atan(std::tan(half_up) * width_over_height));
  camera.eye = middle - std::max(1.0, radius / std::sin(half)) * axes_of(camera).forward;
  return camera;
}

void CameraHistory::add(const Camera& camera) {
  if (!cameras_.empty() && cameras_[present_] == camera) return;
  if (!cameras_.empty()) cameras_.resize(present_ + 1);
  cameras_.push_back(camera);
  if (cameras_.size() > kLimit) cameras_.erase(cameras_.begin());
  present_ = cameras_.size() - 1;
}

std::optional<Camera> CameraHistory::undo() {
  if (cameras_.empty() || present_ == 0) return std::nullopt;
  return cameras_[--present_];
}

std::optional<Camera> CameraHistory::redo() {
  if (present_ + 1 >= cameras_.size()) return std::nullopt;
  return cameras_[++present_];
}

std::optional<PlaceText> parse_place(const std::string& text) {
  std::string plain;
  bool has_letters = false, is_south = false, is_west = false;
  for (const char c : text) {
    const char upper = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    if (upper == 'N' || upper == 'E' || upper == 'S' || upper == 'W') {
      has_letters = true;
      is_south |= upper == 'S';
      is_west |= upper == 'W';
      plain += ' ';
    } else {
      plain += c == ',' || c == ';' ? ' ' : c;
    }
  }
  std::istringstream in(plain);
  std::vector<double> values;
  for (double value = 0.0; in >> value;) values.push_back(value);
  if (!in.eof() || values.size() < 2 || values.size() > 3) return std::nullopt;
  PlaceText place{values[0], values[1], std::nullopt, has_letters};
  if (values.size() == 3) place.z = values[2];
  if (std::abs(place.first) <= 90.0 && std::abs(place.second) <= 180.0) place.is_globe = true;
  if (has_letters && (std::abs(place.first) > 90.0 || std::abs(place.second) > 180.0))
    return std::nullopt;
  if (is_south) place.first = -place.first;
  if (is_west) place.second = -place.second;
  return place;
}

}  // namespace cornice::viewer
