// SPDX-License-Identifier: GPL-3.0-or-later
// From a scene description to the ground it describes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "stages/simulate/scene_field.h"
#include "stages/simulate/scene_file.h"

namespace cornice::simulate {

struct Ground {
  GroundField field;
  PlanField water;  ///< positive on water; no nodes where there is none
};

/// Ground over `area` (local: relative to the scene's centre). Within the description's own size
/// the ground at a place does not depend on the area. Throws InputError naming `file` where a cave
/// finds no rock.
std::unique_ptr<Ground> build_ground(const SceneDescription& scene, const Box2d& area,
                                     std::uint64_t seed, int threads,
                                     const std::filesystem::path& file);

/// Places of a shape at `at`: itself, and with `repeat_m` > 0 every copy within the area.
std::vector<Vec2d> repeated(Vec2d at, double repeat_m, const Box2d& area);

}  // namespace cornice::simulate
