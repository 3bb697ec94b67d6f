// SPDX-License-Identifier: GPL-3.0-or-later
// What the files say about how a scene is to be lit and first seen.
#pragma once

#include <memory>
#include <vector>

#include "terrain-viewer/app/options.h"
#include "terrain-viewer/render/layer.h"
#include "terrain-viewer/scene/style.h"

namespace cornice::viewer {

using Layers = std::vector<std::unique_ptr<Layer>>;

/// Opens the files of the options. Throws InputError for a damaged file or for files of different
/// reference systems.
Layers open_layers(const Options& options, GpuCells& cells);

/// Opens one more file as the last layer. Throws as open_layers.
void add_layer(Layers& layers, const std::filesystem::path& file, const Options& options,
               GpuCells& cells);

/// Unit vector towards a sun.
Vec3d sun_direction(double grid_azimuth_deg, double elevation_deg);

/// Style by the options and by where the layers lie: the sun at the time given, snow and tree line
/// by latitude, haze by size. Throws UsageError for a time that is none or cannot be had.
Style style_for(const Options& options, const Layers& layers);

/// Box of all layers.
struct SceneBox {
  Vec3d lowest, highest;
};
SceneBox box_of(const Layers& layers);

}  // namespace cornice::viewer
