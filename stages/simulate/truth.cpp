// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/simulate/truth.h"

#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numbers>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/base/write_problem.h"

namespace cornice::simulate {
namespace {

constexpr double kNodeStepS = 0.1;
/// Room in the header for the number of points, which is known at the end only.
constexpr std::size_t kCountDigits = 20;

double degrees(double radians) { return radians * (180.0 / std::numbers::pi); }
double azimuth_of(Vec3d v) {
  const double azimuth = degrees(std::atan2(v.x, v.y));
  return azimuth < 0.0 ? azimuth + 360.0 : azimuth;
}

template <class T>
void put(std::vector<char>& bytes, T value) {
  const auto* raw = reinterpret_cast<const char*>(&value);
  bytes.insert(bytes.end(), raw, raw + sizeof value);
}
void put(std::vector<char>& bytes, Vec3f v) { put(bytes, v.x), put(bytes, v.y), put(bytes, v.z); }

[[noreturn]] void cannot_write(const std::filesystem::path& path) {
  throw RunError(path.string(), "cannot be written: " + write_problem(errno));
}

}  // namespace

std::vector<LineTruth> line_truths(const Trajectory& trajectory,
                                   const std::vector<SurveyLine>& lines,
                                   const std::vector<LineTally>& tallies,
                                   const DefectOptions& defects, double mean_ground_m) {
  assert(lines.size() == tallies.size());
  std::vector<LineTruth> truths;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::size_t pass_index = static_cast<std::size_t>(lines[i].pass);
    const Pass& pass = trajectory.passes()[pass_index];
    LineTruth truth{lines[i], tallies[i], 0, 0, 0, 0, pass.is_cross_line, {}};
    double first = pass.first_time_s, last = pass.last_time_s;
    if (tallies[i].points > 1 && tallies[i].true_last_time_s > tallies[i].true_first_time_s) {
      first = tallies[i].true_first_time_s;
      last = tallies[i].true_last_time_s;
    }
    const Vec3d way =
        trajectory.at(pass_index, last).position - trajectory.at(pass_index, first).position;
    truth.course_deg = azimuth_of(way);
    truth.speed_ms = std::hypot(way.x, way.y) / (last - first);
    // One node before and after the points, so that every point has a neighbour on both sides.
    const double begin = std::max(pass.first_time_s, first - kNodeStepS);
    const double end = std::min(pass.last_time_s, last + kNodeStepS);
    const int steps = std::max(1, static_cast<int>(std::ceil((end - begin) / kNodeStepS)));
    Vec3d heading;
    double height = 0.0, earlier = 0.0;
    for (int n = 0; n <= steps; ++n) {
      const double t = n == steps ? end : begin + n * kNodeStepS;
      const SensorFrame frame = trajectory.at(pass_index, t);
      heading += frame.forward;
      height += frame.position.z - mean_ground_m;
      double recorded = recorded_time(defects, t);
      if (recorded < earlier) recorded += kWeekS;
      earlier = recorded;
      truth.nodes.push_back({recorded, frame.position});
    }
    truth.heading_deg = azimuth_of(heading);
    truth.height_m = height / (steps + 1);
    truths.push_back(std::move(truth));
  }
  return truths;
}

void write_trajectory_csv(const std::filesystem::path& path, const Trajectory& trajectory,
                          const DefectOptions& defects) {
  AtomicFile file(path);
  errno = 0;
  std::ofstream stream(file.path(), std::ios::binary | std::ios::trunc);
  stream << "gps_time_s,recorded_time_s,pass,x_m,y_m,z_m,roll_deg,pitch_deg,heading_deg\n";
  char row[256];
  for (const TrajectoryPose& pose : trajectory.poses()) {
    const int length = std::snprintf(
        row, sizeof row, "%.7f,%.7f,%d,%.5f,%.5f,%.5f,%.7f,%.7f,%.7f\n", pose.gps_time_s,
        recorded_time(defects, pose.gps_time_s), pose.pass + 1, pose.position.x, pose.position.y,
        pose.position.z, pose.roll_deg, pose.pitch_deg, pose.heading_deg);
    stream.write(row, length);
  }
  stream.close();
  if (!stream) cannot_write(path);
  file.commit();
}

TruthPly::TruthPly(const std::filesystem::path& path, Vec3d origin, const std::string& crs_text)
    : file_(path), origin_(origin), crs_text_(crs_text) {
  errno = 0;
  stream_.open(file_.path(), std::ios::binary | std::ios::trunc);
  stream_ << header();
  check();
}

std::string TruthPly::header() const {
  char origin[120], count[40];
  std::snprintf(origin, sizeof origin, "%.3f %.3f %.3f", origin_.x, origin_.y, origin_.z);
  std::snprintf(count, sizeof count, "%llu", static_cast<unsigned long long>(count_));
  // A comment takes up what the number of points leaves over, so that the header keeps its length.
  const std::string filler(kCountDigits - std::strlen(count), '.');
  std::string text = "ply\nformat binary_little_endian 1.0\ncomment cornice origin ";
  text += origin;
  text += "\ncomment cornice crs " + crs_text_;
  text += "\ncomment true position, normal and beam of every point of the tile, in its order";
  text += "\ncomment " + filler + "\nelement vertex " + count + "\n";
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "beam_x", "beam_y", "beam_z"})
    text += std::string("property float ") + name + "\n";
  return text + "property uchar surface\nproperty ushort line_id\nend_header\n";
}

void TruthPly::append_row(const SurveyPoint& point, Vec3d origin, std::vector<char>& rows) {
  put(rows, (point.truth() - origin).cast<float>());
  put(rows, point.normal);
  put(rows, point.beam);
  put(rows, point.surface);
  put(rows, point.line);
}

void TruthPly::write(const std::vector<char>& rows) {
  constexpr std::size_t kRowBytes = 9 * sizeof(float) + 3;
  count_ += rows.size() / kRowBytes;
  stream_.write(rows.data(), static_cast<std::streamsize>(rows.size()));
  check();
}

void TruthPly::close() {
  stream_.seekp(0);
  stream_ << header();
  stream_.close();
  check();
  file_.commit();
}

void TruthPly::check() {
  if (!stream_) cannot_write(file_.target());
}

std::vector<ExtraByte> truth_extra_bytes() {
  std::vector<ExtraByte> entries;
  std::size_t offset = 0;
  const auto add = [&](const char* name, const char* description, std::uint8_t type,
                       std::size_t size) {
    ExtraByte entry;
    entry.name = name;
    entry.description = description;
    entry.data_type = type;
    entry.offset = offset;
    entry.size = size;
    offset += size;
    entries.push_back(entry);
  };
  for (const char* name : {"true_dx", "true_dy", "true_dz"})
    add(name, "true minus recorded, m", 9, sizeof(float));
  for (const char* name : {"normal_x", "normal_y", "normal_z"})
    add(name, "true normal", 9, sizeof(float));
  for (const char* name : {"beam_x", "beam_y", "beam_z"}) add(name, "true beam", 9, sizeof(float));
  add("surface", "what was hit", 1, 1);
  add("line_id", "true flight line", 3, 2);
  return entries;
}

std::size_t truth_extra_size() { return 9 * sizeof(float) + 3; }

void append_truth_extra_bytes(const SurveyPoint& point, std::vector<std::uint8_t>& bytes) {
  const auto put_bytes = [&bytes](const auto& value) {
    const auto* raw = reinterpret_cast<const std::uint8_t*>(&value);
    bytes.insert(bytes.end(), raw, raw + sizeof value);
  };
  for (Vec3f v : {point.true_offset, point.normal, point.beam})
    put_bytes(v.x), put_bytes(v.y), put_bytes(v.z);
  put_bytes(point.surface);
  put_bytes(point.line);
}

}  // namespace cornice::simulate
