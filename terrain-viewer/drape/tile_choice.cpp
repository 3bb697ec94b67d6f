// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/drape/tile_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace cornice::viewer {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;
constexpr double kWidestDeg = 170.0;
/// From one try to the next, where a view needs too many tiles.
constexpr double kCoarser = 1.25;
/// Nothing counts as nearer, or a box around the eye would ask for the finest level at any price.
constexpr double kNearestM = 1.0;

struct Box {
  Vec3d low, high;
};

/// Normals, pointing inwards, of the planes through the eye that bound what is seen.
std::array<Vec3d, 4> side_planes(const TileView& view) {
  const CameraAxes axes = axes_of(view.camera);
  const double half_up = 0.5 * view.camera.field_of_view_deg * kRadians;
  const double half_right = std::atan(std::tan(half_up) * view.width_over_height);
  const auto wider = [&](double half) {
    return std::min(half + 0.5 * view.wider_deg * kRadians, 0.5 * kWidestDeg * kRadians);
  };
  const double up = wider(half_up), right = wider(half_right);
  return {std::sin(right) * axes.forward + std::cos(right) * axes.right,
          std::sin(right) * axes.forward - std::cos(right) * axes.right,
          std::sin(up) * axes.forward + std::cos(up) * axes.up,
          std::sin(up) * axes.forward - std::cos(up) * axes.up};
}

bool is_seen(const Box& from_eye, const std::array<Vec3d, 4>& planes) {
  for (const Vec3d& n : planes) {
    const Vec3d farthest{n.x > 0.0 ? from_eye.high.x : from_eye.low.x,
                         n.y > 0.0 ? from_eye.high.y : from_eye.low.y,
                         n.z > 0.0 ? from_eye.high.z : from_eye.low.z};
    if (dot(n, farthest) < 0.0) return false;
  }
  return true;
}

double distance(const Box& from_eye) {
  const auto gap = [](double low, double high) { return std::max({low, -high, 0.0}); };
  return norm(Vec3d{gap(from_eye.low.x, from_eye.high.x), gap(from_eye.low.y, from_eye.high.y),
                    gap(from_eye.low.z, from_eye.high.z)});
}

class Chooser {
 public:
  Chooser(const PyramidGrid& grid, const TileView& view, std::size_t limit)
      : grid_(grid),
        view_(view),
        limit_(limit),
        planes_(side_planes(view)),
        pixel_(2.0 * std::tan(0.5 * view.camera.field_of_view_deg * kRadians) /
               view.height_pixels) {}

  /// False where there are more than `limit` tiles whose texels are at most `pixels` large.
  bool choose(double pixels) {
    chosen_.clear();
    return add({grid_.levels - 1, 0, 0}, pixels);
  }

  std::vector<TileKey> sorted() {
    std::stable_sort(chosen_.begin(), chosen_.end(), [](const Chosen& a, const Chosen& b) {
      return a.key.level != b.key.level ? a.key.level > b.key.level : a.distance < b.distance;
    });
    std::vector<TileKey> keys;
    for (const Chosen& chosen : chosen_) keys.push_back(chosen.key);
    return keys;
  }

 private:
  struct Chosen {
    TileKey key;
    double distance;
  };

  Box box_of(TileKey key) const {
    const double x = std::ldexp(grid_.texel_x, key.level) * kTileTexels;
    const double y = std::ldexp(grid_.texel_y, key.level) * kTileTexels;
    const double west = grid_.west + key.column * x, north = grid_.north - key.row * y;
    const Vec3d low{west, std::max(north - y, grid_.south()), view_.lowest_m};
    const Vec3d high{std::min(west + x, grid_.east()), north, view_.highest_m};
    return {low - view_.camera.eye, high - view_.camera.eye};
  }

  bool add(TileKey key, double pixels) {
    const Box box = box_of(key);
    if (!is_seen(box, planes_)) return true;
    if (chosen_.size() == limit_) return false;
    const double away = std::max(distance(box), kNearestM);
    chosen_.push_back({key, away});
    const double texel = std::ldexp(std::max(grid_.texel_x, grid_.texel_y), key.level);
    if (key.level == 0 || texel <= pixels * pixel_ * away) return true;
    for (const int row : {2 * key.row, 2 * key.row + 1})
      for (const int column : {2 * key.column, 2 * key.column + 1}) {
        const TileKey child{key.level - 1, column, row};
        if (column >= grid_.columns(child.level) || row >= grid_.rows(child.level)) continue;
        if (!add(child, pixels)) return false;
      }
    return true;
  }

  const PyramidGrid& grid_;
  const TileView& view_;
  std::size_t limit_;
  std::array<Vec3d, 4> planes_;
  double pixel_;  ///< radians
  std::vector<Chosen> chosen_;
};

}  // namespace

std::vector<TileKey> wanted_tiles(const PyramidGrid& grid, const TileView& view,
                                  std::size_t limit) {
  Chooser chooser(grid, view, std::max<std::size_t>(limit, 1));
  double pixels = 1.0;
  // Ends: the coarsest level is one tile, and that always fits.
  while (!chooser.choose(pixels)) pixels *= kCoarser;
  return chooser.sorted();
}

}  // namespace cornice::viewer
