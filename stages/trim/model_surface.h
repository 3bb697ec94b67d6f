// SPDX-License-Identifier: GPL-3.0-or-later
// Which vertices of a surface lie on the ground of an elevation model.
#pragma once

#include <cstdint>
#include <vector>

#include "core/io/elevation_model.h"
#include "core/mesh/mesh.h"

namespace cornice::trim {

/// A byte per vertex: 1 where it is on the model, that is, where it lies within `tolerance_m` of
/// the model's surface, and looks up where the mesh has normals. That follows from its position and
/// normal alone, so tiles that share a vertex bit for bit agree on it.
std::vector<std::uint8_t> find_model_surface(const Mesh& mesh, const ElevationModel& model,
                                             double tolerance_m, int threads);

/// Box of the vertices in plan, projected.
Box2d plan_box(const Mesh& mesh);

}  // namespace cornice::trim
