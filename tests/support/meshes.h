// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes of known shape.
#pragma once

#include <array>
#include <functional>
#include <set>

#include "core/mesh/mesh.h"

namespace cornice::test {

/// columns x rows vertices at surface(column, row), two triangles a cell, counter-clockwise seen
/// from where columns run right and rows up.
Mesh grid_mesh(int columns, int rows, const std::function<Vec3d(int column, int row)>& surface);

/// A square of side cells * step, corner at (x, y), heights given.
Mesh height_mesh(double x, double y, int cells, double step,
                 const std::function<double(double x, double y)>& height);

/// An icosahedron, `rounds` times cut into four, on a sphere round the origin; closed.
Mesh sphere_mesh(double radius, int rounds);

/// Ground that folds over itself: a ledge of `depth` metres that leans out over the ground below.
/// The profile is a curve in x and z, the same for all y; x in [0, length], y in [0, width].
Mesh overhang_mesh(double length, double width, double depth, double step);

/// Both ends of every open edge, x, y and z each, in the direction of its triangle.
std::set<std::array<float, 6>> border_edges(const Mesh& mesh);

}  // namespace cornice::test
