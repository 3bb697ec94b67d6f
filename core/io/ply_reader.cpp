// SPDX-License-Identifier: GPL-3.0-or-later
// Turk 1994, "The PLY Polygon File Format". docs/formats/ply.md says what we make of it.
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/io/ply.h"
#include "core/io/ply_header.h"
#include "core/io/ply_records.h"
#include "core/io/ply_stream.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;

struct Contents {
  PlyHeader header;
  PlyVertices vertices;
  PlyFaceReader::Triangles triangles;
};

Contents read_contents(const fs::path& path, bool with_faces) {
  Contents contents;
  contents.header = read_ply_header(path);
  const PlyHeader& header = contents.header;
  const PlyElement* vertex = ply_element(header, "vertex");
  const PlyElement* face = with_faces ? ply_element(header, "face") : nullptr;
  if (vertex == nullptr) throw InputError(path.string(), "has no vertices");
  if (with_faces && face == nullptr && ply_element(header, "tristrips") != nullptr) {
    throw InputError(path.string(), "holds triangle strips; save it with faces");
  }
  if (vertex->count > std::numeric_limits<std::uint32_t>::max()) {
    throw InputError(path.string(), "has more vertices than 32 bits can count");
  }
  PlyStream stream(path, header);
  std::size_t wanted = face == nullptr ? 1 : 2;
  for (const PlyElement& element : header.elements) {
    if (&element == vertex) {
      contents.vertices = read_ply_vertices(path, stream, header, element);
    } else if (&element == face) {
      contents.triangles =
          PlyFaceReader(stream, element, vertex->count, header.format == PlyFormat::kLittleEndian)
              .read();
    } else {
      skip_ply_element(stream, element);
      continue;
    }
    if (--wanted == 0) break;
  }
  Box3d box;
  add_to_box(path, contents.vertices, 0, box);
  const Vec3d shift = shift_for_floats(box);
  contents.header.origin += shift;
  settle_positions(path, contents.vertices, shift);
  return contents;
}

}  // namespace

Mesh read_ply_mesh(const fs::path& path) {
  Contents contents = read_contents(path, true);
  Mesh mesh = mesh_of_vertices(std::move(contents.vertices), contents.header.origin,
                               std::move(contents.header.crs_text));
  mesh.triangles = std::move(contents.triangles);
  return mesh;
}

OrientedPoints read_ply_points(const fs::path& path) {
  Contents contents = read_contents(path, false);
  if (contents.vertices.normals.empty() && !contents.vertices.positions.empty()) {
    throw InputError(path.string(), "its points have no normals nx, ny and nz");
  }
  OrientedPoints points;
  points.origin = contents.header.origin;
  points.crs_text = std::move(contents.header.crs_text);
  points.positions = std::move(contents.vertices.positions);
  points.normals = std::move(contents.vertices.normals);
  for (FloatProperty& property : contents.vertices.floats) {
    if (property.name == "quality" && points.quality.empty()) {
      points.quality = std::move(property.values);
    } else {
      points.float_properties.push_back(std::move(property));
    }
  }
  points.byte_properties = std::move(contents.vertices.bytes);
  points.line_id = std::move(contents.vertices.line_id);
  return points;
}

}  // namespace cornice