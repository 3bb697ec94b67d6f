// SPDX-License-Identifier: GPL-3.0-or-later
// Points are sorted into square columns as wide as the density's radius. Most vertices lie closer
// to a point than that and look at nine columns, three runs of memory. The others go outwards ring
// by ring, from the first ring that holds a point, which a distance transform of the columns tells.
#include "stages/poisson/support.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "core/base/parallel.h"

namespace cornice {
namespace {

constexpr std::size_t kPointsAtATime = 1 << 16;
constexpr std::size_t kVerticesAtATime = 4096;
constexpr std::uint32_t kNoColumn = 0xffffffffu;
/// Columns with more points than this (walls) are sorted by height and searched in a window.
constexpr std::size_t kTallColumn = 96;
/// More columns than this are made wider.
constexpr double kMostColumns = 1 << 26;
constexpr int kStripes = 16;
constexpr int kLanes = 8;

/// Least squared distance so far, and how many points lie within the radius.
struct Nearby {
  float least_sq;
  std::uint32_t count = 0;
};

class PointColumns {
 public:
  PointColumns(const Mesh& mesh, const OrientedPoints& points, const SupportOptions& options,
               Progress& progress);

  /// Of a place relative to the mesh's origin. `within_m`: a bound that the distance is known to
  /// keep, or the cap.
  Nearby look(Vec3f at, float within_m) const;
  float radius() const { return radius_; }

 private:
  struct Column {
    int x, y;
  };
  Column column_of(float x, float y) const {
    return {static_cast<int>((x - low_x_) * per_m_), static_cast<int>((y - low_y_) * per_m_)};
  }
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(x) * static_cast<std::size_t>(columns_y_) +
           static_cast<std::size_t>(y);
  }
  void lay_out(const Mesh& mesh, double margin_m);
  std::vector<std::uint32_t> assign(const OrientedPoints& points, int threads) const;
  void sort_points(const OrientedPoints& points, const std::vector<std::uint32_t>& column_of_point,
                   int threads);
  void sort_tall_columns(int threads);
  void find_rings();
  void scan(Vec3f at, std::size_t begin, std::size_t end, Nearby& nearby) const;
  void scan_column(Vec3f at, std::size_t column, float reach, Nearby& nearby) const;
  void look_in_ring(Vec3f at, Column centre, int ring, float within_m, Nearby& nearby) const;

  Vec3d shift_;  ///< from the points' origin to the mesh's
  float radius_;
  float width_ = 0.0f;  ///< of a column; at least the radius
  float per_m_ = 0.0f;
  float low_x_ = 0.0f, low_y_ = 0.0f;
  int columns_x_ = 0, columns_y_ = 0;
  std::vector<std::uint32_t> first_;  ///< by column; one more at the end
  std::vector<std::uint16_t> ring_;   ///< by column: rings to the nearest that holds a point
  std::vector<float> x_, y_, z_;
};

PointColumns::PointColumns(const Mesh& mesh, const OrientedPoints& points,
                           const SupportOptions& options, Progress& progress)
    : shift_(points.origin - mesh.origin), radius_(static_cast<float>(options.radius_m)) {
  lay_out(mesh, options.cap_m);
  progress.begin("points", 3);
  const std::vector<std::uint32_t> column_of_point = assign(points, options.threads);
  progress.advance(1);
  sort_points(points, column_of_point, options.threads);
  progress.advance(1);
  sort_tall_columns(options.threads);
  find_rings();
  progress.end();
}

void PointColumns::lay_out(const Mesh& mesh, double margin_m) {
  Box2d box;
  for (const Vec3f p : mesh.positions) box.add(p.x, p.y);
  // Two columns more on every side, so that the nine around a vertex are always there.
  double width = radius_;
  const auto columns = [&](double metres) {
    return std::ceil((metres + 2 * margin_m) / width) + 6;
  };
  while (columns(box.width()) * columns(box.height()) > kMostColumns) width *= 2.0;
  width_ = static_cast<float>(width);
  per_m_ = static_cast<float>(1.0 / width);
  columns_x_ = static_cast<int>(columns(box.width()));
  columns_y_ = static_cast<int>(columns(box.height()));
  low_x_ = static_cast<float>(box.min_x - margin_m - 3 * width);
  low_y_ = static_cast<float>(box.min_y - margin_m - 3 * width);
}

std::vector<std::uint32_t> PointColumns::assign(const OrientedPoints& points, int threads) const {
  std::vector<std::uint32_t> column_of_point(points.positions.size());
  const float high_x = low_x_ + width_ * static_cast<float>(columns_x_ - 1);
  const float high_y = low_y_ + width_ * static_cast<float>(columns_y_ - 1);
  parallel_for(
      points.positions.size(), kPointsAtATime, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
          const Vec3f at = (points.positions[p].cast<double>() + shift_).cast<float>();
          const bool inside = at.x >= low_x_ && at.x < high_x && at.y >= low_y_ && at.y < high_y &&
                              std::isfinite(at.z);
          const Column c = inside ? column_of(at.x, at.y) : Column{0, 0};
          column_of_point[p] = inside ? static_cast<std::uint32_t>(index(c.x, c.y)) : kNoColumn;
        }
      });
  return column_of_point;
}

/// A counting sort. Each stripe of columns is filled by one thread, in the order of the points.
void PointColumns::sort_points(const OrientedPoints& points,
                               const std::vector<std::uint32_t>& column_of_point, int threads) {
  const std::size_t columns = index(columns_x_, 0);
  first_.assign(columns + 1, 0);
  const std::size_t stripe = columns / kStripes + 1;
  parallel_for(kStripes, 1, threads, [&](std::size_t s, std::size_t) {
    const std::size_t begin = s * stripe, end = std::min(columns, begin + stripe);
    for (const std::uint32_t c : column_of_point) {
      if (c >= begin && c < end) ++first_[c + 1];
    }
  });
  for (std::size_t c = 0; c < columns; ++c) first_[c + 1] += first_[c];
  for (std::vector<float>* values : {&x_, &y_, &z_}) values->resize(first_[columns]);
  parallel_for(kStripes, 1, threads, [&](std::size_t s, std::size_t) {
    const std::size_t begin = s * stripe, end = std::min(columns, begin + stripe);
    if (begin >= end) return;
    std::vector<std::uint32_t> next(first_.begin() + static_cast<std::ptrdiff_t>(begin),
                                    first_.begin() + static_cast<std::ptrdiff_t>(end));
    for (std::size_t p = 0; p < column_of_point.size(); ++p) {
      const std::uint32_t c = column_of_point[p];
      if (c < begin || c >= end) continue;
      const Vec3f at = (points.positions[p].cast<double>() + shift_).cast<float>();
      const std::uint32_t to = next[c - begin]++;
      x_[to] = at.x, y_[to] = at.y, z_[to] = at.z;
    }
  });
}

void PointColumns::sort_tall_columns(int threads) {
  parallel_for(first_.size() - 1, kPointsAtATime, threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Vec3f> sorted;
    for (std::size_t c = begin; c < end; ++c) {
      if (first_[c + 1] - first_[c] <= kTallColumn) continue;
      sorted.clear();
      for (std::size_t p = first_[c]; p < first_[c + 1]; ++p)
        sorted.push_back({x_[p], y_[p], z_[p]});
      std::sort(sorted.begin(), sorted.end(), [](Vec3f a, Vec3f b) { return a.z < b.z; });
      for (std::size_t i = 0; i < sorted.size(); ++i) {
        const std::size_t p = first_[c] + i;
        x_[p] = sorted[i].x, y_[p] = sorted[i].y, z_[p] = sorted[i].z;
      }
    }
  });
}

/// Chessboard distance of every column to the nearest that holds a point (Rosenfeld & Pfaltz 1966).
void PointColumns::find_rings() {
  constexpr std::uint16_t kFar = std::numeric_limits<std::uint16_t>::max() - 1;
  ring_.assign(index(columns_x_, 0), kFar);
  const auto relax = [&](int x, int y, std::initializer_list<std::array<int, 2>> around) {
    std::uint16_t& ring = ring_[index(x, y)];
    for (const auto& [dx, dy] : around) {
      const int u = x + dx, v = y + dy;
      if (u < 0 || u >= columns_x_ || v < 0 || v >= columns_y_) continue;
      ring =
          std::min(ring, static_cast<std::uint16_t>(std::min<int>(kFar, ring_[index(u, v)] + 1)));
    }
  };
  for (int x = 0; x < columns_x_; ++x) {
    for (int y = 0; y < columns_y_; ++y) {
      const std::size_t c = index(x, y);
      if (first_[c + 1] > first_[c])
        ring_[c] = 0;
      else
        relax(x, y, {{-1, -1}, {-1, 0}, {-1, 1}, {0, -1}});
    }
  }
  for (int x = columns_x_ - 1; x >= 0; --x) {
    for (int y = columns_y_ - 1; y >= 0; --y) relax(x, y, {{1, 1}, {1, 0}, {1, -1}, {0, 1}});
  }
}

/// Eight points at a time, in lanes that the compiler can keep in vectors.
void PointColumns::scan(Vec3f at, std::size_t begin, std::size_t end, Nearby& nearby) const {
  const float radius_sq = radius_ * radius_;
  std::array<float, kLanes> least;
  std::array<std::int32_t, kLanes> count{};
  least.fill(nearby.least_sq);
  const auto squared = [&](std::size_t p) {
    const float dx = x_[p] - at.x, dy = y_[p] - at.y, dz = z_[p] - at.z;
    return dx * dx + dy * dy + dz * dz;
  };
  std::size_t p = begin;
  for (; p + kLanes <= end; p += kLanes) {
    for (std::size_t l = 0; l < kLanes; ++l) {
      const float d = squared(p + l);
      least[l] = d < least[l] ? d : least[l];
      count[l] += d <= radius_sq ? 1 : 0;
    }
  }
  for (std::size_t l = 0; p < end; ++p, ++l) {
    const float d = squared(p);
    least[l] = d < least[l] ? d : least[l];
    count[l] += d <= radius_sq ? 1 : 0;
  }
  for (std::size_t l = 0; l < kLanes; ++l) {
    nearby.least_sq = std::min(nearby.least_sq, least[l]);
    nearby.count += static_cast<std::uint32_t>(count[l]);
  }
}

/// Points of a column that can lie within `reach` of the place.
void PointColumns::scan_column(Vec3f at, std::size_t column, float reach, Nearby& nearby) const {
  const auto z = [&](std::size_t p) { return z_.begin() + static_cast<std::ptrdiff_t>(p); };
  std::size_t begin = first_[column], end = first_[column + 1];
  if (end - begin > kTallColumn) {
    const auto first = std::lower_bound(z(begin), z(end), at.z - reach);
    end = static_cast<std::size_t>(std::upper_bound(first, z(end), at.z + reach) - z_.begin());
    begin = static_cast<std::size_t>(first - z_.begin());
  }
  scan(at, begin, end, nearby);
}

void PointColumns::look_in_ring(Vec3f at, Column centre, int ring, float within_m,
                                Nearby& nearby) const {
  const float reach = std::min(within_m, std::sqrt(nearby.least_sq));
  const int x0 = std::max(centre.x - ring, 0), x1 = std::min(centre.x + ring, columns_x_ - 1);
  const int y0 = std::max(centre.y - ring, 0), y1 = std::min(centre.y + ring, columns_y_ - 1);
  for (int x = x0; x <= x1; ++x) {
    const bool whole_row = x == centre.x - ring || x == centre.x + ring;
    for (int y = whole_row ? y0 : centre.y - ring; y <= y1; y += whole_row ? 1 : 2 * ring) {
      if (y >= y0 && ring_[index(x, y)] == 0) scan_column(at, index(x, y), reach, nearby);
    }
  }
}

Nearby PointColumns::look(Vec3f at, float within_m) const {
  const Column centre = column_of(at.x, at.y);
  Nearby nearby{within_m * within_m};
  for (int x = centre.x - 1; x <= centre.x + 1; ++x) {
    const std::size_t from = index(x, centre.y - 1);
    if (first_[from + 3] - first_[from] <= kTallColumn) {
      scan(at, first_[from], first_[from + 3], nearby);
    } else {
      const float reach = std::max(radius_, std::sqrt(nearby.least_sq));
      for (std::size_t c = from; c < from + 3; ++c) scan_column(at, c, reach, nearby);
    }
  }
  const std::uint32_t count = nearby.count;
  // A point in ring k lies more than k - 1 columns away.
  const int first_ring = std::max<int>(2, ring_[index(centre.x, centre.y)]);
  for (int ring = first_ring;; ++ring) {
    const float nearest = static_cast<float>(ring - 1) * width_;
    if (nearest >= within_m || nearest * nearest >= nearby.least_sq) break;
    look_in_ring(at, centre, ring, within_m, nearby);
  }
  nearby.count = count;
  return nearby;
}

}  // namespace

Support measure_support(const Mesh& mesh, const OrientedPoints& points,
                        const SupportOptions& options, Progress& progress) {
  assert(options.cap_m > 0.0 && options.radius_m > 0.0 && "lengths are above 0");
  Support support;
  support.distance_m.resize(mesh.positions.size());
  support.density.resize(mesh.positions.size());
  if (mesh.positions.empty()) return support;
  const PointColumns columns(mesh, points, options, progress);
  const auto cap = static_cast<float>(options.cap_m);
  const auto per_area =
      static_cast<float>(1.0 / (std::numbers::pi * options.radius_m * options.radius_m));
  progress.begin("support", mesh.positions.size());
  parallel_for(mesh.positions.size(), kVerticesAtATime, options.threads,
               [&](std::size_t begin, std::size_t end) {
                 check_cancelled(progress);
                 // A neighbour's nearest point bounds how far this vertex has to look.
                 float bound = cap;
                 Vec3f before = mesh.positions[begin];
                 for (std::size_t v = begin; v < end; ++v) {
                   const Vec3f at = mesh.positions[v];
                   bound = std::min(cap, 1.0001f * (bound + norm(at - before)));
                   const Nearby nearby = columns.look(at, bound);
                   bound = std::sqrt(nearby.least_sq);
                   before = at;
                   support.distance_m[v] = bound;
                   support.density[v] = static_cast<float>(nearby.count) * per_area;
                 }
                 progress.advance(end - begin);
               });
  progress.end();
  return support;
}

}  // namespace cornice
