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

}  // namespace cornice::viewer
