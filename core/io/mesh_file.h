// SPDX-License-Identifier: GPL-3.0-or-later
// Mesh files of any format that is read: .ply by our own reader, .obj and .stl by OpenMesh, .off.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "core/io/mesh_stream.h"
#include "core/mesh/mesh.h"

namespace cornice {

/// Extensions that are read, for messages: ".ply, .obj, .off, .stl"; ".ply" alone where this
/// program was built without OpenMesh.
std::string mesh_file_extensions();

/// Reads a whole mesh by its file's extension. Coordinates of OBJ and OFF are read as doubles, of
/// STL as floats; polygons become fans; normals, colours and texture coordinates of vertices go
/// along where every vertex has one. Throws InputError, naming line or element, for what is not
/// whole, not finite or of no known format, and where OpenMesh is needed and not built in.
Mesh read_mesh(const std::filesystem::path& path);

/// The same piece by piece. What is no PLY has to fit into options.vertex_bytes: RunError
/// otherwise.
std::unique_ptr<MeshStream> open_mesh_stream(const std::filesystem::path& path,
                                             const MeshStreamOptions& options);

/// About how many triangles a file holds, from its header or size alone.
std::uint64_t estimated_triangles(const std::filesystem::path& path);

}  // namespace cornice
