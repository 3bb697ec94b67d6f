// SPDX-License-Identifier: GPL-3.0-or-later
// Parts of meshes, with their attributes.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/topology.h"

namespace cornice {

/// The mesh of those triangles whose byte in `keep` (#T) is not 0, without the vertices that no
/// such triangle names. Order and attributes are kept. `old_vertices`, where given, gets for every
/// vertex of the result its index in `mesh`.
Mesh select_triangles(const Mesh& mesh, const std::vector<std::uint8_t>& keep,
                      std::vector<std::uint32_t>* old_vertices = nullptr);

/// A mesh of the same origin, system and properties whose vertices are those of `mesh` at `rows`.
/// No triangles.
Mesh gather_vertices(const Mesh& mesh, const std::vector<std::uint32_t>& rows);

/// Area of each triangle in square metres.
double triangle_area(const Mesh& mesh, const Triangle& triangle);

/// The values of a property; nullptr where the mesh has none of that name.
const std::vector<float>* find_float_property(const Mesh& mesh, const char* name);
const std::vector<std::uint8_t>* find_byte_property(const Mesh& mesh, const char* name);

}  // namespace cornice
