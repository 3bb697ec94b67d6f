// SPDX-License-Identifier: GPL-3.0-or-later
// Points are sorted into square columns as wide as the density's radius. Most vertices lie closer
// to a point than that and look at nine columns, three runs of memory. The others go outwards over
// blocks of columns and pass over those whose box, heights included, is too far away.
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
constexpr int kStripes = 8;
constexpr int kBlock = 8;  ///< columns of a block, per axis
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
  /// Of points; empty until something is added.
  struct Heights {
    float low = std::numeric_limits<float>::infinity();
    float high = -std::numeric_limits<float>::infinity();
    void add(Heights o) { low = std::min(low, o.low), high = std::max(high, o.high); }
  };
  static int blocks(int columns) { return (columns + kBlock - 1) / kBlock; }
  std::size_t block_index(int x, int y) const {
    return static_cast<std::size_t>(x) * static_cast<std::size_t>(blocks(columns_y_)) +
           static_cast<std::size_t>(y);
  }
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
  void find_heights();
  void scan(Vec3f at, std::size_t begin, std::size_t end, Nearby& nearby) const;
  void scan_column(Vec3f at, std::size_t column, float reach, Nearby& nearby) const;
  float least_to(Vec3f at, int x, int y, int count, Heights heights) const;
  void look_in_block(Vec3f at, int block_x, int block_y, Nearby& nearby) const;
  void look_far(Vec3f at, Column centre, Nearby& nearby) const;

  Vec3d shift_;  ///< from the points' origin to the mesh's
  float radius_;
  float width_ = 0.0f;  ///< of a column; at least the radius
  float per_m_ = 0.0f;
  float low_x_ = 0.0f, low_y_ = 0.0f;
  int columns_x_ = 0, columns_y_ = 0;
  std::vector<std::uint32_t> first_;  ///< by column; one more at the end
  std::vector<Heights> heights_;      ///< by column
  std::vector<Heights> block_heights_;
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
  find_heights();
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

/// Heights of the points of every column, and of every block.
void PointColumns::find_heights() {
  heights_.assign(index(columns_x_, 0), Heights{});
  block_heights_.assign(static_cast<std::size_t>(blocks(columns_x_) * blocks(columns_y_)),
                        Heights{});
  for (int x = 0; x < columns_x_; ++x) {
    for (int y = 0; y < columns_y_; ++y) {
      const std::size_t c = index(x, y);
      for (std::size_t p = first_[c]; p < first_[c + 1]; ++p) heights_[c].add({z_[p], z_[p]});
      block_heights_[block_index(x / kBlock, y / kBlock)].add(heights_[c]);
    }
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

/// Least squared distance from a place to anything in the columns [x, x + count) x [y, y + count)
/// between these heights; infinite where there is nothing.
float PointColumns::least_to(Vec3f at, int x, int y, int count, Heights heights) const {
  const auto outside = [](float value, float low, float high) {
    return std::max({low - value, value - high, 0.0f});
  };
  const float size = static_cast<float>(count) * width_;
  const float low_x = low_x_ + static_cast<float>(x) * width_;
  const float low_y = low_y_ + static_cast<float>(y) * width_;
  // A little less than it is: columns are told from rounded products.
  const float slack = 0.001f * width_;
  const float dx = std::max(outside(at.x, low_x, low_x + size) - slack, 0.0f);
  const float dy = std::max(outside(at.y, low_y, low_y + size) - slack, 0.0f);
  const float dz = outside(at.z, heights.low, heights.high);
  return dx * dx + dy * dy + dz * dz;
}

void PointColumns::look_in_block(Vec3f at, int block_x, int block_y, Nearby& nearby) const {
  const Heights heights = block_heights_[block_index(block_x, block_y)];
  const int x0 = block_x * kBlock, y0 = block_y * kBlock;
  if (least_to(at, x0, y0, kBlock, heights) >= nearby.least_sq) return;
  for (int x = x0; x < std::min(x0 + kBlock, columns_x_); ++x) {
    for (int y = y0; y < std::min(y0 + kBlock, columns_y_); ++y) {
      const std::size_t c = index(x, y);
      if (least_to(at, x, y, 1, heights_[c]) >= nearby.least_sq) continue;
      scan_column(at, c, std::sqrt(nearby.least_sq), nearby);
    }
  }
}

/// Looks at all blocks that can hold a nearer point, from the inside outwards.
void PointColumns::look_far(Vec3f at, Column centre, Nearby& nearby) const {
  const int block_x = centre.x / kBlock, block_y = centre.y / kBlock;
  const int last_x = blocks(columns_x_) - 1, last_y = blocks(columns_y_) - 1;
  for (int ring = 0;; ++ring) {
    const float nearest = static_cast<float>((ring - 1) * kBlock) * width_;
    if (ring > 0 && nearest * nearest >= nearby.least_sq) break;
    for (int x = block_x - ring; x <= block_x + ring; ++x) {
      const bool whole = x == block_x - ring || x == block_x + ring;
      for (int y = block_y - ring; y <= block_y + ring; y += whole || ring == 0 ? 1 : 2 * ring) {
        if (x < 0 || x > last_x || y < 0 || y > last_y) continue;
        look_in_block(at, x, y, nearby);
      }
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
  // Nothing beyond the nine columns is as near as this.
  if (nearby.least_sq <= 0.998f * width_ * width_) return nearby;
  const std::uint32_t count = nearby.count;
  look_far(at, centre, nearby);
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
