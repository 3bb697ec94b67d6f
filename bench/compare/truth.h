// SPDX-License-Identifier: GPL-3.0-or-later
// Pieces of scenes whose surface is known, as files that can be compared.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "stages/compare/compare.h"
#include "stages/simulate/scene.h"

namespace cornice::bench {

/// A scene under one tile of a simulated Lidar HD survey, in the CRS of its points.
struct TrueGround {
  std::unique_ptr<simulate::Scene> scene;
  Box2d extent;
};
TrueGround true_ground(const std::string& scene, double tile_m, std::uint64_t seed, int threads);

/// Writes the highest ground per pixel, as DEM products hold it.
void write_true_dem(const TrueGround& ground, double step_m, const std::filesystem::path& path);
/// Writes the whole surface.
void write_true_surface(const TrueGround& ground, double step_m, const std::filesystem::path& path);

/// Two files compared.
compare::Result compare_files(const std::filesystem::path& a, const std::filesystem::path& b,
                              const compare::Options& options,
                              const std::function<void(const compare::MeasuredPart&)>& show = {});

/// Of the ground that looks below the horizon by the scene's own gradient (samples of 0.25 m at
/// least 2 m inside the tile), the share of area that overhangs listed on one side lie within
/// 0.15 m of.
class OverhangJudge {
 public:
  explicit OverhangJudge(const TrueGround& ground);
  /// Takes the listed triangles of B.
  void add(const compare::MeasuredPart& part);
  double true_m2() const { return true_m2_; }
  double found_share() const;

 private:
  struct Sample {
    Vec3f position;  ///< relative to origin_
    double area_m2;
  };
  Vec3d origin_;
  std::vector<Sample> samples_;
  double true_m2_ = 0.0;
  std::vector<Vec3f> positions_;
  std::vector<Triangle> listed_;
};

}  // namespace cornice::bench
