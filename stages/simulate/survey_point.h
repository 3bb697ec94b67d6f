// SPDX-License-Identifier: GPL-3.0-or-later
// A simulated point: what the file will say of it, and what is true.
#pragma once

#include <cstdint>
#include <optional>

#include "core/base/vec.h"
#include "stages/simulate/scene.h"

namespace cornice::simulate {

/// Stored step of every coordinate; products of both countries use it.
inline constexpr double kScaleM = 0.01;

/// surface of points that show nothing that is there (outliers).
inline constexpr std::uint8_t kNoSurface = 0;

/// Coordinates are whole steps of kScaleM from the zero of the CRS: up to 21,000 km fit.
struct SurveyPoint {
  double gps_time_s = 0.0;
  Vec3<std::int32_t> at;
  float scan_angle_deg = 0.0f;
  Vec3f true_offset;  ///< true position minus recorded one, m
  Vec3f normal;       ///< unit, out of the surface; against the beam in vegetation
  Vec3f beam;         ///< unit, from the sensor; zero for virtual points
  std::uint16_t intensity = 0;
  std::uint16_t point_source_id = 0;
  std::uint16_t line = 0;  ///< SurveyLine::id; 0 for virtual points
  std::uint8_t return_number = 0;
  std::uint8_t return_count = 0;
  std::uint8_t classification = 0;
  std::uint8_t flags = 0;
  std::uint8_t channel = 0;
  std::uint8_t user_data = 0;
  std::uint8_t surface = kNoSurface;

  Vec3d recorded() const { return at.cast<double>() * kScaleM; }
  Vec3d truth() const { return recorded() + true_offset.cast<double>(); }
};

inline std::int32_t to_steps(double metres) {
  // Inline, unlike std::lround; halves away from zero as there.
  const double steps = metres / kScaleM;
  return static_cast<std::int32_t>(steps < 0.0 ? steps - 0.5 : steps + 0.5);
}

/// Square tiles side by side, numbered row by row from the south-west. A point on a border belongs
/// to the tile east or north of it; one on the outer east or north border to none.
struct TileGrid {
  double west = 0.0;
  double south = 0.0;
  double tile_m = 1000.0;
  int columns = 1;
  int rows = 1;

  int count() const { return columns * rows; }
  Box2d extent() const { return {west, south, west + columns * tile_m, south + rows * tile_m}; }
  Box2d tile(int index) const {
    const double x = west + (index % columns) * tile_m, y = south + (index / columns) * tile_m;
    return {x, y, x + tile_m, y + tile_m};
  }
  std::optional<int> find(std::int32_t x, std::int32_t y) const {
    const std::int64_t size = to_steps(tile_m);
    const std::int64_t dx = std::int64_t{x} - to_steps(west),
                       dy = std::int64_t{y} - to_steps(south);
    if (dx < 0 || dy < 0 || dx >= size * columns || dy >= size * rows) return std::nullopt;
    return static_cast<int>(dy / size) * columns + static_cast<int>(dx / size);
  }
};

}  // namespace cornice::simulate
