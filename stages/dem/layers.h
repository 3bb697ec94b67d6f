// SPDX-License-Identifier: GPL-3.0-or-later
// What stands above and below one another at pixel centres: meshes, scan-converted.
//
// Source: edge functions of Pineda 1988, "A parallel algorithm for polygon rasterization"; ties by
// moving every pixel centre by an infinitely small step (Edelsbrunner and Muecke 1990, "Simulation
// of simplicity").
#pragma once

#include <cstdint>
#include <vector>

#include "core/io/cog_writer.h"
#include "core/mesh/mesh.h"
#include "stages/dem/pixel_rect.h"

namespace cornice::dem {

/// Layers of surface at the centres of the pixels of one rectangle of a raster. Positions are taken
/// to a millionth of a pixel, and onto a row or column of centres where they are within a 2048th of
/// it; from there on nothing is rounded in plan: a centre on an edge between two triangles counts
/// once, one on the border of the surface counts as on it. Heights are those
/// of the triangle's plane at the centre. The result does not depend on the order of meshes and
/// triangles.
class Layers {
 public:
  /// `rect` counts the pixels of `grid` from its north-west corner.
  Layers(const RasterGrid& grid, const PixelRect& rect);

  void add(const Mesh& mesh, int threads);

  /// Row by row; `nothing` where no surface is.
  std::vector<float> highest(float nothing) const;
  std::vector<float> lowest(float nothing) const;
  std::vector<float> mean(float nothing) const;
  /// Number of triangles that the vertical through the centre meets; 0 where no surface is.
  std::vector<float> counts() const;
  /// Pixels with so many layers or more.
  std::uint64_t pixels_with(std::uint32_t layers) const;

  static constexpr std::uint64_t kBytesPerPixel = 44;   ///< with one band on its way to the file
  static constexpr std::uint64_t kBytesPerVertex = 24;  ///< of a mesh while it is added

  /// A place in pixels times 2^kFractionBits, from the centre of the raster's first pixel; rows
  /// run south.
  struct Place {
    std::int64_t col = 0, row = 0;
    double height = 0.0;
  };
  static constexpr int kFractionBits = 20;

 private:
  struct Pixel {
    float highest, lowest;
    /// Of triangles that have the centre on their edge, but do not own it.
    float touched_highest, touched_lowest;
    std::int64_t sum = 0;  ///< of heights, in kSumUnits: whole numbers do not mind the order
    std::uint32_t count = 0;
    Pixel();
    void meet(double height);
    void touch(double height);
    std::uint32_t layers() const;
  };
  Place place_of(const Mesh& mesh, std::size_t vertex) const;
  template <class Int>
  void scan(Place a, Place b, Place c, const PixelRect& box);
  void add_rows(const Mesh& mesh, const std::vector<Place>& places, const PixelRect& band);
  template <class Value>
  std::vector<float> band_of(float nothing, Value value) const;

  RasterGrid grid_;
  PixelRect rect_;
  std::vector<Pixel> pixels_;
};

}  // namespace cornice::dem
