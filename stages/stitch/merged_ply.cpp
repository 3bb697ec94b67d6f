// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/merged_ply.h"

#include <array>
#include <charconv>
#include <cstring>
#include <fstream>
#include <limits>

#include "core/base/error.h"
#include "core/base/write_problem.h"
#include "core/mesh/select.h"

namespace cornice::stitch {
namespace {

namespace fs = std::filesystem;

/// Coordinates beyond this are written as doubles: a float is coarser than a quarter of a
/// millimetre there.
constexpr double kWideM = 2048.0;
constexpr std::uint64_t kMostVertices = std::numeric_limits<std::int32_t>::max();
/// The header is written first, before the counts are known, as long as it may get.
constexpr std::size_t kPadding = 10;

std::string number_text(double value) {
  std::array<char, 64> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return std::string(text.data(), end);
}

template <class T>
void append(std::vector<std::uint8_t>& record, T value) {
  const std::size_t at = record.size();
  record.resize(at + sizeof(T));
  std::memcpy(record.data() + at, &value, sizeof(T));
}

}  // namespace

MergedPly::MergedPly(fs::path path, Vec3d origin, std::string crs_text, double largest_m,
                     std::uint32_t class_count)
    : out_(path),
      faces_file_(path.string() + ".faces"),
      faces_(faces_file_.path()),
      origin_(origin),
      crs_text_(std::move(crs_text)),
      is_wide_(largest_m > kWideM),
      class_row_(class_count, kNone) {}

void MergedPly::take_schema(const Mesh& mesh) {
  has_schema_ = true;
  has_normals_ = !mesh.normals.empty();
  for (const FloatProperty& p : mesh.float_properties) floats_.push_back(p.name);
  for (const ByteProperty& p : mesh.byte_properties) bytes_.push_back(p.name);
  const std::string text = header(kMostVertices, std::numeric_limits<std::uint64_t>::max());
  out_.stream() << text << std::string(kPadding, ' ');
}

std::string MergedPly::header(std::uint64_t vertices, std::uint64_t triangles) const {
  const char* type = is_wide_ ? "double" : "float";
  std::string text = "ply\nformat binary_little_endian 1.0\ncomment cornice origin " +
                     number_text(origin_.x) + " " + number_text(origin_.y) + " " +
                     number_text(origin_.z) + "\n";
  if (!crs_text_.empty()) text += "comment cornice crs " + crs_text_ + "\n";
  text += "element vertex " + std::to_string(vertices) + "\n";
  for (const char* axis : {"x", "y", "z"}) {
    text += std::string("property ") + type + " " + axis + "\n";
  }
  if (has_normals_) text += "property float nx\nproperty float ny\nproperty float nz\n";
  for (const std::string& name : floats_) text += "property float " + name + "\n";
  for (const std::string& name : bytes_) text += "property uchar " + name + "\n";
  return text + "element face " + std::to_string(triangles) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

void MergedPly::add_vertex(const Mesh& mesh, std::uint32_t row) {
  record_.clear();
  const Vec3d p = mesh.origin - origin_ + mesh.positions[row].cast<double>();
  for (const double x : {p.x, p.y, p.z}) {
    if (is_wide_) {
      append(record_, x);
    } else {
      append(record_, static_cast<float>(x));
    }
  }
  if (has_normals_) append(record_, mesh.normals.empty() ? Vec3f{} : mesh.normals[row]);
  for (const std::string& name : floats_) {
    const std::vector<float>* values = find_float_property(mesh, name.c_str());
    append(record_, values == nullptr ? 0.0f : (*values)[row]);
  }
  for (const std::string& name : bytes_) {
    const std::vector<std::uint8_t>* values = find_byte_property(mesh, name.c_str());
    append(record_, values == nullptr ? std::uint8_t{0} : (*values)[row]);
  }
  out_.put(record_);
  ++vertices_;
}

void MergedPly::add(const EditedTile& tile) {
  const Mesh& mesh = tile.mesh;
  if (mesh.triangles.empty()) return;
  if (!has_schema_) take_schema(mesh);
  std::vector<std::uint32_t> to(mesh.positions.size(), kNone);
  auto shared = tile.shared.begin();
  for (std::uint32_t row = 0; row < to.size(); ++row) {
    const bool is_shared = shared != tile.shared.end() && shared->first == row;
    const std::uint32_t c = is_shared ? (shared++)->second : kNone;
    if (c != kNone && class_row_[c] != kNone) {
      to[row] = class_row_[c];
      continue;
    }
    if (vertices_ == kMostVertices) {
      throw RunError(out_.name(), "would have more than 2147483647 vertices; write tiles instead");
    }
    to[row] = static_cast<std::uint32_t>(vertices_);
    if (c != kNone) class_row_[c] = to[row];
    add_vertex(mesh, row);
  }
  std::array<char, 13> face{};
  face[0] = 3;
  for (const auto& t : mesh.triangles) {
    const std::array<std::uint32_t, 3> corners{to[t[0]], to[t[1]], to[t[2]]};
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    std::memcpy(face.data() + 1, corners.data(), 12);
    faces_.sputn(face.data(), face.size());
    ++triangles_;
  }
}

void MergedPly::append_faces() {
  faces_.close();
  if (faces_.error() != 0) {
    throw RunError(out_.name(),
                   "its triangles cannot be written beside it: " + write_problem(faces_.error()));
  }
  std::ifstream faces(faces_file_.path(), std::ios::binary);
  std::vector<std::uint8_t> block(std::size_t{1} << 20);
  while (faces) {
    faces.read(reinterpret_cast<char*>(block.data()), static_cast<std::streamsize>(block.size()));
    out_.put({block.data(), static_cast<std::size_t>(faces.gcount())});
  }
}

void MergedPly::commit() {
  if (!has_schema_) take_schema(Mesh{});
  append_faces();
  std::string text = header(vertices_, triangles_);
  const std::size_t length =
      header(kMostVertices, std::numeric_limits<std::uint64_t>::max()).size() + kPadding;
  const std::string end = "end_header\n";
  text.resize(text.size() - end.size());
  // "comment", blanks and the end of the line make up for counts shorter than they may be.
  const std::size_t padding = length - text.size() - end.size();
  text += "comment" + std::string(padding - 8, ' ') + "\n" + end;
  out_.seek(0);
  out_.stream() << text;
  out_.check();
  out_.commit();
}

}  // namespace cornice::stitch
