// SPDX-License-Identifier: GPL-3.0-or-later
// Turk 1994, "The PLY Polygon File Format". docs/formats/ply.md describes what is written.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <stdexcept>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/write_problem.h"
#include "core/io/ply.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;

// Records that stay in the second-level cache while their columns are put together.
constexpr std::size_t kBlockRecords = 8192;
constexpr std::size_t kTriangleBytes = 13;

static_assert(std::endian::native == std::endian::little, "values are copied as they are");

/// One column of the vertex records: `bytes` of every item from `from` on.
struct Column {
  const void* from = nullptr;
  std::size_t bytes = 0;
};

/// A file that is written front to back. Throws RunError where that fails.
class OutputFile {
 public:
  OutputFile(const fs::path& path, const fs::path& shown_as)
      : shown_as_(shown_as),
        file_(open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) {
    if (file_ < 0) fail();
  }
  ~OutputFile() {
    if (file_ >= 0) ::close(file_);
  }
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(const void* from, std::size_t bytes) {
    const auto* at = static_cast<const std::uint8_t*>(from);
    while (bytes > 0) {
      const ssize_t written = ::write(file_, at, bytes);
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) fail();
      at += written;
      bytes -= static_cast<std::size_t>(written);
    }
  }
  void close() {
    const int file = file_;
    file_ = -1;
    if (::close(file) != 0) fail();
  }

 private:
  [[noreturn]] void fail() const {
    throw RunError(shown_as_.string(), "cannot be written: " + write_problem(errno));
  }

  const fs::path& shown_as_;
  int file_;
};

std::string number_text(double value) {
  std::array<char, 64> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return std::string(text.data(), end);
}

/// Header lines and columns of the vertex element.
class VertexWriter {
 public:
  VertexWriter(const fs::path& path, std::size_t count) : path_(path), count_(count) {}

  void add_vectors(const std::array<const char*, 3>& names, const std::vector<Vec3f>& vectors) {
    if (vectors.empty() && count_ > 0) return;
    check_size(names[0], vectors.size());
    for (std::size_t i = 0; i < vectors.size(); ++i) {
      const Vec3f& v = vectors[i];
      if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) {
        throw RunError(path_.string(), "cannot be written: vertex " + std::to_string(i) +
                                           " has a " + names[0] + ", " + names[1] + " or " +
                                           names[2] + " that is not finite");
      }
    }
    for (const char* name : names) add_line("float", name);
    columns_.push_back({vectors.data(), sizeof(Vec3f)});
  }

  template <class T>
  void add_values(const char* type, const std::string& name, const std::vector<T>& values) {
    check_size(name, values.size());
    add_line(type, name);
    columns_.push_back({values.data(), sizeof(T)});
  }

  const std::string& header() const { return header_; }

  void write(OutputFile& file) const {
    std::size_t record_bytes = 0;
    for (const Column& column : columns_) record_bytes += column.bytes;
    std::vector<std::uint8_t> block(std::min(kBlockRecords, count_) * record_bytes);
    for (std::size_t row = 0; row < count_; row += kBlockRecords) {
      const std::size_t rows = std::min(kBlockRecords, count_ - row);
      std::size_t offset = 0;
      for (const Column& column : columns_) {
        const auto* from = static_cast<const std::uint8_t*>(column.from) + row * column.bytes;
        interleave(from, column.bytes, block.data() + offset, record_bytes, rows);
        offset += column.bytes;
      }
      file.write(block.data(), rows * record_bytes);
    }
  }

 private:
  static void interleave(const std::uint8_t* from, std::size_t bytes, std::uint8_t* to,
                         std::size_t record_bytes, std::size_t rows) {
    switch (bytes) {
      case 12:
        return interleave_fixed<12>(from, to, record_bytes, rows);
      case 4:
        return interleave_fixed<4>(from, to, record_bytes, rows);
      case 2:
        return interleave_fixed<2>(from, to, record_bytes, rows);
      default:
        return interleave_fixed<1>(from, to, record_bytes, rows);
    }
  }
  template <std::size_t bytes>
  static void interleave_fixed(const std::uint8_t* from, std::uint8_t* to, std::size_t record_bytes,
                               std::size_t rows) {
    for (std::size_t i = 0; i < rows; ++i) {
      std::memcpy(to + i * record_bytes, from + i * bytes, bytes);
    }
  }

  void check_size(const std::string& name, std::size_t size) const {
    if (size == count_) return;
    throw std::invalid_argument("property " + name + " has " + std::to_string(size) +
                                " values for " + std::to_string(count_) + " vertices");
  }

  void add_line(const char* type, const std::string& name) {
    const bool plain = !name.empty() && std::all_of(name.begin(), name.end(),
                                                    [](char c) { return c > ' ' && c <= '~'; });
    if (!plain || !names_.insert(name).second) {
      throw std::invalid_argument("'" + name + "' is no name for a property, or there twice");
    }
    header_ += std::string("property ") + type + " " + name + "\n";
  }

  const fs::path& path_;
  const std::size_t count_;
  std::string header_;
  std::vector<Column> columns_;
  std::set<std::string> names_;
};

}  // namespace

std::string ply_header_start(const Vec3d& origin, const std::string& crs_text,
                             std::uint64_t vertices) {
  if (!std::isfinite(origin.x) || !std::isfinite(origin.y) || !std::isfinite(origin.z)) {
    throw std::invalid_argument("the origin of a PLY file must be finite");
  }
  std::string crs = crs_text;
  // WKT may come in several lines; a comment has one.
  std::replace_if(
      crs.begin(), crs.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  text += "comment cornice origin " + number_text(origin.x) + " " + number_text(origin.y) + " " +
          number_text(origin.z) + "\n";
  if (!crs.empty()) text += "comment cornice crs " + crs + "\n";
  return text + "element vertex " + std::to_string(vertices) + "\n";
}

namespace {

void write_triangles(OutputFile& file, const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  std::vector<std::uint8_t> block(std::min(kBlockRecords, triangles.size()) * kTriangleBytes);
  for (std::size_t row = 0; row < triangles.size(); row += kBlockRecords) {
    const std::size_t rows = std::min(kBlockRecords, triangles.size() - row);
    for (std::size_t i = 0; i < rows; ++i) {
      std::uint8_t* at = block.data() + i * kTriangleBytes;
      *at = 3;
      std::memcpy(at + 1, triangles[row + i].data(), 12);
    }
    file.write(block.data(), rows * kTriangleBytes);
  }
}

void check_triangles(const fs::path& path, const Mesh& mesh) {
  // Readers take the indices as signed numbers of 32 bits.
  constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max();
  if (mesh.positions.size() > kMost) {
    throw RunError(path.string(), "a PLY mesh holds at most 2147483647 vertices; cut it");
  }
  std::uint32_t largest = 0;
  for (const auto& triangle : mesh.triangles) {
    largest = std::max({largest, triangle[0], triangle[1], triangle[2]});
  }
  if (!mesh.triangles.empty() && largest >= mesh.positions.size()) {
    throw std::invalid_argument("a triangle refers to vertex " + std::to_string(largest) + " of " +
                                std::to_string(mesh.positions.size()));
  }
}

}  // namespace

void write_ply(const fs::path& path, const Mesh& mesh) {
  check_triangles(path, mesh);
  VertexWriter vertices(path, mesh.positions.size());
  vertices.add_vectors({"x", "y", "z"}, mesh.positions);
  if (!mesh.normals.empty()) vertices.add_vectors({"nx", "ny", "nz"}, mesh.normals);
  for (const auto& property : mesh.float_properties) {
    vertices.add_values("float", property.name, property.values);
  }
  for (const auto& property : mesh.byte_properties) {
    vertices.add_values("uchar", property.name, property.values);
  }
  const std::string header = ply_header_start(mesh.origin, mesh.crs_text, mesh.positions.size()) +
                             vertices.header() + "element face " +
                             std::to_string(mesh.triangles.size()) +
                             "\nproperty list uchar int vertex_indices\nend_header\n";
  AtomicFile target(path);
  OutputFile file(target.path(), path);
  file.write(header.data(), header.size());
  vertices.write(file);
  write_triangles(file, mesh.triangles);
  file.close();
  target.commit();
}

void write_ply(const fs::path& path, const OrientedPoints& points) {
  VertexWriter vertices(path, points.positions.size());
  vertices.add_vectors({"x", "y", "z"}, points.positions);
  vertices.add_vectors({"nx", "ny", "nz"}, points.normals);
  if (points.normals.size() != points.positions.size()) {
    throw std::invalid_argument("oriented points need a normal each");
  }
  if (!points.quality.empty()) vertices.add_values("float", "quality", points.quality);
  for (const auto& property : points.float_properties) {
    vertices.add_values("float", property.name, property.values);
  }
  for (const auto& property : points.byte_properties) {
    vertices.add_values("uchar", property.name, property.values);
  }
  if (!points.line_id.empty()) vertices.add_values("ushort", "line_id", points.line_id);
  const std::string header =
      ply_header_start(points.origin, points.crs_text, points.positions.size()) +
      vertices.header() + "end_header\n";
  AtomicFile target(path);
  OutputFile file(target.path(), path);
  file.write(header.data(), header.size());
  vertices.write(file);
  file.close();
  target.commit();
}

}  // namespace cornice
