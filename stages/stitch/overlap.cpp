// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/stitch/overlap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "core/mesh/select.h"

namespace cornice::stitch {
namespace {

/// Boxes that share less than this, either way, are those of neighbours.
constexpr double kLeastM = 1.0;
constexpr double kLeastCellM = 0.5;
constexpr int kMostCells = 128;
/// Surfaces farther apart are not the same ground: an overhang above the ground of the next tile.
constexpr double kSameGroundM = 1.0;
constexpr double kPlaneGridM = 1.0 / 1024.0;
/// Part of an edge.
constexpr float kBesideEnd = 0.2f;

double along(Vec3d p, int axis) { return axis == 0 ? p.x : p.y; }

int cells(double length_m) {
  return std::clamp(static_cast<int>(length_m / kLeastCellM), 1, kMostCells);
}

/// Twice the area of (a, b, p) in plan, positive where p lies to the left.
double side(Vec3d a, Vec3d b, double x, double y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

/// Cuts a mesh along one plane.
class Cutter {
 public:
  Cutter(const Mesh& mesh, const Cut& cut)
      : mesh_(mesh),
        cut_(cut),
        at_(static_cast<float>(cut.at - along(mesh.origin, cut.axis))),
        result_(mesh) {
    result_.triangles.clear();
    put_near_vertices_on_plane();
  }

  Mesh run() {
    for (const auto& t : mesh_.triangles) add(t);
    const std::vector<std::uint8_t> all(result_.triangles.size(), 1);
    return select_triangles(result_, all);
  }

 private:
  /// Above 0 on the side that is kept, 0 on the plane.
  float beyond(std::uint32_t v) const {
    const Vec3f& p = result_.positions[v];
    const float x = cut_.axis == 0 ? p.x : p.y;
    return cut_.keeps_below ? at_ - x : x - at_;
  }

  /// An edge that would be cut beside its end has that end on the plane: no slivers.
  void put_near_vertices_on_plane() {
    std::vector<std::uint32_t> near;
    for (const auto& t : mesh_.triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        const float from = beyond(t[k]), to = beyond(t[(k + 1) % 3]);
        if (from * to >= 0.0f) continue;
        const float share = from / (from - to);
        if (share < kBesideEnd) near.push_back(t[k]);
        if (share > 1.0f - kBesideEnd) near.push_back(t[(k + 1) % 3]);
      }
    }
    for (const std::uint32_t v : near) {
      (cut_.axis == 0 ? result_.positions[v].x : result_.positions[v].y) = at_;
    }
  }

  void add(const std::array<std::uint32_t, 3>& t) {
    std::array<std::uint32_t, 4> corners{};
    std::size_t count = 0;
    bool any = false;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      const float from = beyond(a), to = beyond(b);
      any = any || from > 0.0f;
      if (from >= 0.0f) corners[count++] = a;
      if ((from > 0.0f && to < 0.0f) || (from < 0.0f && to > 0.0f)) corners[count++] = split(a, b);
    }
    if (!any) return;
    for (std::size_t k = 2; k < count; ++k) {
      result_.triangles.push_back({corners[0], corners[k - 1], corners[k]});
    }
  }

  /// The vertex in which the plane cuts an edge, the same from both of its triangles.
  std::uint32_t split(std::uint32_t a, std::uint32_t b) {
    if (a > b) std::swap(a, b);
    const auto next = static_cast<std::uint32_t>(result_.positions.size());
    const auto [known, is_new] = made_.emplace(std::uint64_t{a} << 32 | b, next);
    if (!is_new) return known->second;
    const float t = beyond(a) / (beyond(a) - beyond(b));
    const auto mix = [&](auto from, auto to) { return from * (1.0f - t) + to * t; };
    Vec3f p = mix(result_.positions[a], result_.positions[b]);
    (cut_.axis == 0 ? p.x : p.y) = at_;
    result_.positions.push_back(p);
    if (!mesh_.normals.empty()) {
      result_.normals.push_back(normalized(mix(mesh_.normals[a], mesh_.normals[b])));
    }
    for (FloatProperty& f : result_.float_properties) {
      f.values.push_back(f.values[a] == f.values[b] ? f.values[a] : mix(f.values[a], f.values[b]));
    }
    for (ByteProperty& f : result_.byte_properties) {
      f.values.push_back(std::max(f.values[a], f.values[b]));
    }
    return next;
  }

  const Mesh& mesh_;
  Cut cut_;
  float at_;
  Mesh result_;
  std::unordered_map<std::uint64_t, std::uint32_t> made_;
};

}  // namespace

Heights::Heights(const Box2d& area)
    : area_(area), columns_(cells(area.width())), rows_(cells(area.height())) {
  width_m_ = area.width() / columns_;
  height_m_ = area.height() / rows_;
  z_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_),
            std::numeric_limits<float>::quiet_NaN());
}

void Heights::add(const Mesh& mesh) {
  const auto cell = [](double at, double first, double size, int count) {
    return std::clamp(static_cast<int>(std::ceil((at - first) / size - 0.5)), 0, count);
  };
  for (const auto& t : mesh.triangles) {
    std::array<Vec3d, 3> p;
    Box2d box;
    for (std::size_t k = 0; k < 3; ++k) {
      p[k] = mesh.origin + mesh.positions[t[k]].cast<double>();
      box.add(p[k].x, p[k].y);
    }
    const double area = side(p[0], p[1], p[2].x, p[2].y);
    if (area == 0.0 || !box.intersects(area_)) continue;
    for (int j = cell(box.min_y, area_.min_y, height_m_, rows_);
         j < cell(box.max_y, area_.min_y, height_m_, rows_); ++j) {
      for (int i = cell(box.min_x, area_.min_x, width_m_, columns_);
           i < cell(box.max_x, area_.min_x, width_m_, columns_); ++i) {
        const double x = area_.min_x + (i + 0.5) * width_m_,
                     y = area_.min_y + (j + 0.5) * height_m_;
        const double u = side(p[1], p[2], x, y) / area, v = side(p[2], p[0], x, y) / area;
        if (u < 0.0 || v < 0.0 || u + v > 1.0) continue;
        const auto z = static_cast<float>(u * p[0].z + v * p[1].z + (1.0 - u - v) * p[2].z);
        float& highest = z_[static_cast<std::size_t>(j * columns_ + i)];
        if (!(highest >= z)) highest = z;
      }
    }
  }
}

double Heights::area_shared_with(const Heights& other) const {
  std::size_t count = 0;
  for (std::size_t i = 0; i < z_.size(); ++i) {
    count += std::abs(static_cast<double>(z_[i]) - static_cast<double>(other.z_[i])) < kSameGroundM;
  }
  return static_cast<double>(count) * width_m_ * height_m_;
}

Box2d shared_area(const Box3d& a, const Box3d& b) {
  if (a.empty() || b.empty()) return {};
  const Box2d shared{std::max(a.min.x, b.min.x), std::max(a.min.y, b.min.y),
                     std::min(a.max.x, b.max.x), std::min(a.max.y, b.max.y)};
  return std::min(shared.max_x - shared.min_x, shared.max_y - shared.min_y) < kLeastM ? Box2d{}
                                                                                      : shared;
}

bool cut_apart(const Box3d& a, const Box3d& b, Cut& cut_a, Cut& cut_b) {
  const Box2d shared = shared_area(a, b);
  const int axis = shared.width() <= shared.height() ? 0 : 1;
  const double low = std::max(along(a.min, axis), along(b.min, axis));
  const double high = std::min(along(a.max, axis), along(b.max, axis));
  const double smaller =
      std::min(along(a.max, axis) - along(a.min, axis), along(b.max, axis) - along(b.min, axis));
  if (high - low > 0.5 * smaller) return false;
  const double middle = std::round(0.5 * (low + high) / kPlaneGridM) * kPlaneGridM;
  const bool a_is_below = along(a.min, axis) < along(b.min, axis);
  cut_a = {axis, middle, a_is_below};
  cut_b = {axis, middle, !a_is_below};
  return true;
}

Mesh cut_mesh(const Mesh& mesh, std::span<const Cut> cuts) {
  Mesh result = mesh;
  for (const Cut& cut : cuts) result = Cutter(result, cut).run();
  return result;
}

}  // namespace cornice::stitch
