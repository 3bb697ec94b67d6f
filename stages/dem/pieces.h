// SPDX-License-Identifier: GPL-3.0-or-later
// Which meshes a survey becomes, and where their vertices lie.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/vec.h"
#include "stages/dem/grid_surface.h"
#include "stages/dem/survey.h"

namespace cornice::dem {

/// A tile, or a part of a tile that is too large for one mesh.
struct Piece {
  std::size_t tile = 0;  ///< in Survey::tiles()
  PixelRect own;
  std::string name;  ///< of its file, without extension
};

/// Cuts tiles into equal pieces of at most `most_pixels` a side. Parts of a tile are named
/// TILE_r01_c02, counted from the north-west.
std::vector<Piece> cut_into_pieces(const Survey& survey, std::int64_t most_pixels);

/// The file's name without what is a raster's extension; "0.5_2056_5728" of a name without one is
/// no extension.
std::string stem_of(const std::filesystem::path& path);

/// Largest side of a piece: what floats hold exactly on the lattice below.
inline constexpr std::int64_t kMostPixelsOfPiece = 4000;

/// Where vertices lie. East and north are rounded to a binary fraction of a metre below a 2000th of
/// a pixel, which depends on the pixel size alone: so origin + float is the same number, bit for
/// bit, in every piece that has the vertex. Heights are the raster's own floats; origins have
/// height 0.
class Lattice {
 public:
  explicit Lattice(double step);
  double quantum() const { return quantum_; }
  /// South-west of the piece, on whole metres where a pixel is not much smaller.
  Vec3d origin_of(const Survey& survey, const PixelRect& own) const;
  VertexPlaces places_of(const Survey& survey, const PixelRect& own) const;

 private:
  double step_;
  double quantum_;
  double origin_quantum_;
};

}  // namespace cornice::dem
