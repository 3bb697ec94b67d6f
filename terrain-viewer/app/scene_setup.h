// SPDX-License-Identifier: GPL-3.0-or-later
// What the files say about how a scene is to be lit and first seen.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/geo/globe.h"
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

/// Where the sun stands: as told, or at a day and hour of a year (UTC) over a place.
struct Light {
  bool is_of_time = false;
  double azimuth_deg = 315.0, elevation_deg = 45.0;  ///< from grid north; above the horizon
  int year = 2026, month = 6, day = 21;
  double hour = 10.0;
};
/// Unit vector towards the sun; without a place always as told.
Vec3d towards_sun(const Light& light, const std::optional<GlobePosition>& place);
/// Throws UsageError for a time that is none.
Light light_of(const Options& options);
/// The middle of all layers on the globe; nothing without a reference system.
std::optional<GlobePosition> place_of(const Layers& layers);

/// Style by the options and by where the layers lie: the sun at the time given, snow and tree line
/// by latitude. Throws UsageError for a time that is none or cannot be had.
Style style_for(const Options& options, const Layers& layers);

/// Box of all layers.
struct SceneBox {
  Vec3d lowest, highest;
};
SceneBox box_of(const Layers& layers);

}  // namespace cornice::viewer
