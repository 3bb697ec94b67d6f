// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles as CGAL's tree takes them: a second opinion on distances.
#pragma once

// Its check at the start of the program stops under valgrind, which knows one way of rounding only.
#define CGAL_DISABLE_ROUNDING_MATH_CHECK
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <vector>

#include "core/mesh/mesh.h"

namespace cornice::test {

using Kernel = CGAL::Simple_cartesian<double>;
using Solids = std::vector<Kernel::Triangle_3>;
/// Of the solids, which must stay where they are.
using SolidTree = CGAL::AABB_tree<
    CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, Solids::iterator>>>;

inline Kernel::Point_3 solid_point(Vec3f p) { return {p.x, p.y, p.z}; }

inline Solids solids(const Mesh& mesh) {
  Solids all;
  for (const Triangle& t : mesh.triangles) {
    all.emplace_back(solid_point(mesh.positions[t[0]]), solid_point(mesh.positions[t[1]]),
                     solid_point(mesh.positions[t[2]]));
  }
  return all;
}

}  // namespace cornice::test
