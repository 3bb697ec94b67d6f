// SPDX-License-Identifier: GPL-3.0-or-later
// Surface that a raster of heights cannot hold: its normal points below the horizon, so that other
// surface lies under it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "stages/compare/surface.h"

namespace cornice::compare {

/// A connected piece of surface that looks below the horizon.
struct Overhang {
  Vec3d centre;               ///< of its area, world
  Box3d box;                  ///< world
  double area_m2 = 0.0;       ///< of the surface
  double plan_m2 = 0.0;       ///< seen from above: ground that a DEM has another height for
  double depth_m = 0.0;       ///< extent in plan along the way it faces
  double length_m = 0.0;      ///< extent in plan across that
  double height_m = 0.0;      ///< from its lowest to its highest vertex
  double azimuth_deg = 0.0;   ///< the way it faces, clockwise from north
  double steepest_deg = 0.0;  ///< largest angle of a normal below the horizon
};

/// Finds overhangs part by part; pieces that go on in another part become one.
class OverhangFinder {
 public:
  /// `below_deg`: normals count that point below the horizon by more than that.
  explicit OverhangFinder(double below_deg) : below_deg_(below_deg) {}

  void add(std::size_t part, const Surface& surface);
  /// Call after the last add: joins, and drops what is smaller than `min_area_m2`. Returns the
  /// overhangs, largest first.
  std::vector<Overhang> finish(double min_area_m2);
  /// After finish: one byte a triangle of a part, 1 in overhangs; empty where there is none.
  std::vector<std::uint8_t> triangles_of(std::size_t part, std::size_t triangle_count) const;

 private:
  static constexpr std::size_t kDirections = 32;
  /// Of one connected piece: sums and extents, which two pieces can join.
  struct Piece {
    double area = 0.0, plan = 0.0;
    Vec3d moment, normal_sum;
    double lowest_nz = 0.0;
    Box3d box;
    std::array<double, kDirections> reach;  ///< largest x.d over directions in plan
    std::uint32_t parent;
  };
  struct Mark {
    std::uint32_t triangle;
    std::uint32_t piece;
  };
  std::uint32_t root(std::uint32_t piece) const;
  void unite(std::uint32_t a, std::uint32_t b);
  void measure(const Surface& surface, const Triangle& triangle, Piece& piece) const;
  void link_border(const Surface& surface, const std::vector<std::uint32_t>& piece_of_vertex);
  static Overhang overhang_of(const Piece& piece);

  double below_deg_;
  mutable std::vector<Piece> pieces_;
  std::vector<std::vector<Mark>> marks_;  ///< by part
  std::vector<std::pair<std::array<std::int64_t, 3>, std::uint32_t>> border_;
  std::vector<std::uint8_t> kept_;  ///< by piece, after finish
};

}  // namespace cornice::compare
