// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces seen obliquely from far, part after part, coloured by what was measured on them.
#pragma once

#include <array>
#include <vector>

#include "core/io/raster.h"
#include "stages/compare/colours.h"
#include "stages/compare/surface.h"

namespace cornice::compare {

/// Where an orthographic view looks, and what it shows.
struct ViewPlan {
  double heading_deg = 330.0;  ///< looked along, clockwise from north
  double tilt_deg = 28.0;      ///< below the horizon
  int width_px = 1200;
  Box3d box;  ///< world; what lies outside is cut off at the picture's edge
};

/// A depth buffer, twice as fine as the picture.
class View {
 public:
  explicit View(const ViewPlan& plan);
  /// One colour a vertex, lit by the vertex normals; of clouds a dot each. Triangles with a byte in
  /// `marked` are of `mark`'s colour.
  void add(const Surface& surface, const std::vector<Rgb>& colours,
           const std::vector<std::uint8_t>& marked = {}, Rgb mark = kOverhangColour);
  Picture picture() const;
  /// Of the finished picture; sideways, not into the depth.
  double px_per_m() const { return px_per_m_ / kFiner; }

 private:
  static constexpr int kFiner = 2;
  struct Corner {
    Vec3d at;  ///< fine pixels right and down, metres away
    Vec3f normal;
    Rgb colour;
  };
  Corner corner(const Surface& surface, std::uint32_t vertex, Rgb colour) const;
  void fill(const std::array<Corner, 3>& corners);
  void dot_at(const Corner& corner);
  void put(int x, int y, double depth, const std::array<double, 3>& colour, Vec3f normal);

  Vec3d right_, up_, forward_;
  double low_x_ = 0.0, high_y_ = 0.0, px_per_m_ = 1.0;
  int width_ = 0, height_ = 0;
  std::vector<float> depth_;
  std::vector<Rgb> pixels_;
};

}  // namespace cornice::compare
