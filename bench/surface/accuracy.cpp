// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/surface/accuracy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/base/parallel.h"
#include "core/mesh/triangle_tree.h"
#include "stages/poisson/support.h"

namespace cornice::bench {
namespace {

constexpr std::size_t kGrain = 4096;

/// Sums of squares and how many, of ground that looks up and of ground that looks down.
struct Sums {
  std::array<double, 2> squares{};
  std::array<std::size_t, 2> count{};

  void add(bool overhang, double square) {
    squares[overhang] += square;
    ++count[overhang];
  }
  double rms(bool overhang) const {
    return count[overhang] == 0
               ? 0.0
               : std::sqrt(squares[overhang] / static_cast<double>(count[overhang]));
  }
};

void join(Sums& sum, const Sums& part) {
  for (const std::size_t i : {0u, 1u}) {
    sum.squares[i] += part.squares[i];
    sum.count[i] += part.count[i];
  }
}

/// Vertices, then centroids.
std::vector<Vec3f> points_of(const Mesh& mesh) {
  std::vector<Vec3f> points = mesh.positions;
  for (const auto& t : mesh.triangles) {
    points.push_back((mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) *
                     (1.0f / 3.0f));
  }
  return points;
}

Support support_at(const std::vector<Vec3f>& places, Vec3d origin, const OrientedPoints& points,
                   double cap_m, int threads) {
  Mesh mesh;
  mesh.origin = origin;
  mesh.positions = places;
  SupportOptions options;
  options.cap_m = cap_m;
  options.threads = threads;
  return measure_support(mesh, points, options);
}

constexpr std::array kDensities{2.0f, 4.0f, 8.0f, 12.0f, 16.0f, 24.0f};  ///< points/m²
constexpr std::array kBends{"concave", "flat", "convex"};
constexpr std::size_t kParts = kDensities.size() + 1 + kBends.size();

std::string part_name(std::size_t part) {
  const auto whole = [](float v) { return std::to_string(static_cast<int>(v)); };
  if (part > kDensities.size()) return kBends[part - kDensities.size() - 1];
  if (part == 0) return "< " + whole(kDensities[0]);
  if (part == kDensities.size()) return ">= " + whole(kDensities.back());
  return whole(kDensities[part - 1]) + "-" + whole(kDensities[part]);
}

std::size_t density_part(float density) {
  return static_cast<std::size_t>(std::upper_bound(kDensities.begin(), kDensities.end(), density) -
                                  kDensities.begin());
}

/// How the normals of the ground spread around a place of it, per metre along two ways across each
/// other: twice the mean curvature, positive on edges that stick out.
double bend(const simulate::Scene& scene, const GroundPoint& at) {
  constexpr double kReachM = 0.5;
  const Vec3d u = normalized(
      cross(at.normal, std::abs(at.normal.z) < 0.9 ? Vec3d{0.0, 0.0, 1.0} : Vec3d{1.0, 0.0, 0.0}));
  double sum = 0.0;
  for (const Vec3d way : {u, cross(at.normal, u)}) {
    const GroundPoint a = nearest_ground(scene, at.at + way * kReachM);
    const GroundPoint b = nearest_ground(scene, at.at - way * kReachM);
    if (a.found && b.found) sum += dot(a.normal - b.normal, way) / (2.0 * kReachM);
  }
  return sum;
}

std::size_t bend_part(double bend) {
  constexpr double kBent = 0.5;  ///< 1/m
  return kDensities.size() + 1 + (bend < -kBent ? 0u : bend > kBent ? 2u : 1u);
}

/// Parts of ground that looks up, then of overhangs.
struct PartSums {
  std::array<std::size_t, 2 * kParts> count{};
  std::array<double, 2 * kParts> sum{}, squares{};

  void add(bool overhang, std::size_t part, double off) {
    const std::size_t at = overhang * kParts + part;
    ++count[at], sum[at] += off, squares[at] += off * off;
  }
  static void join(PartSums& all, const PartSums& part) {
    for (std::size_t p = 0; p < 2 * kParts; ++p)
      all.count[p] += part.count[p], all.sum[p] += part.sum[p], all.squares[p] += part.squares[p];
  }
};

}  // namespace

bool AccuracyJudge::counts(Vec3d p) const {
  return ground_.extent.grown(-options_.border_m).contains(p.x, p.y);
}

AccuracyJudge::AccuracyJudge(const Ground& ground, const AccuracyOptions& options)
    : ground_(ground), options_(options) {
  const Mesh truth = ground.scene->ground_mesh(options.sample_m, ground.extent);
  std::vector<Vec3f> centres;
  std::vector<Sample> all;
  for (const auto& t : truth.triangles) {
    const Vec3f a = truth.positions[t[0]], b = truth.positions[t[1]], c = truth.positions[t[2]];
    const Vec3d turned = cross((b - a).cast<double>(), (c - a).cast<double>());
    const Vec3f centre = (a + b + c) * (1.0f / 3.0f);
    const Vec3d at = truth.origin + centre.cast<double>();
    if (!counts(at)) continue;
    const GroundPoint on_ground = nearest_ground(*ground.scene, at);
    if (!on_ground.found) continue;
    centres.push_back((on_ground.at - truth.origin).cast<float>());
    all.push_back({on_ground.at, 0.5 * norm(turned), on_ground.normal.z < 0.0});
  }
  const std::vector<float> support =
      support_at(centres, truth.origin, ground.points, 2.0 * options.measured_m, options.threads)
          .distance_m;
  for (std::size_t s = 0; s < all.size(); ++s) {
    if (support[s] <= options.measured_m) samples_.push_back(all[s]);
  }
}

void AccuracyJudge::forth(const Mesh& mesh, Accuracy& accuracy) const {
  const std::vector<Vec3f> points = points_of(mesh);
  const std::vector<float> support =
      support_at(points, mesh.origin, ground_.points, 2.0 * options_.measured_m, options_.threads)
          .distance_m;
  const Sums sums = parallel_reduce(
      points.size(), kGrain, options_.threads, Sums{},
      [&](std::size_t begin, std::size_t end) {
        Sums part;
        for (std::size_t p = begin; p < end; ++p) {
          const Vec3d at = mesh.origin + points[p].cast<double>();
          if (support[p] > options_.measured_m || !counts(at)) continue;
          const GroundPoint truth = nearest_ground(*ground_.scene, at);
          const Vec3d off = at - truth.at;
          if (truth.found) part.add(truth.normal.z < 0.0, dot(off, off));
        }
        return part;
      },
      join);
  accuracy.rms = sums.rms(false), accuracy.rms_overhang = sums.rms(true);
  accuracy.samples = sums.count[0], accuracy.overhang_samples = sums.count[1];
}

void AccuracyJudge::back(const Mesh& mesh, Accuracy& accuracy) const {
  const TriangleTree tree(mesh.positions, mesh.triangles, options_.threads);
  NearestQuery query;
  query.max_distance_sq = static_cast<float>(options_.present_m * options_.present_m);
  Sums sums;
  std::array<double, 2> area{}, present{};
  for (const Sample& sample : samples_) {
    const NearestPoint nearest = tree.nearest((sample.at - mesh.origin).cast<float>(), query);
    area[sample.overhang] += sample.area;
    if (!nearest.found()) continue;
    present[sample.overhang] += sample.area;
    sums.add(sample.overhang, nearest.distance_sq);
  }
  accuracy.rms_back = sums.rms(false), accuracy.rms_back_overhang = sums.rms(true);
  accuracy.area_share = area[0] > 0.0 ? present[0] / area[0] : 1.0;
  accuracy.overhang_area_share = area[1] > 0.0 ? present[1] / area[1] : 1.0;
  accuracy.overhang_area_m2 = area[1];
}

Accuracy AccuracyJudge::judge(const Mesh& mesh) const {
  Accuracy accuracy;
  forth(mesh, accuracy);
  back(mesh, accuracy);
  return accuracy;
}

std::vector<ErrorPart> AccuracyJudge::parts(const Mesh& mesh) const {
  const std::vector<Vec3f> points = points_of(mesh);
  const Support support =
      support_at(points, mesh.origin, ground_.points, 2.0 * options_.measured_m, options_.threads);
  const PartSums sums = parallel_reduce(
      points.size(), kGrain, options_.threads, PartSums{},
      [&](std::size_t begin, std::size_t end) {
        PartSums part;
        for (std::size_t p = begin; p < end; ++p) {
          const Vec3d at = mesh.origin + points[p].cast<double>();
          if (support.distance_m[p] > options_.measured_m || !counts(at)) continue;
          const GroundPoint truth = nearest_ground(*ground_.scene, at);
          if (!truth.found) continue;
          const double off = dot(at - truth.at, truth.normal);
          part.add(truth.normal.z < 0.0, density_part(support.density[p]), off);
          part.add(truth.normal.z < 0.0, bend_part(bend(*ground_.scene, truth)), off);
        }
        return part;
      },
      PartSums::join);
  std::vector<ErrorPart> parts;
  for (std::size_t p = 0; p < 2 * kParts; ++p) {
    if (sums.count[p] == 0) continue;
    const auto count = static_cast<double>(sums.count[p]);
    parts.push_back({(p < kParts ? "up " : "over ") + part_name(p % kParts), sums.count[p],
                     std::sqrt(sums.squares[p] / count), sums.sum[p] / count});
  }
  return parts;
}

Mesh dem_mesh(const Ground& ground, double step_m) {
  const Raster dem = ground.scene->ground_dem(step_m, ground.extent);
  Mesh mesh;
  mesh.origin = {dem.west, dem.north, 0.0};
  const auto width = static_cast<std::uint32_t>(dem.width);
  for (int row = 0; row < dem.height; ++row) {
    for (int col = 0; col < dem.width; ++col) {
      mesh.positions.push_back({static_cast<float>((col + 0.5) * dem.step),
                                static_cast<float>(-(row + 0.5) * dem.step), dem.at(col, row)});
      if (row + 1 == dem.height || col + 1 == dem.width) continue;
      const auto v = static_cast<std::uint32_t>(row) * width + static_cast<std::uint32_t>(col);
      mesh.triangles.push_back({v, v + width, v + 1});
      mesh.triangles.push_back({v + 1, v + width, v + width + 1});
    }
  }
  return mesh;
}

}  // namespace cornice::bench
