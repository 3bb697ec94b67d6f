// SPDX-License-Identifier: GPL-3.0-or-later
// What OpenMesh's readers do not give: coordinates as doubles, the line of what is wrong, and OFF
// files with comments.
#pragma once

#include <filesystem>
#include <vector>

#include "core/base/vec.h"
#include "core/io/mesh_import.h"

namespace cornice {

/// The vertices of an OBJ file in their order. Throws InputError, naming the line, where a vertex
/// or a face is not whole or names a vertex that is not there, and where there are no vertices at
/// all.
std::vector<Vec3d> scan_obj(const std::filesystem::path& path);

/// All of an OFF file but colours and normals: of its comments OpenMesh makes counts. Throws as
/// scan_obj does.
ImportedMesh read_off(const std::filesystem::path& path);

/// Throws InputError where an STL file, of text or binary, ends early.
void check_stl(const std::filesystem::path& path);

}  // namespace cornice
