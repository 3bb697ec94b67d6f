// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes out of a hierarchy, for other programs.
#pragma once

#include "core/base/progress.h"
#include "core/mesh/mesh.h"
#include "hlod/file.h"
#include "hlod/select.h"

namespace cornice::hlod {

/// The coarsest level none of whose cells has an error above error_m; the finest where all have.
int level_for_error(const File& file, double error_m);

/// One level, whole: vertices of several cells are one. Normals, and as far as the hierarchy has
/// them support (metres), source, red, green, blue, s and t. Triangles in the order of their cells.
/// Throws InputError where a block is damaged or there are more than 2^32 - 1 vertices.
Mesh extract_level(const File& file, int level, int threads, Progress& progress = no_progress());

/// What is drawn for an eye with these radii, vertices where they are morphed to, triangles that
/// vanished left out.
Mesh extract_view(const File& file, const Tree& tree, const Radii& radii, FinePoint eye,
                  int threads, Progress& progress = no_progress());

}  // namespace cornice::hlod
