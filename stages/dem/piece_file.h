// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "core/base/progress.h"
#include "core/base/vec.h"
#include "stages/dem/grid_surface.h"

namespace cornice::dem {

/// What a mesh file says beside its triangles.
struct PieceFrame {
  Vec3d origin;
  std::string crs_text;
  /// Point that OBJ and GLB positions are relative to, the same for all pieces of a survey.
  Vec3d frame;
};

/// Writes a surface to .ply, .obj or .glb by extension, atomically. PLY is made and written in
/// blocks of rows; the others are put together in memory. Throws RunError where it cannot be
/// written.
void write_piece(const std::filesystem::path& path, const GridSurface& surface,
                 const VertexPlaces& places, const PieceFrame& frame, int threads,
                 Progress& progress);

/// Memory that this needs beside the surface, of so many own pixels.
std::uint64_t writing_bytes(const std::string& format, std::uint64_t pixels);

}  // namespace cornice::dem
