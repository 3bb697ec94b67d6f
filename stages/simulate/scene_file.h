// SPDX-License-Identifier: GPL-3.0-or-later
// What a scene file says (docs/formats/scene.md). Lengths in metres, angles in degrees clockwise
// from north, places relative to the centre of the ground covered, heights relative to base_m.
#pragma once

#include <array>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

namespace cornice::simulate {

/// A place or direction in plan.
struct Vec2d {
  double x = 0.0;
  double y = 0.0;
};

/// A mountain range along a line, before erosion.
struct RidgeShape {
  Vec2d from, to;
  double height_m = 0.0;
  double half_width_m = 0.0;
};

/// Noise without end: rounded hills or sharp-crested mountains.
struct NoiseShape {
  double height_m = 0.0;
  double wavelength_m = 0.0;
};

struct ErosionShape {
  double incision = 0.0;  ///< 0 none, 1 deep gullies
  double step_m = 4.0;
  double soft_deg = 36.0;  ///< steepest slope of debris
  double hard_deg = 68.0;  ///< steepest slope of sound rock
};

/// A step in the ground that looks towards azimuth_deg, with an optional outward lean.
struct WallShape {
  Vec2d at;
  double azimuth_deg = 0.0;
  double length_m = 0.0;
  double height_m = 0.0;
  double run_m = 0.0;   ///< plan width of the step
  double back_m = 0.0;  ///< plan distance behind the edge over which the raised ground falls back
  double lean_m = 0.0;  ///< how far the top stands out over the foot, beyond the step's own run
};

/// A narrow blade of rock along azimuth_deg, pierced at its middle where the hole is wider than 0.
struct FinShape {
  Vec2d at;
  double azimuth_deg = 0.0;
  double length_m = 0.0;
  double height_m = 0.0;
  double half_width_m = 0.0;
  double hole_width_m = 0.0;
  double hole_height_m = 0.0;
};

/// A cave that opens towards azimuth_deg in the nearest face behind `at`.
struct CaveShape {
  Vec2d at;  ///< in front of the face
  double azimuth_deg = 0.0;
  double above_m = 0.0;  ///< of its axis over the ground at `at`
  double width_m = 0.0;
  double height_m = 0.0;
  double depth_m = 0.0;
};

struct RiverShape {
  std::vector<Vec2d> course;
  double width_m = 0.0;
  double bank_m = 0.0;
  /// Water at the first point of the course; not a number: a metre below the course's lowest
  /// ground.
  double level_m = std::numeric_limits<double>::quiet_NaN();
  double fall_per_km_m = 0.0;
};

struct ForestShape {
  double trees_per_ha = 0.0;
  double below_m = 1e9;
  double max_slope_deg = 40.0;
  double tree_height_m = 20.0;
  double crown_radius_m = 2.2;
  double cover = 0.6;    ///< share of suitable ground
  double patch_m = 120;  ///< size of stands and clearings
  double returns_per_m = 0.35;
};

struct VillageShape {
  Vec2d at;
  double radius_m = 0.0;
  int houses = 0;
};

struct StrataShape {
  double thickness_m = 8.0;
  double depth_m = 0.0;
  double dip_deg = 0.0;
  double dip_azimuth_deg = 0.0;
  double min_slope_deg = 48.0;
};

struct SceneDescription {
  std::string name;
  std::array<double, 2> size_m{1000.0, 1000.0};
  double base_m = 0.0;
  double grid_m = 1.0;
  double repeat_m = 0.0;
  double slope_percent = 0.0;
  double slope_azimuth_deg = 0.0;  ///< downhill
  std::vector<RidgeShape> ridges;
  NoiseShape hills;
  NoiseShape mountains;
  ErosionShape erosion;
  NoiseShape detail;
  double rock_roughness_m = 0.05;
  double soil_roughness_m = 0.02;
  StrataShape strata;
  std::vector<WallShape> walls;
  std::vector<FinShape> fins;
  std::vector<CaveShape> caves;
  std::vector<RiverShape> rivers;
  ForestShape forest;
  std::vector<VillageShape> villages;
};

/// Throws InputError "FILE: line N: key: what is wrong, what is accepted".
SceneDescription read_scene_file(const std::filesystem::path& file);

/// Unit vector in plan, clockwise from north.
Vec2d azimuth_direction(double azimuth_deg);

}  // namespace cornice::simulate
