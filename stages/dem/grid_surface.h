// SPDX-License-Identifier: GPL-3.0-or-later
// The triangles of one piece of a grid of heights. Vertices are pixel centres:
//
//     w+1 columns                     The piece's own pixels are O. A cell belongs to the piece
//     N---N---N---N  h+1 rows         that owns its lower left corner, so the piece takes the
//     |   |   |   |                   first row (N), column (N) and corner of its upper and right
//     O---O---O---N                   neighbours, and pieces meet there without overlap. Where
//     |   |   |   |                   there is no neighbour the surface ends at the last O.
//     O---O---O---N
//
// Source: the tile construction of "Terrain mesh tile reconstruction based on DEM" (reference 000,
// algorithm 5); diagonals by the cubic convolution of Keys 1981, "Cubic convolution interpolation
// for digital image processing".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/mesh/mesh.h"
#include "stages/dem/pixel_rect.h"

namespace cornice::dem {

/// What stands in a cell. Corners: NW, NE, SW, SE.
enum class Cell : std::uint8_t {
  kEmpty = 0,
  kRising,     ///< two triangles, diagonal from SW to NE
  kFalling,    ///< two triangles, diagonal from NW to SE
  kWithoutNW,  ///< one triangle of the three other corners
  kWithoutNE,
  kWithoutSW,
  kWithoutSE,
};

/// Heights around a piece: its own pixels, `kMargin` columns and rows around them and one more on
/// the upper and right side. Row by row from the north; not-a-number where there is no data.
struct HeightWindow {
  static constexpr std::int64_t kMargin = 1;
  PixelRect own;
  std::vector<float> heights;
  /// Parts of `own` whose cells belong to another piece.
  std::vector<PixelRect> taken;

  static PixelRect rect_for(const PixelRect& own) {
    return {own.col - kMargin, own.row - 1 - kMargin, own.width + 1 + 2 * kMargin,
            own.height + 1 + 2 * kMargin};
  }
};

/// Turns vertex columns and rows of a piece into positions.
struct VertexPlaces {
  std::vector<float> east;   ///< w + 1, relative to the origin
  std::vector<float> north;  ///< h + 1, from the north
  float step = 1.0f;         ///< metres
};

/// Numbered vertices and triangles of a piece; records are made on demand, row by row.
class GridSurface {
 public:
  static constexpr std::size_t kVertexBytes = 24;    ///< x y z nx ny nz as floats
  static constexpr std::size_t kTriangleBytes = 13;  ///< a byte 3, three 32-bit indices

  /// Bytes per own pixel beside the window.
  static constexpr std::uint64_t kBytesPerPixel = 5;

  /// Decides about every cell and numbers the vertices. `threads` as an option value.
  GridSurface(HeightWindow window, int threads);

  std::int64_t vertex_rows() const { return height_ + 1; }
  std::int64_t triangle_rows() const { return height_; }
  std::uint64_t vertices() const { return first_double_ + doubles_.size(); }
  std::uint64_t triangles() const { return first_triangle_.back(); }
  /// Corners where two fans of the piece's triangles touch; each fan has a vertex of its own.
  std::uint64_t doubled_vertices() const { return doubles_.size(); }
  /// Own pixels without a height.
  std::uint64_t empty_pixels() const { return empty_pixels_; }
  float lowest() const { return lowest_; }
  float highest() const { return highest_; }

  std::uint64_t vertices_before(std::int64_t row) const {
    return first_vertex_[static_cast<std::size_t>(row)];
  }
  std::uint64_t triangles_before(std::int64_t row) const {
    return first_triangle_[static_cast<std::size_t>(row)];
  }
  /// Records of the vertices of the rows [begin, end); `to` must hold them. Row vertex_rows() is
  /// that of the doubled vertices, which come last.
  void vertex_records(std::int64_t begin, std::int64_t end, const VertexPlaces& places,
                      std::uint8_t* to) const;
  /// Records of the triangles of the cell rows [begin, end), counter-clockwise seen from above.
  void triangle_records(std::int64_t begin, std::int64_t end, std::uint8_t* to) const;

 private:
  /// A second vertex at a place of the lattice.
  struct Double {
    std::size_t place = 0;
    std::uint8_t quadrants = 0;  ///< bits of the cells that use it, as Quadrant
  };

  const float* heights_row(std::int64_t row) const {
    return window_.heights.data() + (row + HeightWindow::kMargin) * stride_ + HeightWindow::kMargin;
  }
  Cell cell_at(std::int64_t col, std::int64_t row) const {
    return col < 0 || row < 0 || col >= width_ || row >= height_
               ? Cell::kEmpty
               : cells_[static_cast<std::size_t>(row * width_ + col)];
  }
  bool is_full(std::int64_t col, std::int64_t row) const;
  Cell three_corners(std::int64_t col, std::int64_t row, Cell missing) const;
  void decide_row(std::int64_t row, std::vector<double>& scratch);
  void clear_taken();
  std::uint8_t second_fan(std::int64_t col, std::int64_t row) const;
  std::uint64_t count_vertices(std::int64_t row, std::vector<Double>& doubles);
  void number_row(std::int64_t row);
  void number_vertices(int threads);
  void vertex_record(std::int64_t col, std::int64_t row, const VertexPlaces& places,
                     std::uint8_t* to) const;
  std::uint32_t index_for(std::int64_t col, std::int64_t row, unsigned quadrant) const;

  HeightWindow window_;
  std::int64_t width_ = 0, height_ = 0;  ///< cells
  std::int64_t stride_ = 0;              ///< of window_.heights
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> index_;  ///< of every place; kNone, or marked where it is doubled
  std::vector<std::uint64_t> first_vertex_, first_triangle_;
  std::vector<Double> doubles_;  ///< by place
  std::uint64_t first_double_ = 0;
  std::uint64_t empty_pixels_ = 0;
  float lowest_ = 0.0f, highest_ = 0.0f;
};

/// The mesh as a whole, for formats that are not streamed.
Mesh whole_mesh(const GridSurface& surface, const VertexPlaces& places, int threads);

}  // namespace cornice::dem
