// SPDX-License-Identifier: GPL-3.0-or-later
// The three kinds of sources.
#pragma once

#include <memory>

#include "core/base/error.h"
#include "stages/compare/source.h"

namespace cornice::compare {

std::unique_ptr<Source> open_meshes(SourceFacts facts, std::uint64_t cache_bytes, int threads);
std::unique_ptr<Source> open_dems(SourceFacts facts, std::uint64_t cache_bytes);
std::unique_ptr<Source> open_clouds(SourceFacts facts, const Options& options,
                                    std::uint64_t cache_bytes);

/// Takes over the first file's system; throws InputError where a further file has another one, and
/// for systems in feet or degrees.
void join_crs(SourceFacts& facts, const std::filesystem::path& file, const Crs& crs);

/// The origin of a frame for what lies in `box` at about `height`: whole metres.
Vec3d frame_of(const Box2d& box, double height);

}  // namespace cornice::compare
