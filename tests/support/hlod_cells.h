// SPDX-License-Identifier: GPL-3.0-or-later
// Cells of hierarchies made up for tests.
#pragma once

#include "core/mesh/mesh.h"
#include "hlod/file.h"

namespace cornice::test {

/// A header with every attribute, cells of 64 m, finest level 3.
hlod::Header sample_header();

/// One cell of `level` made of a mesh: positions are rounded to the level's lattice; normals from
/// the mesh, attributes and parents made up, some of the parents at a vertex of the cell, some not.
/// At most 65535 vertices. Normals have to be there.
hlod::CellMesh sample_cell(const Mesh& mesh, const hlod::Header& header, hlod::CellKey key,
                           std::uint64_t seed);

/// Bumpy ground of columns x rows vertices about 1 m apart, with normals.
Mesh bumpy_ground(int columns, int rows, std::uint64_t seed);

/// The same mesh with vertices and parents numbered, and triangles turned and sorted, in an order
/// that depends on what they are alone.
hlod::CellMesh canonical(const hlod::CellMesh& mesh);

bool same_mesh(const hlod::CellMesh& a, const hlod::CellMesh& b);

}  // namespace cornice::test
