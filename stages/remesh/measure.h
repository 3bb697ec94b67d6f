// SPDX-License-Identifier: GPL-3.0-or-later
// How far result and input are apart, and where too far.
#pragma once

#include <algorithm>
#include <vector>

#include "stages/remesh/patches.h"
#include "stages/remesh/reference.h"

namespace cornice::remesh {

/// A triangle of the result that leaves the bound, and a place of the input that it should go
/// through.
struct Offence {
  std::uint32_t triangle;
  Vec3f through;
  std::uint32_t input_triangle;
  bool must_reach = false;  ///< the input is too far from the result there, not the other way
  Vec3f place{};            ///< of the result that is too far from the input, if not
  float distance_m = 0.0f;
};

/// A triangle of the input with a place that is near, if at all, another triangle of the result
/// than those its corners hang on.
struct Borrowing {
  std::uint32_t input_triangle;
  float distance_m;  ///< of that place
};

struct Distances {
  float input_to_result_m = 0.0f;  ///< at most, over the places looked at
  float result_to_input_m = 0.0f;
  float kept_m = 0.0f;            ///< largest of both that is no offence
  std::vector<Offence> offences;  ///< the worst one of each triangle, by triangle
  std::vector<Borrowing> borrowings;
};

struct MeasureLimits {
  float enough_m = 0.025f;  ///< nearer than this is not told apart
  float search_m = 0.045f;  ///< farther is searched for on other sheets, too
  float bound_m = 0.05f;    ///< farther is an offence
  float spacing_m = 0.25f;  ///< of the places looked at on the result
};

/// Looks at the triangles whose byte in mesh.changed is not 0, and at the input near these: where
/// its vertices hang on them, and at those of `borrowings` of the last measurement that lie near
/// them. The others are named again.
/// From the input: every vertex, and where the corners of a triangle hang on different triangles of
/// the result, the middles of its sides and its own. (Where all three are near one triangle the
/// whole triangle between them is, since the distance from a convex body is convex.)
/// From the result: places about spacing_m apart on every triangle.
Distances measure_distances(const WorkMesh& mesh, const Reference& input,
                            const MeasureLimits& limits, const std::vector<Borrowing>& borrowings,
                            int threads);

}  // namespace cornice::remesh
