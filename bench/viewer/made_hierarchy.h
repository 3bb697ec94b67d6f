// SPDX-License-Identifier: GPL-3.0-or-later
// Hierarchies for the viewer to be measured on: a made mountain, built as cornice-hlod builds.
#pragma once

#include <cstdint>
#include <filesystem>

namespace cornice::bench {

/// Writes a hierarchy of about so many triangles of 1 m, `folder` being for what is too large for
/// memory. The ground is the same for any number of triangles, but for where it ends.
void make_hierarchy(const std::filesystem::path& path, std::uint64_t triangles,
                    const std::filesystem::path& folder, std::uint64_t seed, int threads);

}  // namespace cornice::bench
