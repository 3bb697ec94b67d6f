// SPDX-License-Identifier: GPL-3.0-or-later
// OBJ, OFF and STL by OpenMesh, whose headers stay in one source file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/mesh.h"

namespace cornice {

/// A mesh whose positions have not yet become floats; those of `mesh` are empty.
struct ImportedMesh {
  std::vector<Vec3d> positions;
  Mesh mesh;
};

/// Whether this program was built with OpenMesh.
bool can_import_meshes();

/// Reads a file of the format that the extension (".obj", ".off" or ".stl") names. Faces go by as
/// they are in the file, whatever they do to a half-edge mesh. Throws InputError for what is not
/// whole.
ImportedMesh import_mesh(const std::filesystem::path& path, const std::string& extension);

}  // namespace cornice
