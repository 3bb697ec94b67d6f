// SPDX-License-Identifier: GPL-3.0-or-later
// Files of hierarchies, built of a mesh as cornice-hlod builds them.
#pragma once

#include <filesystem>

#include "core/mesh/mesh.h"
#include "hlod/build.h"

namespace cornice::test {

/// Builds in memory and on one thread.
void write_hierarchy(const std::filesystem::path& path, const Mesh& mesh,
                     const hlod::BuildOptions& options);

}  // namespace cornice::test
