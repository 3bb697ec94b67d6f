// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/scene_setup.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "core/base/error.h"
#include "core/geo/crs.h"
#include "core/geo/globe.h"
#include "terrain-viewer/scene/sun.h"

namespace cornice::viewer {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;
constexpr double kNorthWestDeg = 315.0;

/// Rough rules for painting: in the Alps, at 46.5 degrees, trees end near 2000 m and snow lies all
/// year from about 2900 m; both come down to the sea near 70 degrees.
double line_height(double alpine_m, double latitude_deg) {
  const double towards_pole = std::clamp((70.0 - std::abs(latitude_deg)) / (70.0 - 46.5), 0.0, 1.6);
  return alpine_m * towards_pole;
}

}  // namespace

Vec3d sun_direction(double grid_azimuth_deg, double elevation_deg) {
  const double a = grid_azimuth_deg * kRadians, e = elevation_deg * kRadians;
  return {std::sin(a) * std::cos(e), std::cos(a) * std::cos(e), std::sin(e)};
}

void add_layer(Layers& layers, const std::filesystem::path& file, const Options& options,
               GpuCells& cells) {
  CellStoreOptions store;
  store.threads = options.loading_threads;
  const auto sharers = std::max<std::size_t>(1, options.files.size());
  store.memory_bytes =
      static_cast<std::uint64_t>(options.cache_mib * 1048576.0 / static_cast<double>(sharers));
  auto layer =
      std::make_unique<Layer>(file, static_cast<std::uint32_t>(layers.size()), store, cells);
  if (!layers.empty()) {
    const std::string& first = layers.front()->file().header().crs_text;
    const std::string& here = layer->file().header().crs_text;
    if (!first.empty() && !here.empty() && first != here)
      throw InputError(file.string(), "has the reference system " + here +
                                          ", the first layer has " + first +
                                          "; layers of one scene need the same");
  }
  layers.push_back(std::move(layer));
}

Layers open_layers(const Options& options, GpuCells& cells) {
  Layers layers;
  for (const auto& file : options.files) add_layer(layers, file, options, cells);
  return layers;
}

SceneBox box_of(const Layers& layers) {
  SceneBox box{layers.front()->lowest(), layers.front()->highest()};
  for (const auto& layer : layers) {
    const Vec3d a = layer->lowest(), b = layer->highest();
    box.lowest = {std::min(box.lowest.x, a.x), std::min(box.lowest.y, a.y),
                  std::min(box.lowest.z, a.z)};
    box.highest = {std::max(box.highest.x, b.x), std::max(box.highest.y, b.y),
                   std::max(box.highest.z, b.z)};
  }
  return box;
}

Light light_of(const Options& options) {
  Light light;
  light.azimuth_deg = options.sun_azimuth_deg.value_or(kNorthWestDeg);
  light.elevation_deg = options.sun_elevation_deg;
  if (options.time.empty()) return light;
  int hour = 0, minute = 0;
  double second = 0.0;
  if (!sun_at(options.time, 0.0, 0.0) ||
      std::sscanf(options.time.c_str(), "%4d-%2d-%2dT%2d:%2d:%lf", &light.year, &light.month,
                  &light.day, &hour, &minute, &second) != 6)
    throw UsageError("--time", "is \"" + options.time + "\"; accepted: 2026-06-21T10:00:00Z, UTC");
  light.hour = hour + minute / 60.0 + second / 3600.0;
  light.is_of_time = true;
  return light;
}

std::optional<GlobePosition> place_of(const Layers& layers) {
  const std::string& text = layers.front()->file().header().crs_text;
  if (text.empty()) return std::nullopt;
  const SceneBox box = box_of(layers);
  return Globe(crs_from_text(text)).at(0.5 * (box.lowest + box.highest));
}

Vec3d towards_sun(const Light& light, const std::optional<GlobePosition>& place) {
  if (!light.is_of_time || !place) return sun_direction(light.azimuth_deg, light.elevation_deg);
  const auto seconds = std::clamp(std::lround(light.hour * 3600.0), 0L, 86399L);
  std::array<char, 80> time{};
  std::snprintf(time.data(), time.size(), "%04d-%02d-%02dT%02ld:%02ld:%02ldZ", light.year,
                light.month, light.day, seconds / 3600, seconds / 60 % 60, seconds % 60);
  const auto sun = sun_at(time.data(), place->latitude_deg, place->longitude_deg);
  if (!sun) return sun_direction(light.azimuth_deg, light.elevation_deg);
  return sun_direction(sun->azimuth_deg - place->convergence_deg, sun->elevation_deg);
}

Style style_for(const Options& options, const Layers& layers) {
  const SceneBox box = box_of(layers);
  const std::optional<GlobePosition> place = place_of(layers);
  const Light light = light_of(options);
  if (light.is_of_time && !place)
    throw UsageError("--time",
                     "needs files with a reference system; give --sun-azimuth-deg and "
                     "--sun-elevation-deg");
  const double latitude = place ? place->latitude_deg : 46.5;
  Style style;
  style.shading = options.shading;
  style.sun = towards_sun(light, place);
  style.contour_interval_m = options.contour_interval_m;
  style.snow_line_m = options.snow_line_m.value_or(line_height(2900.0, latitude));
  style.tree_line_m = options.tree_line_m.value_or(line_height(2000.0, latitude));
  style.low_m = box.lowest.z;
  style.high_m = std::max(box.highest.z, box.lowest.z + 1.0);
  style.has_edges = options.has_edges;
  return style;
}

}  // namespace cornice::viewer
