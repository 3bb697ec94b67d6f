// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/unit/compare/pieces.h"

namespace cornice::test {

compare::Surface surface_of(const Mesh& mesh, Vec3d by) {
  compare::Surface surface;
  surface.origin = mesh.origin + by;
  surface.positions = mesh.positions;
  surface.triangles = mesh.triangles;
  surface.normals = compare::vertex_normals(surface.positions, surface.triangles);
  surface.curvature = compare::vertex_curvature(surface);
  return surface;
}

compare::Surface cloud_of(std::vector<Vec3f> positions, Vec3d origin) {
  compare::Surface surface;
  surface.origin = origin;
  surface.positions = std::move(positions);
  return surface;
}

}  // namespace cornice::test
