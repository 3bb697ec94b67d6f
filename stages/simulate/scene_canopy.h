// SPDX-License-Identifier: GPL-3.0-or-later
// Trees: ellipsoids of leaves that a beam passes on its way to the ground.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/vec.h"
#include "stages/simulate/scene.h"

namespace cornice::simulate {

struct Tree {
  Vec3f middle;  ///< of the crown
  float radius = 0.0f;
  float half_height = 0.0f;
};

/// Thread contract: const members may be called from many threads.
class Canopy {
 public:
  /// area: local rectangle that the trees stand in.
  Canopy(std::vector<Tree> trees, const Box2d& area, double returns_per_m);

  /// The first group of crowns met before range max_m: crowns whose passages overlap or nearly
  /// touch, as one passage whose density keeps the mean number of returns.
  bool passage(const Ray& ray, double max_m, CanopyPassage& passage) const;
  std::size_t size() const { return trees_.size(); }
  double top() const { return top_; }

 private:
  struct Cell {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    float bottom = 0.0f;
    float top = 0.0f;
  };
  static constexpr double kCell = 12.0;

  std::vector<Tree> trees_;
  std::vector<std::uint32_t> listed_;  // tree numbers, cell by cell
  std::vector<Cell> cells_;
  Box2d area_;
  int columns_ = 0, rows_ = 0;
  double bottom_ = 0.0, top_ = 0.0;
  double returns_per_m_;
};

}  // namespace cornice::simulate
