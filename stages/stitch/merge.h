// SPDX-License-Identifier: GPL-3.0-or-later
// One mesh of all tiles.
#pragma once

#include <array>
#include <map>

#include "core/mesh/mesh.h"

namespace cornice::stitch {

/// Joins conforming tiles: vertices of borders that lie at the same place become one. The result is
/// relative to the first tile's origin, where floats hold places at 10 km to half a millimetre.
class Merger {
 public:
  /// Throws InputError where the tile has other vertex properties than the first.
  void add(const Mesh& tile, int threads);
  Mesh take() { return std::move(mesh_); }

 private:
  Mesh mesh_;
  std::map<std::array<double, 3>, std::uint32_t> border_;
  bool first_ = true;
};

}  // namespace cornice::stitch
