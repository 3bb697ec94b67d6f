// SPDX-License-Identifier: GPL-3.0-or-later
// What was drawn, brought back from the GPU.
#pragma once

#include "core/io/raster.h"
#include "terrain-viewer/render/gl.h"

namespace cornice::viewer {

/// The colours of a target of several samples, averaged into `resolved`, which has one.
void resolve(const Target& target, const Target& resolved);

/// The colours of a target of one sample, the upper row first.
Picture read_picture(const Target& target);

/// The depth that was drawn in pixel (x, y) of a target of one sample, (0, 0) at the upper left.
float read_depth(const Target& target, int x, int y);

}  // namespace cornice::viewer
