// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes for other programs: Wavefront OBJ and binary glTF 2.0 beside PLY.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

#include "core/mesh/mesh.h"

namespace cornice {

/// Writes .ply, .obj or .glb by extension, atomically. OBJ and GLB hold positions relative to
/// `frame`, because their readers take them for floats: several meshes of one frame lie beside each
/// other.
/// - OBJ: positions to a tenth of a millimetre and normals as text; east, north, up; frame and CRS
/// in
///   comments. No attributes.
/// - GLB: positions relative to the mesh's own origin, east, up, south as glTF has it; the node is
///   moved by origin - frame. Its extras hold origin, frame and CRS. Attributes become _SUPPORT and
///   the like, of floats.
/// Throws UsageError for other extensions, RunError where it cannot be written.
void export_mesh(const std::filesystem::path& path, const Mesh& mesh, Vec3d frame);
/// With the mesh's own origin as frame.
void export_mesh(const std::filesystem::path& path, const Mesh& mesh);

/// Lines of an OBJ file, for those who write one piece by piece. Corners count from 1.
std::string obj_comments(Vec3d frame, const std::string& crs_text);
std::string obj_vector(const char* word, Vec3d v);
std::string obj_face(const std::array<std::uint64_t, 3>& corners, bool with_normals);

/// True for the three extensions.
bool is_mesh_extension(const std::filesystem::path& path);

}  // namespace cornice
