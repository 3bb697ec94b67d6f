// SPDX-License-Identifier: GPL-3.0-or-later
// The ground as an implicit function: F > 0 in the air, F = 0 on the ground, F < 0 in the rock.
//
//   F0(p) = z - a r(p) - H(x - w_x(p), y - w_y(p))
//
// H is a height field. w moves the place looked up by height: at every height a one-to-one map of
// the plan, so the ground keeps the topology of a height field and yet overhangs. It is the sum of
// beds (strata, harder ones stand out), of roughness r and of leaning walls. Voids (caves, the
// holes of arches) are taken out of the rock by a smooth maximum.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/vec.h"
#include "stages/simulate/scene_file.h"
#include "stages/simulate/scene_spline.h"

namespace cornice::simulate {

/// Per place: outward direction of steep ground (zero on gentle ground), amplitude of roughness and
/// of beds, metres.
struct alignas(16) RockNode {
  float out_x = 0.0f;
  float out_y = 0.0f;
  float roughness = 0.0f;
  float beds = 0.0f;
};

/// Roughness in space: white noise on a lattice of 32^3, smoothed by a quadratic spline, repeated.
/// The lattice is turned out of all axes and planes, so that its period shows on no surface.
class RoughnessVolume {
 public:
  static constexpr int kSide = 32;
  static constexpr float kStep = 1.25f;  ///< shortest wave about 2.5 m
  /// No value exceeds it; the variance is 1.
  static constexpr float kLimit = 6.1f;

  explicit RoughnessVolume(std::uint64_t seed = 1);
  template <bool kWithGradient>
  float value(Vec3d p, Vec3f& gradient) const;

 private:
  friend struct FieldLanes;
  static constexpr int kPadded = kSide + 3;
  std::vector<float> values_;
};

/// Beds of hard and soft rock by height over the bedding plane, in [-1, 1].
class BedProfile {
 public:
  static constexpr int kCount = 1024;
  BedProfile() = default;
  BedProfile(double thickness_m, std::uint64_t seed);
  float value(double height, float& derivative) const;

 private:
  friend struct FieldLanes;
  float inverse_step_ = 1.0f;
  std::vector<float> values_;
};

/// A wall whose upper part is moved outwards.
struct Lean {
  double x = 0.0, y = 0.0;          ///< middle of the wall
  double out_x = 0.0, out_y = 0.0;  ///< unit, the way the wall looks
  double half_length = 0.0, half_depth = 0.0;
  double fade = 1.0;  ///< width over which the movement ends beyond those, metres
  double foot = 0.0, top = 0.0;
  double reach = 0.0;
  Box2d box;
};

/// A capsule of elliptical cross-section taken out of the rock.
struct Void {
  Vec3d from;
  Vec3d axis;  ///< unit, horizontal
  double length = 0.0;
  double half_width = 0.0;
  double half_height = 0.0;
  double blend = 1.5;      ///< radius of the rounded rim
  double steepness = 1.0;  ///< of F0 against distance at the rim
  Box3d box;
};

/// Coordinates are local: plan relative to the scene's centre, heights relative to its base.
/// Thread contract: const members may be called from many threads.
class GroundField {
 public:
  PlanField height;
  PlanLattice rock_lattice;
  std::vector<RockNode> rock;
  RoughnessVolume roughness;
  BedProfile beds;
  double dip_x = 0.0, dip_y = 0.0;
  std::vector<Lean> leans;
  std::vector<Void> voids;

  double value(Vec3d p) const { return evaluate<false>(p, nullptr); }
  double value(Vec3d p, Vec3d& gradient) const { return evaluate<true>(p, &gradient); }

  /// The same at `count` places, four at a time; off by a few 1e-7 m from one by one.
  void values(const Vec3d* places, std::size_t count, double* values) const;
  void values(const Vec3d* places, std::size_t count, double* values, Vec3d* gradients) const;

  /// Prepares what follows from the members above; call whenever they have changed.
  void prepare();
  /// Heights that the ground can have over a rectangle.
  struct Range {
    double low, high;
  };
  Range height_range(const Box2d& box) const;

 private:
  struct Feature {
    bool is_void;
    std::uint16_t index;
  };
  template <bool kWithGradient>
  double evaluate(Vec3d p, Vec3d* gradient) const;
  /// Without leans and voids.
  template <bool kWithGradient>
  void evaluate4(const Vec3d* p, double* values, Vec3d* gradients) const;
  template <bool kWithGradient>
  void evaluate_all(const Vec3d* places, std::size_t count, double* values, Vec3d* gradients) const;
  /// Where the leans look the place up; jacobian: of their movement along x and y by x, y, z.
  Vec2d lean_back(const std::vector<Feature>& features, Vec3d p, double (&jacobian)[2][3]) const;
  double cut_void(const Void& hole, Vec3d p, double value, Vec3d* gradient) const;
  const std::vector<Feature>* features_at(double x, double y) const;

  static constexpr double kFeatureCell = 32.0;
  Box2d inner_;  ///< whatever is looked up from here lies within the lattices
  Box2d feature_area_;
  int feature_columns_ = 0;
  int feature_rows_ = 0;
  std::vector<std::vector<Feature>> features_;
};

}  // namespace cornice::simulate
