// SPDX-License-Identifier: GPL-3.0-or-later
// What the colours of a picture mean, drawn over it (Dear ImGui).
#pragma once

#include <optional>

#include "terrain-viewer/scene/camera.h"
#include "terrain-viewer/scene/ramp.h"
#include "terrain-viewer/scene/style.h"

namespace cornice::viewer {

/// Where a legend ends, pixels.
struct LegendEdges {
  float left = 0.0f, bottom = 0.0f;
};

/// The colours of a ramp, low to high from the bottom to the top, with the values of its stops.
/// Below `top`, its right edge at `right`, pixels.
LegendEdges draw_legend(const Ramp& ramp, float right, float top);

/// What explains the colours of a shading: its ramp, or classes for levels and counts; nothing
/// where colours speak for themselves. levels: how many the scene has.
std::optional<Ramp> legend_of(const Style& style, int levels);

/// A legend for each ramp that is in use, at the upper right, one below the other or side by side.
/// has_difference: a difference map lies over the ground.
void draw_legends(const Style& style, bool has_difference, int levels, int width);

/// Edges of what lies in the lower left corner, pixels.
struct Taken {
  float right = 0.0f, top = 0.0f;
};

/// Scale bar for what is at depth_m along the line of sight, and north arrow, at the lower right.
void draw_scale_and_north(const Camera& camera, int width, int height, double depth_m, Taken taken);

}  // namespace cornice::viewer
