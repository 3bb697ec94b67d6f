// SPDX-License-Identifier: GPL-3.0-or-later
#include "terrain-viewer/app/viewpoint.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

namespace cornice::viewer {
namespace {

constexpr double kRadians = std::numbers::pi / 180.0;
constexpr double kOverviewFieldDeg = 30.0, kCloseFieldDeg = 40.0;
constexpr double kOverviewMargin = 0.03, kCloseMargin = 0.1;
/// Pitch of overviews: from kFlatPitchDeg, of flat ground, up by this much for each metre of height
/// over a metre of extent.
constexpr double kFlatPitchDeg = -45.0, kReliefPitchDeg = 55.0, kLevelPitchDeg = -20.0;
/// They look down more steeply, up to kSteepestPitchDeg, while backs are more than this share of
/// what is seen: slopes that fall away from the viewer show their underside at the survey's edge.
constexpr double kSteepestPitchDeg = -60.0, kBackShare = 0.1;
/// Side of the steepest part: a share of the extent, within limits.
constexpr double kPartShare = 1.0 / 6.0, kPartLeastM = 25.0, kPartMostM = 250.0;
/// What counts as steep in it.
constexpr double kSteepZ = 0.7071;
/// What close views are weighed by: how squarely the steep part faces the eye counts 1; emptiness
/// past the survey's edge, in the foreground most, takes more from that than a slanting view does;
/// so does, from kGentlePitchDeg on, looking down, which shows no relief.
constexpr double kVoidWeight = 2.0, kHiddenWeight = 1.0, kDownWeight = 0.5, kGentlePitchDeg = -30.0;

Box3d box_of(const std::vector<Facet>& facets) {
  Box3d box;
  for (const Facet& facet : facets) box.add(facet.centre);
  return box;
}

std::vector<Vec3d> centres_of(const std::vector<Facet>& facets) {
  std::vector<Vec3d> centres;
  centres.reserve(facets.size());
  for (const Facet& facet : facets) centres.push_back(facet.centre);
  return centres;
}

/// Solid angles that facets would fill if nothing hid them: those that face the eye, and the
/// undersides of those that do not.
struct Seen {
  double faces = 0.0, backs = 0.0;
};

Seen seen_from(const std::vector<Facet>& facets, Vec3d eye) {
  Seen seen;
  for (const Facet& facet : facets) {
    const Vec3d way = eye - facet.centre;
    const double distance = norm(way);
    const double angle = facet.area_m2 * dot(facet.normal, way) / (distance * distance * distance);
    (angle > 0.0 ? seen.faces : seen.backs) += std::abs(angle);
  }
  return seen;
}

/// Sums over the squares of a grid in plan.
class Grid {
 public:
  Grid(const Box3d& box, double side) : lowest_(box.min), side_(side) {
    columns_ = 1 + static_cast<int>((box.max.x - box.min.x) / side);
    rows_ = 1 + static_cast<int>((box.max.y - box.min.y) / side);
    const auto count = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
    steep_.assign(count, 0.0);
    top_.assign(count, -std::numeric_limits<double>::infinity());
  }
  void add(const Facet& facet) {
    const std::size_t at = index(column(facet.centre.x), row(facet.centre.y));
    steep_[at] += facet.area_m2 * (1.0 - facet.normal.z);
    top_[at] = std::max(top_[at], facet.centre.z);
  }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  int column(double x) const { return static_cast<int>(std::floor((x - lowest_.x) / side_)); }
  int row(double y) const { return static_cast<int>(std::floor((y - lowest_.y) / side_)); }
  double steep(int c, int r) const { return is_inside(c, r) ? steep_[index(c, r)] : 0.0; }
  bool contains(Vec3d p) const { return is_inside(column(p.x), row(p.y)); }
  /// The highest there; minus infinity where there is nothing.
  double top(int c, int r) const {
    return is_inside(c, r) ? top_[index(c, r)] : -std::numeric_limits<double>::infinity();
  }

 private:
  bool is_inside(int c, int r) const { return c >= 0 && r >= 0 && c < columns_ && r < rows_; }
  std::size_t index(int c, int r) const {
    return static_cast<std::size_t>(r) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(c);
  }
  Vec3d lowest_;
  double side_;
  int columns_ = 0, rows_ = 0;
  std::vector<double> steep_, top_;
};

struct Part {
  int column = 0, row = 0;
};

bool has_ground_around(const Grid& grid, int c, int r) {
  for (int y = r - 1; y <= r + 2; ++y)
    for (int x = c - 1; x <= c + 2; ++x)
      if (!std::isfinite(grid.top(x, y))) return false;
  return true;
}

/// The lower left of the 2 x 2 squares that are steepest together.
Part steepest_part(const Grid& grid) {
  Part best;
  double most = -1.0;
  for (const bool inside_only : {true, false}) {
    for (int r = 0; r < grid.rows(); ++r) {
      for (int c = 0; c < grid.columns(); ++c) {
        if (inside_only && !has_ground_around(grid, c, r)) continue;
        const double sum = grid.steep(c, r) + grid.steep(c + 1, r) + grid.steep(c, r + 1) +
                           grid.steep(c + 1, r + 1);
        if (sum > most) {
          most = sum;
          best = {c, r};
        }
      }
    }
    if (most >= 0.0) break;
  }
  return best;
}

/// Whether the ground leaves the line from the eye to the target free but for its last sixth.
bool is_free(const Grid& ground, Vec3d eye, Vec3d target, double clearance_m) {
  constexpr int kSteps = 60;
  for (int i = 0; i < kSteps * 5 / 6; ++i) {
    const Vec3d p = eye + double(i) / kSteps * (target - eye);
    const int c = ground.column(p.x), r = ground.row(p.y);
    if (p.z < ground.top(c, r) + clearance_m) return false;
  }
  return true;
}

/// The share of a picture below the horizon where there is no ground, the foreground counted up to
/// twice. Rays are followed for `reach_m`; what is farther is not missed.
double empty_share(const Grid& ground, double lowest_z, double step_m, double reach_m,
                   const Camera& camera, double width_over_height) {
  constexpr int kColumns = 16, kRows = 10;
  const CameraAxes axes = axes_of(camera);
  const double up = std::tan(0.5 * camera.field_of_view_deg * kRadians);
  const auto meets_ground = [&](Vec3d way) {
    for (double t = 0.0; t < reach_m; t += step_m) {
      const Vec3d p = camera.eye + t * way;
      if (p.z < ground.top(ground.column(p.x), ground.row(p.y))) return true;
      if (p.z < lowest_z) return false;
    }
    return ground.contains(camera.eye + reach_m * way);
  };
  double empty = 0.0;
  for (int row = 0; row < kRows; ++row) {
    const double y = 1.0 - 2.0 * (row + 0.5) / kRows;
    for (int column = 0; column < kColumns; ++column) {
      const double x = (2.0 * (column + 0.5) / kColumns - 1.0) * width_over_height;
      const Vec3d way = normalized(axes.forward + up * x * axes.right + up * y * axes.up);
      if (way.z < 0.0 && !meets_ground(way)) empty += 1.0 - y;
    }
  }
  return empty / (kColumns * kRows);
}

/// The steepest part of a survey.
struct Wall {
  std::vector<Vec3d> points;
  Vec3d outward, target;  ///< where it faces, about; its middle
  double area_m2 = 0.0;   ///< of what is steep in it
};

constexpr double weight_of(const Facet& facet) {
  return facet.area_m2 * (facet.normal.z < kSteepZ ? 1.0 : 1e-3);
}

Wall steepest_wall(const std::vector<Facet>& facets, const Grid& halves, Vec3d near) {
  const Part part = steepest_part(halves);
  Wall wall;
  for (const Facet& facet : facets) {
    const int c = halves.column(facet.centre.x) - part.column;
    const int r = halves.row(facet.centre.y) - part.row;
    if (c < 0 || c > 1 || r < 0 || r > 1) continue;
    const double weight = weight_of(facet);
    wall.points.push_back(facet.centre);
    wall.outward += weight * Vec3d{facet.normal.x, facet.normal.y, facet.normal.z};
    wall.target += weight * (facet.centre - near);
    wall.area_m2 += weight;
  }
  wall.target = near + wall.target / wall.area_m2;
  wall.outward = wall.outward / wall.area_m2;
  return wall;
}

}  // namespace

std::vector<Facet> facets_of(const hlod::File& file, std::uint64_t most) {
  int level = 0;
  for (std::size_t l = 0; l < file.levels().size(); ++l)
    if (file.levels()[l].triangles <= most) level = static_cast<int>(l);
  const hlod::Lattice& lattice = file.header().lattice;
  std::vector<Facet> facets;
  for (const hlod::Node& node : file.nodes()) {
    if (node.key.level != level) continue;
    const hlod::CellMesh mesh = file.read(node);
    for (const auto& triangle : mesh.triangles) {
      std::array<Vec3d, 3> p;
      for (std::size_t k = 0; k < 3; ++k)
        p[k] = lattice.position(mesh.vertices[triangle[k]].position, level);
      const Vec3d twice = cross(p[1] - p[0], p[2] - p[0]);
      if (norm(twice) > 0.0)
        facets.push_back({(p[0] + p[1] + p[2]) / 3.0, normalized(twice), 0.5 * norm(twice)});
    }
  }
  return facets;
}

Camera fitted(const Camera& camera, const std::vector<Vec3d>& points, double width_over_height,
              double margin) {
  assert(!points.empty());
  const CameraAxes axes = axes_of(camera);
  const double up = std::tan(0.5 * camera.field_of_view_deg * kRadians) * (1.0 - 2.0 * margin);
  const double across = up * width_over_height;
  // A point at (r, u, f) of the camera's frame is inside where |r - x| <= across * (f + d), for an
  // eye at x to the right and d behind; the four sides are the largest of four sums.
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  double right = kNone, left = kNone, upper = kNone, lower = kNone;
  for (const Vec3d& point : points) {
    const Vec3d way = point - points.front();
    const double r = dot(way, axes.right), u = dot(way, axes.up), f = dot(way, axes.forward);
    right = std::max(right, r - across * f);
    left = std::max(left, -r - across * f);
    upper = std::max(upper, u - up * f);
    lower = std::max(lower, -u - up * f);
  }
  const double back =
      std::max({(right + left) / (2.0 * across), (upper + lower) / (2.0 * up), 1.0});
  Camera moved = camera;
  moved.eye = points.front() + 0.5 * (right - left) * axes.right + 0.5 * (upper - lower) * axes.up -
              back * axes.forward;
  return moved;
}

Camera overview(const std::vector<Facet>& facets, double width_over_height) {
  assert(!facets.empty());
  const Box3d box = box_of(facets);
  const std::vector<Vec3d> centres = centres_of(facets);
  const double extent = std::max({1e-3, box.max.x - box.min.x, box.max.y - box.min.y});
  const double relief = (box.max.z - box.min.z) / extent;
  Camera camera, best;
  camera.field_of_view_deg = kOverviewFieldDeg;
  double pitch = std::min(kLevelPitchDeg, kFlatPitchDeg + kReliefPitchDeg * relief);
  for (;; pitch -= 8.0) {
    camera.pitch_deg = std::max(pitch, kSteepestPitchDeg);
    double most = -std::numeric_limits<double>::infinity();
    bool shows_little_back = false;
    for (int heading = 0; heading < 360; heading += 15) {
      camera.heading_deg = heading;
      camera = fitted(camera, centres, width_over_height, kOverviewMargin);
      const Seen seen = seen_from(facets, camera.eye);
      if (seen.faces - seen.backs <= most) continue;
      most = seen.faces - seen.backs;
      shows_little_back = seen.backs <= kBackShare * seen.faces;
      best = camera;
    }
    if (shows_little_back || pitch <= kSteepestPitchDeg) return best;
  }
}

Camera steepest_view(const std::vector<Facet>& facets, double width_over_height) {
  assert(!facets.empty());
  const Box3d box = box_of(facets);
  const double extent = std::max(box.max.x - box.min.x, box.max.y - box.min.y);
  const double side = std::clamp(kPartShare * extent, kPartLeastM, kPartMostM);
  Grid halves(box, 0.5 * side), ground(box, 0.1 * side);
  for (const Facet& facet : facets) {
    halves.add(facet);
    ground.add(facet);
  }
  const Wall wall = steepest_wall(facets, halves, box.min);
  const Vec3d front{-wall.outward.x, -wall.outward.y, 0.0};
  const Camera ahead = looking_at({}, Vec3d{}, norm(front) > 1e-6 ? front : Vec3d{0, 1, 0});
  const double step = 0.1 * side, reach = 40.0 * side;
  Camera best;
  double most = -std::numeric_limits<double>::infinity();
  for (const double aside : {0.0, -30.0, 30.0, -60.0, 60.0}) {
    for (double pitch = -5.0; pitch >= -75.0; pitch -= 5.0) {
      Camera camera{{}, ahead.heading_deg + aside, pitch, kCloseFieldDeg};
      camera = fitted(camera, wall.points, width_over_height, kCloseMargin);
      const double down = std::max(0.0, kGentlePitchDeg - pitch) / 90.0;
      double good = -dot(wall.outward, axes_of(camera).forward) - kDownWeight * down;
      if (!is_free(ground, camera.eye, wall.target, 0.02 * side)) good -= kHiddenWeight;
      if (good <= most) continue;
      good -= kVoidWeight *
              empty_share(ground, box.min.z - step, step, reach, camera, width_over_height);
      if (good <= most) continue;
      most = good;
      best = camera;
    }
  }
  return best;
}

double sun_azimuth_for(const Camera& camera) {
  return std::fmod(camera.heading_deg + 240.0, 360.0);
}

}  // namespace cornice::viewer
