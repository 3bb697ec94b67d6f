// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/mesh/quality.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/parallel.h"

namespace cornice {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

struct Sums {
  QualityReport report;
  double angles = 0.0;
  double ratios = 0.0;
};

void add_triangle(Sums& sums, Vec3d a, Vec3d b, Vec3d c) {
  QualityReport& r = sums.report;
  const double angle = smallest_angle_deg(a, b, c);
  const double ratio = radius_ratio(a, b, c);
  ++r.triangles;
  sums.angles += angle;
  sums.ratios += ratio;
  r.smallest_angle_deg = std::min(r.smallest_angle_deg, angle);
  r.smallest_radius_ratio = std::min(r.smallest_radius_ratio, ratio);
  r.below_20_deg += angle < 20.0;
  r.without_area += angle < 0.01;
  for (const double length : {norm(b - a), norm(c - b), norm(a - c)}) {
    r.shortest_edge_m = std::min(r.shortest_edge_m, length);
    r.longest_edge_m = std::max(r.longest_edge_m, length);
  }
}

Sums empty_sums() {
  Sums sums;
  sums.report.smallest_angle_deg = 180.0;
  sums.report.smallest_radius_ratio = 1.0;
  sums.report.shortest_edge_m = std::numeric_limits<double>::infinity();
  return sums;
}

}  // namespace

double smallest_angle_deg(Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d ab = b - a, bc = c - b, ca = a - c;
  const double area2 = norm(cross(ab, ca));
  // atan2 of sine and cosine times the same two lengths: exact for thin triangles too.
  const double at_a = std::atan2(area2, -dot(ab, ca));
  const double at_b = std::atan2(area2, -dot(bc, ab));
  const double at_c = std::atan2(area2, -dot(ca, bc));
  return std::min({at_a, at_b, at_c}) * kDegrees;
}

double radius_ratio(Vec3d a, Vec3d b, Vec3d c) {
  const double la = norm(b - c), lb = norm(c - a), lc = norm(a - b);
  const double product = la * lb * lc;
  if (product <= 0.0) return 0.0;
  const double area2 = norm(cross(b - a, c - a));
  // r = area2 / (la + lb + lc), R = la lb lc / (2 area2).
  return 4.0 * area2 * area2 / ((la + lb + lc) * product);
}

QualityReport measure_quality(const std::vector<Vec3f>& positions,
                              const std::vector<Triangle>& triangles, int threads,
                              const std::vector<std::uint8_t>& chosen) {
  Sums all = parallel_reduce(
      triangles.size(), 1u << 15, threads, empty_sums(),
      [&](std::size_t begin, std::size_t end) {
        Sums part = empty_sums();
        for (std::size_t t = begin; t < end; ++t) {
          if (!chosen.empty() && chosen[t] == 0) continue;
          const Triangle& corner = triangles[t];
          add_triangle(part, positions[corner[0]].cast<double>(),
                       positions[corner[1]].cast<double>(), positions[corner[2]].cast<double>());
        }
        return part;
      },
      [](Sums& total, const Sums& part) {
        QualityReport& r = total.report;
        const QualityReport& p = part.report;
        r.triangles += p.triangles;
        r.below_20_deg += p.below_20_deg;
        r.without_area += p.without_area;
        r.smallest_angle_deg = std::min(r.smallest_angle_deg, p.smallest_angle_deg);
        r.smallest_radius_ratio = std::min(r.smallest_radius_ratio, p.smallest_radius_ratio);
        r.shortest_edge_m = std::min(r.shortest_edge_m, p.shortest_edge_m);
        r.longest_edge_m = std::max(r.longest_edge_m, p.longest_edge_m);
        total.angles += part.angles;
        total.ratios += part.ratios;
      });
  QualityReport& r = all.report;
  if (r.triangles == 0) return {};
  r.mean_smallest_angle_deg = all.angles / static_cast<double>(r.triangles);
  r.mean_radius_ratio = all.ratios / static_cast<double>(r.triangles);
  return r;
}

}  // namespace cornice
