// SPDX-License-Identifier: GPL-3.0-or-later
// Points in cubes, for searches within a fixed radius.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/vec.h"

namespace cornice::compare {

/// Keeps a reference to `positions`. Thread contract: const members may be called from many
/// threads. Memory: 16 bytes a point.
class PointGrid {
 public:
  /// side_m: of the cubes; searches are fastest for radii of about that. Above 0.
  PointGrid(const std::vector<Vec3f>& positions, float side_m);

  /// Calls visit(index) for every point in a cube that comes within `radius_m` of `p`: all points
  /// within the radius, and others near it.
  template <class Visit>
  void visit_near(Vec3f p, float radius_m, const Visit& visit) const;

  const std::vector<Vec3f>& positions() const { return positions_; }
  /// Points by cube; those of one cube in the order that they came in.
  const std::vector<std::uint32_t>& order() const { return order_; }
  /// True where a point begins a new cube in order().
  bool begins_cube(std::size_t place) const {
    return place == 0 || keys_[place] != keys_[place - 1];
  }

 private:
  std::int64_t cube(float x) const;
  static std::uint64_t key(std::int64_t x, std::int64_t y, std::int64_t z);
  /// Places in order() of the cubes from (x0, y, z) to (x1, y, z).
  std::size_t first_at_least(std::uint64_t wanted) const;

  const std::vector<Vec3f>& positions_;
  float side_m_;
  std::vector<std::uint64_t> keys_;  ///< sorted
  std::vector<std::uint32_t> order_;
};

template <class Visit>
void PointGrid::visit_near(Vec3f p, float radius_m, const Visit& visit) const {
  const std::int64_t x0 = cube(p.x - radius_m), x1 = cube(p.x + radius_m);
  for (std::int64_t z = cube(p.z - radius_m); z <= cube(p.z + radius_m); ++z) {
    for (std::int64_t y = cube(p.y - radius_m); y <= cube(p.y + radius_m); ++y) {
      // Cubes of one row follow each other.
      const std::uint64_t last = key(x1, y, z);
      for (std::size_t i = first_at_least(key(x0, y, z)); i < keys_.size() && keys_[i] <= last;
           ++i) {
        visit(order_[i]);
      }
    }
  }
}

}  // namespace cornice::compare
