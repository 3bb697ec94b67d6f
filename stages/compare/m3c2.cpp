// SPDX-License-Identifier: GPL-3.0-or-later
// After Lague, Brodu, Leroux 2013, "Accurate 3D comparison of complex topography with terrestrial
// laser scanner: application to the Rangitikei canyon (N-Z)", ISPRS Journal 82.
#include "stages/compare/m3c2.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"
#include "stages/compare/point_grid.h"

namespace cornice::compare {
namespace {

constexpr std::size_t kGrain = 512;
/// A plane needs so many points, a mean with its spread so many.
constexpr std::size_t kPlanePoints = 5, kMeanPoints = 4;
constexpr double kNormal95 = 1.96;
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// The normal of the plane through the points within `radius` of p, unit, up; zero where there are
/// too few.
Vec3f plane_normal(const PointGrid& grid, Vec3f p, float radius) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  std::size_t count = 0;
  grid.visit_near(p, radius, [&](std::uint32_t i) {
    const Vec3f off = grid.positions()[i] - p;
    if (dot(off, off) > radius * radius) return;
    const Eigen::Vector3d d(static_cast<double>(off.x), static_cast<double>(off.y),
                            static_cast<double>(off.z));
    sum += d;
    squares += d * d.transpose();
    ++count;
  });
  if (count < kPlanePoints) return {};
  const auto n = static_cast<double>(count);
  const Eigen::Matrix3d covariance = squares / n - sum * sum.transpose() / (n * n);
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  const Eigen::Vector3d axis = solver.eigenvectors().col(0);
  const Vec3f normal = normalized(Vec3d{axis.x(), axis.y(), axis.z()}.cast<float>());
  return normal.z < 0.0f ? -normal : normal;
}

/// Mean and variance along the normal of the points in the cylinder.
struct Along {
  double mean = 0.0, variance = 0.0;
  std::size_t count = 0;
};

Along along_normal(const PointGrid& grid, Vec3f p, Vec3f normal, const M3c2Options& options) {
  const auto radius = static_cast<float>(0.5 * options.projection_scale_m);
  const auto depth = static_cast<float>(options.depth_m);
  // Slice by slice as thick as the cylinder is wide; every point is in one of them.
  const int slices = std::max(1, static_cast<int>(std::ceil(depth / radius)));
  const float thickness = 2.0f * depth / static_cast<float>(slices);
  const float reach = std::sqrt(radius * radius + 0.25f * thickness * thickness);
  double sum = 0.0, sum_sq = 0.0;
  Along result;
  for (int slice = 0; slice < slices; ++slice) {
    const float low = -depth + thickness * static_cast<float>(slice);
    const float high = slice + 1 == slices ? depth : low + thickness;
    grid.visit_near(p + normal * (low + 0.5f * thickness), reach, [&](std::uint32_t i) {
      const Vec3f off = grid.positions()[i] - p;
      const float t = dot(off, normal);
      if (t < low || t >= high || dot(off, off) - t * t > radius * radius) return;
      sum += static_cast<double>(t);
      sum_sq += static_cast<double>(t) * static_cast<double>(t);
      ++result.count;
    });
  }
  if (result.count < kMeanPoints) return {};
  const auto n = static_cast<double>(result.count);
  result.mean = sum / n;
  result.variance = std::max(0.0, (sum_sq - n * result.mean * result.mean) / (n - 1.0));
  return result;
}

/// The first point of each cube.
std::vector<std::uint32_t> core_points(const Surface& a, const Box2d& box, double spacing_m) {
  const PointGrid cubes(a.positions, static_cast<float>(spacing_m));
  std::vector<std::uint32_t> chosen;
  for (std::size_t i = 0; i < cubes.order().size(); ++i) {
    if (!cubes.begins_cube(i)) continue;
    const std::uint32_t v = cubes.order()[i];
    const Vec3d p = a.origin + a.positions[v].cast<double>();
    if (p.x >= box.min_x && p.x < box.max_x && p.y >= box.min_y && p.y < box.max_y) {
      chosen.push_back(v);
    }
  }
  return chosen;
}

}  // namespace

double m3c2_halo_m(const M3c2Options& options) {
  return std::max(0.5 * options.normal_scale_m,
                  std::hypot(options.depth_m, 0.5 * options.projection_scale_m));
}

std::vector<M3c2Point> m3c2_points(const Surface& a, const Surface& b, const Box2d& box,
                                   const M3c2Options& options, int threads) {
  const auto side =
      static_cast<float>(0.5 * std::min(options.normal_scale_m, options.projection_scale_m));
  const PointGrid grid_a(a.positions, side), grid_b(b.positions, side);
  const std::vector<std::uint32_t> chosen = core_points(a, box, options.spacing_m);
  std::vector<M3c2Point> points(chosen.size());
  parallel_for(chosen.size(), kGrain, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      M3c2Point& point = points[c];
      point = {a.positions[chosen[c]], {}, kNone, kNone};
      point.normal =
          plane_normal(grid_a, point.position, static_cast<float>(0.5 * options.normal_scale_m));
      if (point.normal == Vec3f{}) continue;
      if (!a.normals.empty() && dot(point.normal, a.normals[chosen[c]]) < 0.0f) {
        point.normal = -point.normal;
      }
      const Along own = along_normal(grid_a, point.position, point.normal, options);
      const Along other = along_normal(grid_b, point.position, point.normal, options);
      if (own.count == 0 || other.count == 0) continue;
      point.distance_m = static_cast<float>(other.mean - own.mean);
      // Equation (1).
      point.detection_95_m = static_cast<float>(
          kNormal95 * (std::sqrt(own.variance / static_cast<double>(own.count) +
                                 other.variance / static_cast<double>(other.count)) +
                       options.registration_m));
    }
  });
  return points;
}

}  // namespace cornice::compare
