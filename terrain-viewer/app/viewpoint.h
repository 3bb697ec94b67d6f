// SPDX-License-Identifier: GPL-3.0-or-later
// Where a picture is best taken from, found from the ground itself: for reports, where nobody
// chooses.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/vec.h"
#include "hlod/file.h"
#include "terrain-viewer/scene/camera.h"

namespace cornice::viewer {

/// A triangle of the ground, projected CRS.
struct Facet {
  Vec3d centre;
  Vec3d normal;  ///< unit
  double area_m2 = 0.0;
};

/// Of the finest level that has at most `most` triangles, or of the coarsest.
std::vector<Facet> facets_of(const hlod::File& file, std::uint64_t most = 400'000);

/// An oblique view of everything: of all headings, in steps of 15 degrees, the one from which the
/// facets that face the viewer, less those that do not, fill most of the picture; the steeper from
/// above the flatter the ground, and where much would be seen from below. facets: one at least.
Camera overview(const std::vector<Facet>& facets, double width_over_height);

/// A close view, from the front, of the steepest part: of all squares with ground all around them
/// the one where the slopes' areas, weighted by steepness, sum up to most. As square to it as can
/// be without ground in between, or emptiness in the foreground where it falls off the survey's
/// edge: from up to 60 degrees aside, and from above. facets: one at least.
Camera steepest_view(const std::vector<Facet>& facets, double width_over_height);

/// Moved back or forth, and sideways, until all points just fit into the picture, `margin` of its
/// size left free on each side. points: one at least.
Camera fitted(const Camera& camera, const std::vector<Vec3d>& points, double width_over_height,
              double margin);

/// Azimuth for the sun of such pictures, degrees: from the viewer's left and a little behind, so
/// that slopes that are seen are lit, and lit differently.
double sun_azimuth_for(const Camera& camera);

}  // namespace cornice::viewer
