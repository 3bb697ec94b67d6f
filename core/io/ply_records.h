// SPDX-License-Identifier: GPL-3.0-or-later
// The vertices and faces of a PLY file, as many at a time as its reader wants.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "core/io/ply_header.h"
#include "core/io/ply_stream.h"
#include "core/mesh/mesh.h"

namespace cornice {

/// Vertices of a file.
struct PlyVertices {
  std::vector<Vec3f> positions;
  std::vector<Vec3d> wide_positions;  ///< instead of positions, where the file has them wider
  std::vector<Vec3f> normals;
  std::vector<FloatProperty> floats;
  std::vector<ByteProperty> bytes;
  std::vector<std::uint16_t> line_id;
};

/// The element of a name, or nullptr.
const PlyElement* ply_element(const PlyHeader& header, const char* name);

/// Whether positions need more than a float; then shift_for_floats has to see all of them.
bool ply_positions_are_wide(const PlyHeader& header, const PlyElement& element);

/// Reads element.count vertices from where the stream is; first_row is the number of the first, for
/// messages.
PlyVertices read_ply_vertices(const std::filesystem::path& path, PlyStream& stream,
                              const PlyHeader& header, const PlyElement& element,
                              std::uint64_t first_row = 0);

/// Adds the wide positions to a box. Throws InputError where one is not finite.
void add_to_box(const std::filesystem::path& path, const PlyVertices& vertices,
                std::uint64_t first_row, Box3d& box);

/// What to take from wide positions so that floats hold the rest well enough.
Vec3d shift_for_floats(const Box3d& box);

/// Turns wide positions into floats, and refuses what is not finite.
void settle_positions(const std::filesystem::path& path, PlyVertices& vertices, const Vec3d& shift,
                      std::uint64_t first_row = 0);

/// A mesh of settled vertices, without triangles.
Mesh mesh_of_vertices(PlyVertices vertices, const Vec3d& origin, std::string crs_text);

/// Reads the face element into triangles, polygons as fans of their first corner. Stream and
/// element must outlive it.
class PlyFaceReader {
 public:
  using Triangles = std::vector<std::array<std::uint32_t, 3>>;

  PlyFaceReader(PlyStream& stream, const PlyElement& element, std::uint64_t vertex_count,
                bool little_endian);

  /// The next triangles, fewer than `limit` only at the end.
  Triangles read(std::size_t limit = std::numeric_limits<std::size_t>::max());

 private:
  std::uint64_t read_common(std::size_t limit);
  void read_any(std::uint64_t face);
  void read_polygon(const PlyProperty& list);
  std::uint32_t read_index(PlyType type);

  PlyStream& stream_;
  const PlyElement& element_;
  const std::uint64_t vertex_count_;
  std::uint64_t face_ = 0;  ///< the next one
  std::size_t list_ = 0;
  bool is_common_ = false;
  Triangles triangles_;
};

void skip_ply_element(PlyStream& stream, const PlyElement& element);

}  // namespace cornice
