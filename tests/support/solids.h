// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles as CGAL's tree takes them: a second opinion on distances.
#pragma once

// Its check at the start of the program stops under valgrind, which knows one way of rounding only.
#define CGAL_DISABLE_ROUNDING_MATH_CHECK
#include <CGAL/AABB_tree.h>
#include <CGAL/Simple_cartesian.h>
#if __has_include(<CGAL/AABB_traits_3.h>)  // CGAL 6
#include <CGAL/AABB_traits_3.h>
#include <CGAL/AABB_triangle_primitive_3.h>
#else
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_triangle_primitive.h>
#endif

#include <vector>

#include "core/mesh/mesh.h"

namespace cornice::test {

using Kernel = CGAL::Simple_cartesian<double>;
using Solids = std::vector<Kernel::Triangle_3>;
#if __has_include(<CGAL/AABB_traits_3.h>)
using SolidTraits =
    CGAL::AABB_traits_3<Kernel, CGAL::AABB_triangle_primitive_3<Kernel, Solids::iterator>>;
#else
using SolidTraits =
    CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, Solids::iterator>>;
#endif
/// Of the solids, which must stay where they are.
using SolidTree = CGAL::AABB_tree<SolidTraits>;

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
