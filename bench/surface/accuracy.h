// SPDX-License-Identifier: GPL-3.0-or-later
// How far a surface lies from the ground, and how much of the ground it has.
#pragma once

#include <string>
#include <vector>

#include "bench/surface/ground.h"
#include "core/mesh/mesh.h"

namespace cornice::bench {

/// What counts.
struct AccuracyOptions {
  double measured_m = 0.5;  ///< only ground within this of a measured point is asked for
  double border_m = 3.0;    ///< ground as near as this to the edge is not
  double present_m = 0.15;  ///< ground within this of the surface is there
  double sample_m = 0.25;   ///< between the samples of the ground
  int threads = 2;
};

/// Root mean squares in metres, counts of what they are over.
struct Accuracy {
  double rms = 0.0, rms_overhang = 0.0;  ///< of vertices and triangle centroids, to the ground
  double rms_back = 0.0, rms_back_overhang = 0.0;      ///< of ground that is there, to the surface
  double area_share = 0.0, overhang_area_share = 0.0;  ///< of measured ground, that is there
  double overhang_area_m2 = 0.0;  ///< measured ground that looks below the horizon
  std::size_t samples = 0, overhang_samples = 0;
};

/// A part of the ground, and how a surface lies there: vertices and triangle centroids.
struct ErrorPart {
  std::string name;
  std::size_t samples = 0;
  double rms = 0.0;   ///< distance from the ground, metres
  double mean = 0.0;  ///< signed, positive out of the ground: a bias
};

/// Judges meshes against one ground. Ground looks below the horizon where its normal points down.
class AccuracyJudge {
 public:
  AccuracyJudge(const Ground& ground, const AccuracyOptions& options);
  Accuracy judge(const Mesh& mesh) const;
  /// The same distances by what the ground is like: of ground that looks up ("up") and of
  /// overhangs ("over") by the measured points per square metre of surface within 1 m ("up 2-4"),
  /// and by how its normals turn within half a metre ("over convex": apart by more than 0.5 per
  /// metre, a radius of 2 m where it bends one way).
  std::vector<ErrorPart> parts(const Mesh& mesh) const;

 private:
  struct Sample {
    Vec3d at;
    double area = 0.0;
    bool overhang = false;
  };
  void forth(const Mesh& mesh, Accuracy& accuracy) const;
  void back(const Mesh& mesh, Accuracy& accuracy) const;
  bool counts(Vec3d p) const;

  const Ground& ground_;
  AccuracyOptions options_;
  std::vector<Sample> samples_;
};

/// What a DEM of the ground is as a surface: heights of the highest ground, joined.
Mesh dem_mesh(const Ground& ground, double step_m);

}  // namespace cornice::bench
