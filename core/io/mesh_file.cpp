// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/io/mesh_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/base/input_file.h"
#include "core/io/mesh_import.h"
#include "core/io/ply.h"

namespace cornice {
namespace {

namespace fs = std::filesystem;

/// Memory that reading a text or STL file takes at most, for each byte of the file: a short line of
/// a face becomes 12 bytes, and vectors grow by doubling.
constexpr std::uint64_t kImportBytes = 3;

std::string extension_of(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool is_ply(const fs::path& path) { return extension_of(path) == ".ply"; }

std::uint64_t size_of(const fs::path& path) {
  check_input_file(path);
  return fs::file_size(path);
}

std::string gib(std::uint64_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f GiB", static_cast<double>(bytes) / 0x1p30);
  return text;
}

/// Throws where the extension is of no format that this program reads.
void check_format(const fs::path& path) {
  const std::string extension = extension_of(path);
  if (extension != ".obj" && extension != ".off" && extension != ".stl") {
    throw InputError(path.string(),
                     "is no mesh of a known format; known are " + mesh_file_extensions());
  }
  if (!can_import_meshes()) {
    throw InputError(path.string(),
                     "needs OpenMesh, which this program was built without; save the "
                     "mesh as .ply, or install libopenmesh-dev and build again");
  }
}

/// Positions as floats relative to a corner of their box.
Mesh settled(const fs::path& path, ImportedMesh&& imported) {
  Box3d box;
  for (std::size_t v = 0; v < imported.positions.size(); ++v) {
    const Vec3d& p = imported.positions[v];
    if (!(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z))) {
      throw InputError(path.string(),
                       "vertex " + std::to_string(v) + " is not finite; repair the mesh");
    }
    box.add(p);
  }
  Mesh mesh = std::move(imported.mesh);
  if (!box.empty()) {
    mesh.origin = {std::floor(box.min.x), std::floor(box.min.y), std::floor(box.min.z)};
  }
  mesh.positions.reserve(imported.positions.size());
  for (const Vec3d& p : imported.positions) {
    mesh.positions.push_back((p - mesh.origin).cast<float>());
  }
  return mesh;
}

}  // namespace

std::string mesh_file_extensions() {
  return can_import_meshes() ? ".ply, .obj, .off, .stl" : ".ply";
}

Mesh read_mesh(const fs::path& path) {
  if (is_ply(path)) return read_ply_mesh(path);
  check_format(path);
  size_of(path);
  return settled(path, import_mesh(path, extension_of(path)));
}

std::unique_ptr<MeshStream> open_mesh_stream(const fs::path& path,
                                             const MeshStreamOptions& options) {
  if (is_ply(path)) return open_ply_mesh_stream(path, options);
  check_format(path);
  const std::uint64_t bytes = kImportBytes * size_of(path);
  if (bytes > options.vertex_bytes) {
    throw RunError(path.string(), "may take " + gib(bytes) + " while it is read, and " +
                                      gib(options.vertex_bytes) +
                                      " are to be had; raise --memory, or save it as .ply, which "
                                      "is read piece by piece");
  }
  return stream_of_mesh(settled(path, import_mesh(path, extension_of(path))), options);
}

std::uint64_t estimated_triangles(const fs::path& path) {
  if (is_ply(path)) {
    // Faces may be polygons: no fewer triangles than the bytes of their lists would hold.
    const PlyInfo info = read_ply_info(path);
    return info.count("face");
  }
  check_format(path);
  // A triangle is 50 bytes in a binary STL; in a text with its share of the vertices no fewer.
  return size_of(path) / 25;
}

}  // namespace cornice
