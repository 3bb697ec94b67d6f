// SPDX-License-Identifier: GPL-3.0-or-later
// Tiles cut from surfaces with a formula, whose borders disagree as much as a test wants.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/mesh/topology.h"

namespace cornice::test {

/// A point of the surface at parameters (u, v), metres; u and v run over the survey's rectangle.
using Surface = std::function<Vec3d(double u, double v)>;

Vec3d hills(double u, double v);
/// Hills with bumps of half a metre: borders bend at every vertex.
Vec3d rough_hills(double u, double v);
/// A wall along v that leans over the ground below it: x turns back while u goes on.
Vec3d leaning_wall(double u, double v);

struct CutPlan {
  Surface surface = hills;
  int columns = 2, rows = 2;
  double tile_m = 8.0;
  /// Cells along a tile's side.
  std::function<int(int column, int row)> cells = [](int, int) { return 16; };
  double jitter_m = 0.0;      ///< of border vertices, in each direction
  std::uint64_t seed = 0;     ///< of the jitter
  bool only_corners = false;  ///< jitter at the corners of tiles alone
  Vec3d origin{2600000.0, 1200000.0, 1500.0};
};
/// Tiles in rows from the first column, with normals, a float property and a byte property.
std::vector<Mesh> cut_tiles(const CutPlan& plan);

/// Takes triangles out whose middle is within radius_m of `middle`, projected CRS, and the vertices
/// that no other triangle has.
void punch_hole(std::vector<Mesh>& tiles, Vec3d middle, double radius_m);

/// Vertices welded where they are equal in the projected CRS.
struct Welded {
  std::vector<Vec3d> positions;
  std::vector<Triangle> triangles;
};
Welded weld(const std::vector<Mesh>& tiles);

/// Writes tile i to FOLDER/t<i>.ply and returns the paths.
std::vector<std::filesystem::path> write_tiles(const std::filesystem::path& folder,
                                               const std::vector<Mesh>& tiles);

}  // namespace cornice::test
